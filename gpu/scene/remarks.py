"""What a reader left out or mended, as sentences for the scene's report."""


class Remarks:
    """Sentences on a file, in order; those of a kind become one that counts them, however odd the file is."""

    NAMED = 6  # places of a kind that are named after the first

    def __init__(self) -> None:
        self._kinds: dict[str, dict[str, str]] = {}

    def add(self, problem: str, place: str = "", kind: str = "") -> None:
        """Note `problem` at `place`, "meshes[2]" or "line 7", once. kind: what merges with it; the problem itself."""
        self._kinds.setdefault(kind or problem, {}).setdefault(place, problem)

    def add_count(self, problem: str, count: int) -> None:
        """Note that `problem` holds `count` times; nothing where that is 0."""
        if count:
            self.add(f"{problem} ({count:,})")

    def sentences(self) -> tuple[str, ...]:
        """One a kind: the first problem in full, then the places of the others."""
        return tuple(self._merged(places) for places in self._kinds.values())

    def _merged(self, places: dict[str, str]) -> str:
        first, *others = places
        sentence = f"{first}: {places[first]}" if first else places[first]
        named, more = others[: self.NAMED], len(others) - self.NAMED
        if others:
            sentence += f" (likewise {', '.join(named)}{f' and {more} more' if more > 0 else ''})"
        return sentence
