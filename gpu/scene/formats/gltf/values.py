"""A JSON value that knows its place, so that every wrong one is an error, or mended with a sentence, that names it."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any, TypeGuard, TypeVar

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.remarks import Remarks

T = TypeVar("T")

_LARGEST = 1e300  # an integer of JSON may be too large for a float
_FLOAT32_ROUNDING = 2.0**-24  # by how much a number may change, relative to itself, when it becomes a float32


@dataclass(frozen=True)
class Value:
    """A JSON value of the file `source` at `path`, for example "meshes[2].primitives[0]".

    Each getter checks type and range and raises SceneError with the path; a missing key gives the default, and no
    default means that the key must be there. Those that take parts and factors mend what is wrong and note it: for
    values without which the geometry is as good. A bound that was rounded to float32 is within limits.
    """

    source: str
    path: str
    raw: Any
    notes: Remarks = field(default_factory=Remarks, compare=False)

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
        return self._inner(key, self.raw[key])

    def object(self, key: str) -> "Value":
        """The object at `key`, an empty one when it is missing."""
        value = self.get(key) if self.has(key) else self._inner(key, {})
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
        return [array._inner(number, raw) for number, raw in enumerate(array.raw)]

    def objects(self, key: str) -> list["Value"]:
        """The elements of the array at `key`, which must be objects."""
        items = self.items(key)
        for item in items:
            if not isinstance(item.raw, dict):
                raise item.error("must be an object")
        return items

    def element(self, array: str, place: "Value", key: str) -> "Value":
        """The object of the `array` here whose index `place` has at `key`."""
        objects = self.raw.get(array, [])
        if not isinstance(objects, list):
            raise self.get(array).error("must be an array")
        number = place.index(key, len(objects))
        path = f"{self.path}.{array}[{number}]" if self.path else f"{array}[{number}]"
        found = Value(self.source, path, objects[number], self.notes)
        if not isinstance(found.raw, dict):
            raise found.error("must be an object")
        return found

    def extension(self, name: str) -> "Value | None":
        """The object of the extension `name` here, or None."""
        if not self.has("extensions"):
            return None
        extensions = self.object("extensions")
        return extensions.object(name) if extensions.has(name) else None

    def as_number(self, low: float = -inf, high: float = inf) -> float:
        """The value as a finite number in [low, high]."""
        if isinstance(self.raw, bool) or not isinstance(self.raw, int | float) or abs(self.raw) > _LARGEST:
            raise self.error(f"must be a number, not {self.raw!r:.60}")
        number = min(max(float(self.raw), low), high)
        if not isfinite(self.raw) or abs(number - self.raw) > _FLOAT32_ROUNDING * abs(number):
            raise self.error(f"must be {_between(low, high)}, not {self.raw!r:.60}")
        return number

    def as_text(self) -> str:
        """The value as a string."""
        if not isinstance(self.raw, str):
            raise self.error("must be a string")
        return self.raw.encode("utf-8", "replace").decode()  # JSON can have half a surrogate pair

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
        raw = self.raw.get(key) if isinstance(self.raw, dict) else None
        if _is_plain(raw, low, high):
            return float(raw)
        return default if default is not None and not self.has(key) else self.get(key).as_number(low, high)

    def index(self, key: str, count: int) -> int:
        """The index below `count` at `key`."""
        raw = self.raw.get(key) if isinstance(self.raw, dict) else None
        return raw if type(raw) is int and 0 <= raw < count else self.get(key).as_index(count)

    def integer(self, key: str, default: int | None = None, low: int = 0, high: int = 2**53) -> int:
        """The integer at `key`, in [low, high]. Raises SceneError for one with a fraction."""
        raw = self.raw.get(key) if isinstance(self.raw, dict) else None
        if type(raw) is int and low <= raw <= high:
            return raw
        value = self.number(key, default, low, high)
        if value != int(value):
            raise self.get(key).error(f"must be an integer, not {value:g}")
        return int(value)

    def numbers(self, key: str, default: tuple[float, ...], low: float = -inf, high: float = inf) -> tuple[float, ...]:
        """As many numbers at `key` as the default has, each in [low, high]."""
        if not self.has(key):
            return default
        raw = self.raw[key]
        if isinstance(raw, list) and len(raw) == len(default) and all(_is_plain(item, low, high) for item in raw):
            return tuple(map(float, raw))
        items = self.items(key)
        if len(items) != len(default):
            raise self.get(key).error(f"must have {len(default)} numbers, not {len(items)}")
        return tuple(item.as_number(low, high) for item in items)

    def text(self, key: str, default: str | None = None) -> str:
        """The string at `key`."""
        raw = self.raw.get(key) if isinstance(self.raw, dict) else None
        if isinstance(raw, str) and raw.isascii():
            return raw
        if default is not None and not self.has(key):
            return default
        return self.get(key).as_text()

    def part(self, key: str) -> "Value":
        """The object at `key`, an empty one when it is missing or none."""
        if not self.has(key):
            return self._inner(key, {})
        return self.mended(lambda: self.object(key), self._inner(key, {}), "it was left out")

    def parts(self, key: str) -> "list[Value]":
        """The elements of the array at `key`, none when it is missing or no array."""
        if not self.has(key):
            return []
        empty: list[Value] = []
        return self.mended(lambda: self.items(key), empty, "it was left out")

    def named_extension(self, name: str) -> "Value":
        """The object of the extension `name` here, an empty one when it is missing or none."""
        return self.part("extensions").part(name)

    def factor(self, key: str, default: float, low: float = -inf, high: float = inf) -> float:
        """The number at `key`, the nearest in [low, high]."""
        return self.get(key).as_factor(default, low, high) if self.has(key) else default

    def factors(self, key: str, default: tuple[float, ...], low: float = -inf, high: float = inf) -> tuple[float, ...]:
        """As many numbers at `key` as the default has, each the nearest in [low, high]; where one lacks, its own."""
        items = self.parts(key)
        if self.has(key) and items and len(items) != len(default):
            self.get(key).mend(f"must have {len(default)} numbers, not {len(items)}; those there are were used")
        found = (item.as_factor(value, low, high) for item, value in zip(items, default, strict=False))
        return (*found, *default[len(items) :])

    def as_factor(self, default: float, low: float, high: float) -> float:
        """The value as the nearest number in [low, high], or the default where it is no finite number."""
        number = self.mended(self.as_number, default, f"{default:g} was used")
        nearest = min(max(number, low), high)
        if abs(number - nearest) > _FLOAT32_ROUNDING * abs(nearest):
            self.mend(f"must be {_between(low, high)}, not {number:.9g}; {nearest:g} was used")
        return nearest

    def choice(self, key: str, choices: Mapping[Any, T], default: T) -> T:
        """What stands in `choices` for the value at `key`; the default when it is missing or not one of them."""
        raw = self.raw.get(key) if self.has(key) else None
        if isinstance(raw, str | int | float) and raw in choices:
            return choices[raw]
        if self.has(key):
            known = ", ".join(map(str, choices))
            self.get(key).mend(f"must be one of {known}, not {raw!r:.40}; the default was used")
        return default

    def name(self, default: str = "") -> str:
        """The text at "name"; the default when there is none."""
        if not self.has("name"):
            return default
        return self.mended(lambda: self.text("name", ""), "", "it was left out") or default

    def flag(self, key: str) -> bool:
        """The boolean at `key`, false when it is missing."""
        return self.has(key) and self.choice(key, {True: True, False: False}, False)

    def mended(self, read: Callable[[], T], otherwise: T, said: str) -> T:
        """What `read` returns; `otherwise`, with a note that ends in what was `said`, where it raises SceneError."""
        try:
            return read()
        except ForbiddenError:
            raise
        except SceneError as error:
            self.notes.add(f"{error.problem}; {said}", error.field, kind=kind_of(error.field))
            return otherwise

    def mend(self, problem: str) -> None:
        """Note what is wrong here and what was done about it."""
        self.notes.add(problem, self.path, kind=kind_of(self.path))

    def _inner(self, key: str | int, raw: Any) -> "Value":
        """The value `raw` that stands in this one at `key`."""
        inner = f"[{key}]" if isinstance(key, int) else f".{key}" if self.path else key
        return Value(self.source, self.path + inner, raw, self.notes)


def _is_plain(raw: Any, low: float, high: float) -> TypeGuard[float]:
    """Whether `raw` is surely a number in [low, high]: of most numbers of a file no more than this has to be asked."""
    return (type(raw) is float or type(raw) is int) and low <= raw <= high and abs(raw) <= _LARGEST


def kind_of(path: str) -> str:
    """A path without its numbers: what is wrong in the same place of many objects is said once."""
    return re.sub(r"\[\d+\]", "[]", path)


def _between(low: float, high: float) -> str:
    return "a finite number" if low == -inf and high == inf else f"between {low:g} and {high:g}"
