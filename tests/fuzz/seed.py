"""A scene file in the making."""

from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Seed:
    """A file by its name, and those that it refers to. pack: makes the file of what is changed, such as a zip file."""

    name: str
    content: bytes
    beside: dict[str, bytes] = field(default_factory=dict)
    pack: Callable[[bytes], bytes] = bytes

    def files(self) -> dict[str, bytes]:
        """All of them by their names, as they are written."""
        return {self.name: self.pack(self.content), **self.beside}
