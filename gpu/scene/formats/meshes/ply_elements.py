"""PLY files as their header describes them: elements of numbers and lists, in text or either order of bytes."""

import re
import struct
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gpu.errors import SceneError
from gpu.scene.floats import doubles
from gpu.scene.formats.text import decoded, numbers, without_mark
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles, Integers

_TYPES = {
    "b": ("char", "int8"),
    "B": ("uchar", "uint8"),
    "h": ("short", "int16"),
    "H": ("ushort", "uint16"),
    "i": ("int", "int32"),
    "I": ("uint", "uint32"),
    "q": ("int64",),
    "Q": ("uint64",),
    "f": ("float", "float32"),
    "d": ("double", "float64"),
}
_CODES = {name: code for code, names in _TYPES.items() for name in names}
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_END = re.compile(rb"(?:^|[\r\n])[ \t]*end_header[ \t]*(\r\n|\r|\n|\Z)")


@dataclass(frozen=True)
class Property:
    """A column of an element: its type's code as `struct` has it; counted: that of a list's length, "" for none."""

    name: str
    code: str
    counted: str = ""


@dataclass(frozen=True, eq=False)
class Lists:
    """A column of lists: values one after another, and how many each row has (row,)."""

    values: Doubles
    counts: Integers


@dataclass
class Element:
    """What the header says of an element, and what its rows hold, by the names of properties."""

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)
    columns: dict[str, Doubles] = field(default_factory=dict)
    lists: dict[str, Lists] = field(default_factory=dict)

    def code(self, name: str) -> str:
        """The code of a property's type."""
        return next(each.code for each in self.properties if each.name == name)


@dataclass
class PlyFile:
    """The elements of a PLY file by name, and the comments of its header."""

    elements: dict[str, Element]
    comments: list[str]


def read_elements(source: str, content: bytes, remarks: Remarks) -> PlyFile:
    """All that a PLY file holds. Raises SceneError when its header is not sound or its body shorter than that says."""
    content = without_mark(content)
    end = _END.search(content)
    if not re.match(rb"\s*ply\b", content, re.IGNORECASE) or end is None:
        raise SceneError(source, "", "not a PLY file: there is no header from ply to end_header")
    order, file = _header(source, decoded(content[: end.start()]))
    # After a lone carriage return the body may begin with a byte that looks like a line feed.
    after = end.start(1) + 1 if end[1] == b"\r\n" and b"\r\n" not in content[: end.start() + 1] else end.end()
    body = content[after:]
    if order:
        buffer = body
    else:  # text is as numbers that all have the same type
        try:
            buffer = numbers(decoded(body).split()).astype("<f8").tobytes()
        except ValueError as error:
            raise SceneError(source, "", f"needs numbers, with points for decimals: {error}") from error
    at = 0
    for element in file.elements.values():
        try:
            at = _rows(element, buffer, at, order)
        except (struct.error, ValueError, OverflowError, MemoryError) as error:
            problem = f"the file ends before its {element.rows:,} rows do; it is cut off"
            raise SceneError(source, f"element {element.name}", problem) from error
    rest = len(buffer) - at if order else (len(buffer) - at) // 8
    if rest and not order:
        raise SceneError(source, "", f"{rest:,} numbers more than the header says follow")
    remarks.add_count("bytes after the last element were ignored", rest)
    return file


def _header(source: str, text: str) -> tuple[str, PlyFile]:
    """The order of bytes, "" for text, and the elements without their rows."""
    order, file = None, PlyFile({}, [])
    element = None
    for place, line in enumerate(text.split("\n"), 1):
        words = line.split()
        key = words[0].lower() if words else ""
        try:
            if key == "format":
                order = _FORMATS[words[1].lower()]
            elif key == "element":
                element = Element(words[1], int(words[2]))
                if element.rows < 0 or element.name in file.elements:
                    raise ValueError
                file.elements[element.name] = element
            elif key == "property" and element is not None:
                kinds = [_CODES[word.lower()] for word in words[2:-1]] if words[1] == "list" else []
                counted, code = kinds or ("", _CODES[words[1].lower()])
                if any(each.name == words[-1] for each in element.properties):
                    raise ValueError
                element.properties.append(Property(words[-1], code, counted))
            elif key in ("comment", "obj_info"):
                file.comments.append(line.strip()[len(key) :].strip())
            elif key not in ("", "ply"):
                raise ValueError
        except (IndexError, KeyError, ValueError) as error:
            raise SceneError(source, f"header line {place}", f"{line.strip()!r:.60} cannot be read") from error
    if order is None:
        raise SceneError(source, "header", "no format is named")
    return order, file


