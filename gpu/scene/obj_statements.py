"""The statements of OBJ files, line by line: numbers, faces with absolute indices, names of materials."""

import re
from array import array
from dataclasses import dataclass, field
from math import nan

import numpy as np

from gpu.errors import SceneError
from gpu.scene.remarks import Remarks
from gpu.scene.text import logical_lines, number, uncommented
from gpu.scene.types import Doubles

_WIDTHS = {"v": 3, "vt": 2, "vn": 3}
_LEAST = {"v": 3, "vt": 1, "vn": 3}
_USUAL = {"f", *_WIDTHS}
_COUNTED = re.compile(r"0*[1-9][0-9]{0,14}")
MOST_OBJECTS = 10_000
"""Names of objects or groups that are kept: where there are more, programs wrote a group for each few faces."""


@dataclass
class ObjFile:
    """What an OBJ file says.

    rows: numbers of v (3 a row), vt (2) and vn (3), NaN where a line has none; colors: 3 numbers a v, empty when no v
    has any. corners: (v, vt, vn) of each corner that differs, counted from 0, −1 for none; lines: where each is first.
    faces: by material and smoothing group (0: none) which corners, how many a face has, and which object it is of.
    objects: numbers by name, "" before the first; more than MOST_OBJECTS are not told apart. libraries: what follows
    each mtllib.
    """

    source: str
    rows: "dict[str, array[float]]" = field(default_factory=lambda: {key: array("d") for key in _WIDTHS})
    colors: "array[float]" = field(default_factory=lambda: array("d"))
    corners: list[tuple[int, int, int]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    faces: "dict[tuple[str, int], tuple[array[int], array[int], array[int]]]" = field(default_factory=dict)
    objects: dict[str, int] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)

    def count(self, key: str) -> int:
        """How many v, vt or vn there are so far."""
        return len(self.rows[key]) // _WIDTHS[key]

    def table(self, key: str) -> Doubles:
        """The rows of v, vt or vn, (row, 3) or (row, 2)."""
        return np.array(self.rows[key]).reshape(-1, _WIDTHS[key])


def read_statements(source: str, text: str, remarks: Remarks) -> ObjFile:
    """The file whose text is `text`. Raises SceneError naming the line of a v or f that cannot be read."""
    file = ObjFile(source)
    known: dict[str, int] = {}
    group, faces, names, owner = ("", 0), None, {"o": "", "g": ""}, 0
    for place, line in logical_lines(text):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        key = words[0] if words[0] in _USUAL else words[0].lower()
        if key == "f":
            try:
                face = [known[word] for word in words[1:]]
            except KeyError:
                face = [_corner(file, known, place, word) for word in uncommented(line).split()[1:]]
            if len(face) < 3:
                remarks.add("a face with fewer than 3 corners was left out", f"line {place}")
                continue
            if faces is None:
                faces = file.faces.setdefault(group, (array("q"), array("q"), array("i")))
                owner = _owner(file, names["o"] or names["g"])
            faces[0].extend(face)
            faces[1].append(len(face))
            faces[2].append(owner)
        elif key in _WIDTHS:
            width = _WIDTHS[key]
            try:
                if len(words) != width + 1 or "_" in line or (key == "v" and file.colors):
                    raise ValueError
                file.rows[key].extend([float(word) for word in words[1:]])
            except ValueError:
                _row(file, key, place, line, remarks)
        elif key in ("usemtl", "s"):
            value = " ".join(words[1:])
            group, faces = (value, group[1]) if key == "usemtl" else (group[0], _smoothing(value)), None
        elif key in names:
            names[key], faces = " ".join(words[1:]), None
        elif key == "mtllib":
            file.libraries.append(line.strip()[len(key) :].strip())
        elif key in ("l", "p"):
            remarks.add("points and lines have no surface and were ignored")
        else:
            remarks.add(f"statement {key!r:.20} is not supported and was ignored", f"line {place}")
    return file


def _owner(file: ObjFile, name: str) -> int:
    """The number of the object called `name`; that of any other where there are too many."""
    if name not in file.objects and len(file.objects) > MOST_OBJECTS:
        return 0
    return file.objects.setdefault(name, len(file.objects))


def _row(file: ObjFile, key: str, place: int, line: str, remarks: Remarks) -> None:
    """Add the numbers of a v, vt or vn line that has others than the usual ones.

    Those of a vt or vn that cannot be read are NaN, so that the lines after it keep their index.
    """
    width = _WIDTHS[key]
    words = uncommented(line).split()[1:]
    try:
        values = [number(word) for word in words]
    except ValueError:
        values = []
    if len(values) < _LEAST[key]:
        if key == "v":
            problem = f"v needs 3 numbers, with points for decimals, not {' '.join(words)!r:.60}"
            raise SceneError(file.source, f"line {place}", problem)
        remarks.add(f"{key} is not {width} numbers: what uses it does without", f"line {place}")
        values = [nan, nan, nan]
    if key == "v":
        _color(file, values[3:], place, remarks)
    file.rows[key].extend([*values, 0.0][:width])


def _color(file: ObjFile, after: list[float], place: int, remarks: Remarks) -> None:
    """Add what comes `after` the position of a v: nothing, a weight, or a colour."""
    if len(after) >= 3 and not file.colors:
        file.colors.extend([1.0] * len(file.rows["v"]))
    if file.colors or len(after) >= 3:
        file.colors.extend(after[:3] if len(after) >= 3 else (1.0, 1.0, 1.0))
    if len(after) not in (0, 3) and after != [1.0]:
        remarks.add("v has a weight, an alpha or more numbers that were ignored", f"line {place}")


def _smoothing(value: str) -> int:
    """The smoothing group that an s line names; 0 for none."""
    word = uncommented(value).strip().lower()
    return int(word) if word.isdecimal() else int(word == "on")


def _corner(file: ObjFile, known: dict[str, int], place: int, word: str) -> int:
    """The number of a corner such as 1/2/3, which is `known` by its word but for one that counts back from its line."""
    found = [-1, -1, -1]
    for position, digits in enumerate(word.split("/")[:3]):
        if digits or position == 0:
            found[position] = (
                int(digits) - 1 if _COUNTED.fullmatch(digits) else _counted_back(file, place, position, digits)
            )
    key = "/".join(map(str, found)) + "/" if "-" in word else word  # ends as no word that is known so far
    if key not in known:
        known[key] = len(file.corners)
        file.corners.append((found[0], found[1], found[2]))
        file.lines.append(place)
    return known[key]


def _counted_back(file: ObjFile, place: int, position: int, digits: str) -> int:
    """The index from 0 of a negative one, which counts back from the last v, vt or vn so far."""
    key = list(_WIDTHS)[position]
    count = file.count(key)
    try:
        index = int(digits) + count
    except ValueError:
        index = -1
    if not 0 <= index < count or not digits.startswith("-"):
        raise SceneError(file.source, f"line {place}", f"{key} index {digits!r:.20} does not exist, so far {count}")
    return index


def row_line(text: str, key: str, row: int) -> int:
    """The line of the `row`th statement `key`, both counted as in files and messages: rows from 0, lines from 1."""
    places = (place for place, line in logical_lines(text) if line.split()[:1] in ([key], [key.upper()]))
    return next(place for count, place in enumerate(places) if count == row)
