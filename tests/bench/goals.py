"""What the project set itself to reach, and whether the rows of results files do. Verdicts are computed. Pure."""

from collections.abc import Iterator
from dataclasses import dataclass

from tests.bench import paper
from tests.bench.rows import Values, default_rows, error_values, indirect_ms, motion_rows, setting_rows, within
from tests.bench.store import Row

# Below the paper's clustering error at its own settings, on its conference room.
PAPER_MSE = tuple(point.mse for point in paper.POINTS["conference"])
STILL_SECONDS, STILL_ERROR = 1.0, 5e-3
# Beyond the reference's own noise, after a second and after ten; energy, and the change of a tile since one frame.
STILL_BEYOND, LONG_BEYOND, STILL_ENERGY, STILL_CHANGE = 1e-3, 2e-4, 0.002, 0.01
# Of a walk's frames, so many are within 10 % of a target that is held.
HELD_SHARE, WITHIN = 0.9, 0.1
LEAST = 1e-30


@dataclass(frozen=True)
class Goal:
    """`what` [unit] is to lie from `low` to `high`, in every scene (or whatever `values` are of)."""

    what: str
    high: float
    values: Values
    low: float = 0.0
    unit: str = ""

    def excess(self, value: float) -> float:
        """How many times too much or too little a value is; at most 1 when it is good enough."""
        return max(value / self.high, self.low / max(value, LEAST))

    def reached(self) -> list[str]:
        """What is good enough."""
        return [name for name, value in self.values.items() if self.excess(value) <= 1.0]

    def missed(self) -> list[tuple[str, float]]:
        """What is not, worst first, with its value."""
        missed = [(name, value) for name, value in self.values.items() if self.excess(value) > 1.0]
        return sorted(missed, key=lambda item: -self.excess(item[1]))

    def worst(self) -> tuple[str, float] | None:
        """What is farthest from good, with its value; None when nothing was measured."""
        return max(self.values.items(), key=lambda item: self.excess(item[1]), default=None)

    @property
    def verdict(self) -> str:
        """Met, missed or not measured."""
        return "not measured" if not self.values else "missed" if self.missed() else "met"


def goals(rows: dict[str, list[Row]]) -> Iterator[Goal]:
    """All of them, with what `rows` by part say."""
    sweep = rows.get("sweep", [])
    default = default_rows(sweep)
    motion = motion_rows(default)
    for what, of in (("in motion", motion), ("of frames that begin from nothing", default)):
        times = {row["scene"]: indirect_ms(row) for row in of}
        yield Goal(f"time of indirect light's stages, {what}", 6.0, times, unit="ms")
    whole = {row["scene"]: row["frame_ms"]["median"] for row in motion}
    yield Goal("time of frames in motion, with primary rays and display", 6.0, whole, unit="ms")
    yield Goal("clustering MSE", 5e-4, error_values(default, "clustering", "mse"))
    yield Goal("clustering MSE in motion", 5e-4, error_values(motion, "clustering", "mse"))
    for (sps, vpls), mse in zip(paper.SETTINGS, PAPER_MSE, strict=True):
        values = error_values(setting_rows(sweep, sps, vpls), "clustering", "mse")
        yield Goal(f"clustering MSE at the paper's {sps:,} × {vpls:,}, below its own", mse, values)
    total = error_values(default, "total", "rel_mse")
    yield Goal("total relMSE, each", 0.03, total)
    yield Goal("total relMSE in motion, each", 0.03, error_values(motion, "total", "rel_mse"))
    yield Goal("total relMSE, mean", 0.02, {"all scenes": sum(total.values()) / len(total)} if total else {})
    yield Goal("total MSE", 2e-3, error_values(default, "total", "mse"))
    yield Goal("energy, mean over the reference's", 1.03, error_values(default, "total", "energy"), low=0.97)
    still = {row["scene"]: point for row in rows.get("still", []) if (point := within(row, STILL_SECONDS))}
    errors = {scene: point["errors"]["rel_mse"] for scene, point in still.items()}
    beyond = {scene: point["rel_mse_beyond_noise"] for scene, point in still.items()}
    targets = rows.get("targets", [])
    yield Goal("relMSE of a view that rests, all light, within 1 s", STILL_ERROR, errors)
    yield Goal("relMSE of a view that rests, within 1 s, beyond the reference's own noise", STILL_BEYOND, beyond)
    energy = {scene: point["errors"]["energy"] for scene, point in still.items()}
    yield Goal("energy of a view that rests, within 1 s", 1.0 + STILL_ENERGY, energy, low=1.0 - STILL_ENERGY)
    last = {row["scene"]: row["points"][-1] for row in rows.get("still", [])}
    long = {scene: point["rel_mse_beyond_noise"] for scene, point in last.items()}
    yield Goal("relMSE of a view that rests, within 10 s, beyond the reference's own noise", LONG_BEYOND, long)
    change = {scene: point["tile_change"] for scene, point in last.items() if "tile_change" in point}
    yield Goal("change of any of 8×8 tiles from the first frame of a view that rests to the last", STILL_CHANGE, change)
    for unit, what in (("ms", "time"), ("error", "error")):
        held = {f"{row['scene']} {row['target'][unit]:g}": row["held"] for row in targets if unit in row["target"]}
        shares = {name: values["within"] for name, values in held.items()}
        means = {name: values["mean"] for name, values in held.items()}
        yield Goal(f"share of frames within 10 % of a wanted {what}", 1.0, shares, low=HELD_SHARE)
        yield Goal(f"mean {what} of a walk over the wanted one", 1.0 + WITHIN, means, low=1.0 - WITHIN)