def _rows(element: Element, buffer: bytes, at: int, order: str) -> int:
    """Fill in the rows of `element`, which begin `at` a byte of the buffer; returns where they end.

    Raises ValueError or struct.error where the buffer ends before.
    """
    if not element.rows:
        return at
    stride, lengths = _row_size(element, buffer, at, order)
    if at + stride * element.rows <= len(buffer):
        offset = at
        found: dict[str, tuple[NDArray[np.generic], Integers | None]] = {}
        for each, length in zip(element.properties, lengths, strict=True):
            kind = _dtype(each.code, order)
            if each.counted:
                counted = _dtype(each.counted, order)
                counts = np.ndarray(element.rows, counted, buffer, offset, stride)
                if (counts != length).any():
                    return _walk(element, buffer, at, order)
                offset += counted.itemsize
                table = np.ndarray((element.rows, length), kind, buffer, offset, (stride, kind.itemsize))
                found[each.name] = table, np.full(element.rows, length)
                offset += length * kind.itemsize
            else:
                found[each.name] = np.ndarray(element.rows, kind, buffer, offset, stride), None
                offset += kind.itemsize
        for name, (values, lengths_of) in found.items():
            if lengths_of is None:
                element.columns[name] = doubles(values)
            else:
                element.lists[name] = Lists(doubles(values).reshape(-1), lengths_of)
        return at + stride * element.rows
    return _walk(element, buffer, at, order)


def _row_size(element: Element, buffer: bytes, at: int, order: str) -> tuple[int, list[int]]:
    """The bytes of the row that begins `at`, and the length of each property's list in it, 1 for none."""
    start, lengths = at, []
    for each in element.properties:
        length = 1
        if each.counted:
            counted = _dtype(each.counted, order)
            length = _length(np.frombuffer(buffer, counted, 1, at)[0])
            at += counted.itemsize
        at += length * _dtype(each.code, order).itemsize
        lengths.append(length)
    return at - start, lengths


def _walk(element: Element, buffer: bytes, at: int, order: str) -> int:
    """As `_rows`, where lists of one property differ in length: row by row."""
    offsets: list[list[int]] = [[] for _ in element.properties]
    lengths: list[list[int]] = [[] for _ in element.properties]
    plan = []
    for number, each in enumerate(element.properties):
        counted = _dtype(each.counted, order) if each.counted else None
        code = None if counted is None else struct.Struct((order or "<") + counted.char)
        plan.append((code, _dtype(each.code, order).itemsize, offsets[number], lengths[number]))
    for _ in range(element.rows):
        for code, size, places, counts in plan:
            length = 1
            if code is not None:
                length = _length(code.unpack_from(buffer, at)[0])
                at += code.size
            places.append(at)
            counts.append(length)
            at += length * size
        if at > len(buffer):
            raise ValueError
    raw = np.frombuffer(buffer, np.uint8)
    for number, each in enumerate(element.properties):
        kind, counts_of = _dtype(each.code, order), np.array(lengths[number], np.int64)
        owner = np.repeat(np.arange(element.rows), counts_of)
        place = np.arange(len(owner)) - (np.cumsum(counts_of) - counts_of)[owner]
        first = np.array(offsets[number], np.int64)[owner] + place * kind.itemsize
        values = doubles(raw[first[:, None] + np.arange(kind.itemsize)].view(kind).reshape(-1))
        if each.counted:
            element.lists[each.name] = Lists(values, counts_of)
        else:
            element.columns[each.name] = values
    return at


def _length(count: float) -> int:
    if not 0 <= count < 2**31:
        raise ValueError
    return int(count)


def _dtype(code: str, order: str) -> np.dtype[np.generic]:
    return np.dtype((order + code) if order else "<f8")
