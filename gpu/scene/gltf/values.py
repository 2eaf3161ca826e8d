"""A JSON value that knows its place, so that every wrong one is an error that names it."""

from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

from gpu.errors import SceneError


@dataclass(frozen=True)
class Value:
    """A JSON value of the file `source` at `path`, for example "meshes[2].primitives[0]".

    Each getter checks type and range and raises SceneError with the path; a missing key gives the default, and no
    default means that the key must be there.
    """

    source: str
    path: str
    raw: Any

    def error(self, problem: str) -> SceneError:
        """The error that says `problem` of this place."""
        return SceneError(self.source, self.path, problem)

    def has(self, key: str) -> bool:
        """Whether this object has `key`."""
        return isinstance(self.raw, dict) and key in self.raw

    def get(self, key: str) -> "Value":
        """The value of `key`, which must be there."""
        if not isinstance(self.raw, dict):
            raise self.error("must be an object")
        if key not in self.raw:
            raise self.error(f"{key!r} is missing")
        return Value(self.source, f"{self.path}.{key}" if self.path else key, self.raw[key])

    def object(self, key: str) -> "Value":
        """The object at `key`, an empty one when it is missing."""
        value = self.get(key) if self.has(key) else Value(self.source, f"{self.path}.{key}", {})
        if not isinstance(value.raw, dict):
            raise value.error("must be an object")
        return value

    def items(self, key: str) -> list["Value"]:
        """The elements of the array at `key`, none when it is missing."""
        if not self.has(key):
            return []
        array = self.get(key)
        if not isinstance(array.raw, list):
            raise array.error("must be an array")
        return [Value(self.source, f"{array.path}[{number}]", raw) for number, raw in enumerate(array.raw)]

    def objects(self, key: str) -> list["Value"]:
        """The elements of the array at `key`, which must be objects."""
        items = self.items(key)
        for item in items:
            if not isinstance(item.raw, dict):
                raise item.error("must be an object")
        return items

    def extension(self, name: str) -> "Value | None":
        """The object of the extension `name` here, or None."""
        extensions = self.object("extensions")
        return extensions.object(name) if extensions.has(name) else None

    def as_number(self, low: float = -inf, high: float = inf) -> float:
        """The value as a finite number in [low, high]."""
        if isinstance(self.raw, bool) or not isinstance(self.raw, int | float) or abs(self.raw) > 1e300:
            raise self.error(f"must be a number, not {self.raw!r:.60}")
        if not isfinite(self.raw) or not low <= self.raw <= high:
            raise self.error(f"must be between {low:g} and {high:g}, not {self.raw!r:.60}")
        return float(self.raw)

    def as_text(self) -> str:
        """The value as a string."""
        if not isinstance(self.raw, str):
            raise self.error("must be a string")
        return self.raw

    def as_index(self, count: int) -> int:
        """The value as an index below `count`."""
        whole = isinstance(self.raw, float) and self.raw.is_integer()  # JSON has one kind of number
        if isinstance(self.raw, bool) or not (isinstance(self.raw, int) or whole):
            raise self.error(f"must be an index, not {self.raw!r:.60}")
        if not 0 <= self.raw < count:
            raise self.error(f"{self.raw!r:.60} does not exist, there are {count}")
        return int(self.raw)

    def number(self, key: str, default: float | None = None, low: float = -inf, high: float = inf) -> float:
        """The number at `key`, in [low, high]."""
        return default if default is not None and not self.has(key) else self.get(key).as_number(low, high)

    def integer(self, key: str, default: int | None = None, low: int = 0, high: int = 2**53) -> int:
        """The integer at `key`, in [low, high]. Raises SceneError for one with a fraction."""
        value = self.number(key, default, low, high)
        if value != int(value):
            raise self.get(key).error(f"must be an integer, not {value:g}")
        return int(value)

    def numbers(self, key: str, default: tuple[float, ...], low: float = -inf, high: float = inf) -> tuple[float, ...]:
        """As many numbers at `key` as the default has, each in [low, high]."""
        if not self.has(key):
            return default
        items = self.items(key)
        if len(items) != len(default):
            raise self.get(key).error(f"must have {len(default)} numbers, not {len(items)}")
        return tuple(item.as_number(low, high) for item in items)

    def text(self, key: str, default: str | None = None) -> str:
        """The string at `key`."""
        if default is not None and not self.has(key):
            return default
        return self.get(key).as_text()

    def flag(self, key: str) -> bool:
        """The boolean at `key`, false when it is missing."""
        value = self.get(key).raw if self.has(key) else False
        if not isinstance(value, bool):
            raise self.get(key).error("must be true or false")
        return value
