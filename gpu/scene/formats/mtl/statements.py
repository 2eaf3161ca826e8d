"""The statements of MTL libraries: by material and keyword, in any order; numbers, colours and the options of maps."""

import re
from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from gpu.scene.formats.text import logical_lines, number, uncommented
from gpu.scene.remarks import Remarks
from gpu.scene.types import Rgb

# CIE XYZ to linear Rec. 709 (IEC 61966-2-1).
_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
_OPTION = re.compile(r"-(\w+)\s+")
# How many words follow an option of a map, at most; of those up to three numbers, fewer may.
_OPTIONS = {"s": 3, "o": 3, "t": 3, "mm": 2, "bm": 1, "boost": 1, "texres": 1, "clamp": 1, "blendu": 1, "blendv": 1}
_OPTIONS |= {"cc": 1, "imfchan": 1, "type": 1, "colorspace": 1}
_NUMERIC = {"s", "o", "t"}
_USED = {"s", "o", "clamp", "bm"}


@dataclass(frozen=True)
class MapStatement:
    """A map: its file, and what its options say. scale, offset: of u and v; bump: what -bm multiplies."""

    name: str
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool = False
    bump: float = 1.0


@dataclass
class MtlMaterial:
    """What a library says of one material. values: what follows each keyword in lower case, with its place."""

    name: str
    remarks: Remarks
    values: dict[str, tuple[str, str]] = field(default_factory=dict)

    def has(self, key: str) -> bool:
        """Whether there is a statement `key`."""
        return key in self.values

    def scalar(self, key: str, default: float, most: float = float("inf")) -> float:
        """The number that `key` has, from 0 to `most`; one that is none, or not that, is said, and `default` taken."""
        if key not in self.values:
            return default
        words = _words(self.values[key][0])
        values = _numbers(words[-1:] if words[:1] == ["-halo"] else words[:1])
        if not values or not 0.0 <= values[0] < float("inf"):
            self._odd(key, f"is not a number of at least 0: {default:g} was taken")
            return default
        if values[0] > most:
            self._odd(key, f"is above {most:g}, which was taken")
        return min(values[0], most)

    def color(self, key: str, default: Rgb, most: float = float("inf")) -> Rgb:
        """The colour that `key` has, each channel from 0 to `most`; what is wrong with it is said."""
        if key not in self.values:
            return default
        words = _words(self.values[key][0])
        in_xyz = words[:1] == ["xyz"]
        values = _numbers(words[1:] if in_xyz else words)
        values = values * 3 if len(values) == 1 else values
        if len(values) < 3 or not all(0.0 <= value < float("inf") for value in values[:3]):
            self._odd(
                key, f"is not 1 or 3 numbers of at least 0: {' '.join(f'{value:g}' for value in default)} was taken"
            )
            return default
        if len(values) > 3:
            self._odd(key, "has more than 3 numbers: the first 3 were taken")
        r, g, b = values[:3]
        if in_xyz:
            self._odd(key, "is in CIE XYZ and was converted to Rec. 709")
            r, g, b = (max(float(value), 0.0) for value in _XYZ @ (r, g, b))
        if max(r, g, b) > most:
            self._odd(key, f"is above {most:g}, which was taken")
        return min(r, most), min(g, most), min(b, most)

    def map(self, key: str) -> MapStatement | None:
        """The map that `key` names, None where there is none; options that are not supported are said."""
        if key not in self.values:
            return None
        rest, place = self.values[key]
        found: dict[str, list[str]] = {}
        while (match := _OPTION.match(rest)) and match[1].lower() in _OPTIONS:
            option = match[1].lower()
            words = rest[match.end() :].split(maxsplit=_OPTIONS[option])
            taken = _OPTIONS[option]
            if option in _NUMERIC:
                taken = next((count for count in range(taken) if not _numbers(words[count : count + 1])), taken)
            found[option] = words[:taken]
            rest = rest[match.end() :].split(maxsplit=taken)[taken] if len(words) > taken else ""
        for option in found.keys() - _USED:
            self.remarks.add(f"option -{option} of MTL maps is not supported and was ignored", place)
        if not rest.strip():
            self._odd(key, "names no file")
            return None
        scale, offset = _numbers(found.get("s", [])), _numbers(found.get("o", []))
        bump = _numbers(found.get("bm", []))
        return MapStatement(
            rest.strip().strip('"'),
            (scale[0], scale[1] if len(scale) > 1 else 1.0) if scale else (1.0, 1.0),
            (offset[0], offset[1] if len(offset) > 1 else 0.0) if offset else (0.0, 0.0),
            found.get("clamp", [""])[0].lower() == "on",
            bump[0] if bump and bump[0] >= 0.0 else 1.0,
        )

    def _odd(self, key: str, problem: str) -> None:
        value, place = self.values[key]
        self.remarks.add(f"{key} {value!r:.40} {problem}", place, kind=f"{key} {problem}")


def read_materials(source: str, text: str, remarks: Remarks) -> list[MtlMaterial]:
    """The materials of a library whose text is `text`; of a statement that is there twice, the last."""
    materials: list[MtlMaterial] = []
    for place, line in logical_lines(text):
        key, *rest = line.split(maxsplit=1)[:2] or ["#"]
        value = rest[0].strip() if rest else ""
        if key.startswith("#"):
            continue
        if key.lower() == "newmtl":
            materials.append(MtlMaterial(" ".join(value.split()), remarks))
        elif not materials:
            remarks.add("a statement before the first newmtl was ignored", f"{source}: line {place}")
        elif value:
            materials[-1].values[key.lower()] = (value, f"{source}: line {place}")
    return materials


def _words(value: str) -> list[str]:
    return uncommented(value).lower().split()


def _numbers(words: list[str]) -> list[float]:
    """The numbers that `words` are; none where one is no number, NaN where one is not finite."""
    try:
        values = [number(word) for word in words]
    except ValueError:
        return []
    return [value if isfinite(value) else float("nan") for value in values]
