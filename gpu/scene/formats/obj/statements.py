"""The statements of OBJ files, line by line: numbers, faces with absolute indices, names of materials."""

import re
from array import array
from dataclasses import dataclass, field
from itertools import chain
from math import nan

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.obj.blocks import Block, blocks
from gpu.scene.formats.text import logical_lines, number, uncommented
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles

WIDTHS = {"v": 3, "vt": 2, "vn": 3}
"""How many numbers a row has."""
_LEAST = {"v": 3, "vt": 1, "vn": 3}
_USUAL = {"f", *WIDTHS}
_COUNTED = re.compile(r"0*[1-9][0-9]{0,8}")
MOST_OBJECTS = 10_000
"""Names of objects or groups that are kept: where there are more, programs wrote a group for each few faces."""


@dataclass
class ObjFaces:
    """Faces of one material and smoothing group. corners: v, vt and vn of each corner, counted from 0, −1 for none; of
    each face: counts, how many corners it has, owners, which object it is of, lines, where it is.
    """

    corners: "array[int]" = field(default_factory=lambda: array("i"))
    counts: "array[int]" = field(default_factory=lambda: array("i"))
    owners: "array[int]" = field(default_factory=lambda: array("i"))
    lines: "array[int]" = field(default_factory=lambda: array("i"))


@dataclass
class ObjFile:
    """What an OBJ file says.

    rows: numbers of v (3 a row), vt (2) and vn (3), NaN where a line has none; colors: 3 numbers a v, empty when no v
    has any. faces: by material and smoothing group (0: none). objects: numbers by name, "" before the first; more than
    MOST_OBJECTS are not told apart. libraries: what follows each mtllib.
    """

    source: str
    rows: "dict[str, array[float]]" = field(default_factory=lambda: {key: array("d") for key in WIDTHS})
    colors: "array[float]" = field(default_factory=lambda: array("d"))
    faces: dict[tuple[str, int], ObjFaces] = field(default_factory=dict)
    objects: dict[str, int] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)

    def count(self, key: str) -> int:
        """How many v, vt or vn there are so far."""
        return len(self.rows[key]) // WIDTHS[key]

    def table(self, key: str) -> Doubles:
        """The rows of v, vt or vn, (row, 3) or (row, 2)."""
        return np.array(self.rows[key]).reshape(-1, WIDTHS[key])


def read_statements(source: str, text: str, remarks: Remarks) -> ObjFile:
    """The file whose text is `text`. Raises SceneError naming the line of a v or f that cannot be read."""
    reader = _Reader(ObjFile(source), remarks)
    for block in blocks(text):
        if not reader.take(block):
            for place, line in block.lines():
                reader.read(place, line)
    return reader.file


class _Reader:
    """What was said so far, and what holds for the next face."""

    def __init__(self, file: ObjFile, remarks: Remarks) -> None:
        self.file, self._remarks = file, remarks
        self._known: dict[str, tuple[int, int, int]] = {}  # corners by their words
        self._group, self._names = ("", 0), {"o": "", "g": ""}
        self._faces: ObjFaces | None = None  # of these
        self._owner = 0

    def take(self, block: Block) -> bool:
        """Read all lines of `block` at once, if they can be."""
        if block.key == "f":
            return self._take_faces(block)
        rows = block.rows() if block.key else None
        if rows is None:
            return False
        if block.key == "v" and (self.file.colors or block.width > 3):
            colors = self._colors()
            colors.frombytes(rows[:, 3:].tobytes() if block.width > 3 else np.ones((block.count, 3)).tobytes())
        self.file.rows[block.key].frombytes(rows[:, : WIDTHS[block.key]].tobytes())
        return True

    def _take_faces(self, block: Block) -> bool:
        indices, counts = block.corners()
        there = np.array([self.file.count(key) for key in WIDTHS], np.int64)[list(block.columns)]
        if ((indices == 0) | (indices < -there)).any():
            return False
        corners = np.full((len(indices), 3), -1, np.int32)
        corners[:, block.columns] = np.where(indices > 0, indices - 1, indices + there)
        faces = self._current()
        faces.corners.frombytes(corners.tobytes())
        faces.counts.frombytes(counts.astype(np.int32).tobytes())
        faces.owners.extend([self._owner] * block.count)
        faces.lines.extend(range(block.place, block.place + block.count))
        return True

    def read(self, place: int, line: str) -> None:
        """Read one line."""
        file, remarks = self.file, self._remarks
        words = line.split()
        if not words or words[0].startswith("#"):
            return
        key = words[0] if words[0] in _USUAL else words[0].lower()
        if key == "f":
            try:
                face = [self._known[word] for word in words[1:]]
            except KeyError:
                face = [self._corner(place, word) for word in uncommented(line).split()[1:]]
            if len(face) < 3:
                remarks.add("a face with fewer than 3 corners was left out", f"line {place}")
                return
            faces = self._current()
            faces.corners.extend(chain.from_iterable(face))
            faces.counts.append(len(face))
            faces.owners.append(self._owner)
            faces.lines.append(place)
        elif key in WIDTHS:
            width = WIDTHS[key]
            try:
                if len(words) != width + 1 or "_" in line or (key == "v" and file.colors):
                    raise ValueError
                file.rows[key].extend([float(word) for word in words[1:]])
            except ValueError:
                self._row(key, place, line)
        elif key in ("usemtl", "s"):
            value, (material, smoothing) = " ".join(words[1:]), self._group
            self._group = (value, smoothing) if key == "usemtl" else (material, _smoothing(value))
            self._faces = None
        elif key in self._names:
            self._names[key] = " ".join(words[1:])
            self._faces = None
        elif key == "mtllib":
            file.libraries.append(line.strip()[len(key) :].strip())
        elif key in ("l", "p"):
            remarks.add("points and lines have no surface and were ignored")
        else:
            remarks.add(f"statement {key!r:.20} is not supported and was ignored", f"line {place}")

    def _current(self) -> ObjFaces:
        """Where the next face belongs; its object is `_owner`, that of any other where there are too many names."""
        if self._faces is None:
            self._faces = self.file.faces.setdefault(self._group, ObjFaces())
            name, objects = self._names["o"] or self._names["g"], self.file.objects
            known = name in objects or len(objects) <= MOST_OBJECTS
            self._owner = objects.setdefault(name, len(objects)) if known else 0
        return self._faces

    def _colors(self) -> "array[float]":
        """The colours so far, from now on those of each v."""
        if not self.file.colors:
            self.file.colors.extend([1.0] * len(self.file.rows["v"]))
        return self.file.colors

    def _row(self, key: str, place: int, line: str) -> None:
        """Add the numbers of a v, vt or vn line that has others than the usual ones.

        Those of a vt or vn that cannot be read are NaN, so that the lines after it keep their index.
        """
        width = WIDTHS[key]
        words = uncommented(line).split()[1:]
        try:
            values = [number(word) for word in words]
        except ValueError:
            values = []
        if len(values) < _LEAST[key]:
            if key == "v":
                problem = f"v needs 3 numbers, with points for decimals, not {' '.join(words)!r:.60}"
                raise SceneError(self.file.source, f"line {place}", problem)
            self._remarks.add(f"{key} is not {width} numbers: what uses it does without", f"line {place}")
            values = [nan, nan, nan]
        if key == "v":
            self._color(values[3:], place)
        self.file.rows[key].extend([*values, 0.0][:width])

    def _color(self, after: list[float], place: int) -> None:
        """Add what comes `after` the position of a v: nothing, a weight, or a colour."""
        if self.file.colors or len(after) >= 3:
            self._colors().extend(after[:3] if len(after) >= 3 else (1.0, 1.0, 1.0))
        if len(after) not in (0, 3) and after != [1.0]:
            self._remarks.add("v has a weight, an alpha or more numbers that were ignored", f"line {place}")

    def _corner(self, place: int, word: str) -> tuple[int, int, int]:
        """v, vt and vn of a corner such as 1/2/3, from then on `_known` by its word if it does not count back."""
        found = [-1, -1, -1]
        for position, digits in enumerate(word.split("/")[:3]):
            if digits or position == 0:
                absolute = _COUNTED.fullmatch(digits)
                found[position] = int(digits) - 1 if absolute else self._counted_back(place, position, digits)
        corner = (found[0], found[1], found[2])
        if "-" not in word:
            self._known[word] = corner
        return corner

    def _counted_back(self, place: int, position: int, digits: str) -> int:
        """The index from 0 of a negative one, which counts back from the last v, vt or vn so far."""
        key = list(WIDTHS)[position]
        count = self.file.count(key)
        try:
            index = int(digits) + count
        except ValueError:
            index = -1
        if not 0 <= index < count or not digits.startswith("-"):
            problem = f"{key} index {digits!r:.20} does not exist, so far {count}"
            raise SceneError(self.file.source, f"line {place}", problem)
        return index


def _smoothing(value: str) -> int:
    """The smoothing group that an s line names; 0 for none."""
    word = uncommented(value).strip().lower()
    return int(word) if word.isdecimal() else int(word == "on")


def row_line(text: str, key: str, row: int) -> int:
    """The line of the `row`th statement `key`, both counted as in files and messages: rows from 0, lines from 1."""
    places = (place for place, line in logical_lines(text) if line.split()[:1] in ([key], [key.upper()]))
    return next(place for count, place in enumerate(places) if count == row)
