"""Changes of files: of bytes, of words and lines of text, and of the JSON in glTF with lengths that fit again."""

import json
import re
import struct
from collections.abc import Callable
from random import Random
from typing import Any

# What numbers are where readers have their edges.
NUMBERS = (
    *(0, 1, -1, 2, 3, 127, 128, 255, 256, 65535, 65536, 2**31 - 1, 2**31, -(2**31), 2**32 - 1, 2**32),
    *(2**53, 2**63 - 1, 2**63, -(2**63), 2**64, 10**30, 0.5, 1.5, -0.0, 1e-320, 1e-38, 1e38, 1e39, 1e300, 1e308),
)
WORDS = (
    *(
        b"nan",
        b"inf",
        b"-inf",
        b"1e999",
        b"-1.#IND",
        b"0x10",
        b"1_0",
        b"+",
        b"-",
        b".",
        b"",
        b"/",
        b"//",
        b"1//",
        b"\\",
    ),
    *(b"#", b"\0", b"\xff", "é".encode(), "٣".encode(), b"list", b"v", b"f", b"vertex", b"facet", b"endsolid", b"end"),
    *(b"usemtl", b"newmtl", b"map_Kd", b"mtllib", b"element", b"property", b"double", b"end_header", b"-o", b"1,5"),
    *(str(number).encode() for number in NUMBERS),
)
VALUES = (None, True, False, "", "a", "\x00", "\ud800", "../x", [], {}, [[]], [None], *NUMBERS)
_VALUE = re.compile(rb"""[^\s"'(),;<>=/]+""")
MOST_BYTES = 100_000  # of a mutation: repeating must not lead to files that are merely slow


def mutated(dice: Random, content: bytes, other: bytes, *, is_gltf: bool) -> bytes:
    """`content` with one to four changes; other: another file of that kind, pieces of which may come in."""
    for _ in range(dice.choice((1, 1, 1, 2, 4))):
        ways: tuple[Callable[[Random, bytes, bytes], bytes], ...] = _ANY
        if is_gltf and dice.random() < 0.8:
            ways = (_json,)
        elif b"\0" not in content[:200] and dice.random() < 0.8:
            ways = _TEXT
        content = dice.choice(ways)(dice, content, other)[:MOST_BYTES]
    return content


def _flip(dice: Random, content: bytes, _: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(dice.choice((1, 1, 2, 8))):
        if changed:
            changed[dice.randrange(len(changed))] ^= 1 << dice.randrange(8)
    return bytes(changed)


def _number(dice: Random, content: bytes, _: bytes) -> bytes:
    """A number of one to eight bytes, in either order, over what is there."""
    kind = dice.choice("BHIQfd")
    number: float = dice.choice(NUMBERS)
    if kind in "BHIQ":
        number = int(number) % 2 ** (8 * struct.calcsize(kind))
    elif kind == "f" and abs(number) > 3e38:
        number = float("inf")
    packed = struct.pack(dice.choice("<>") + kind, number)
    at = dice.randrange(len(content) + 1)
    return content[:at] + packed + content[at + len(packed) :]


def _cut(dice: Random, content: bytes, _: bytes) -> bytes:
    return content[: dice.randrange(len(content) + 1)]


def _remove(dice: Random, content: bytes, _: bytes) -> bytes:
    at = dice.randrange(len(content) + 1)
    return content[:at] + content[at + dice.choice((1, 2, 4, 16, 64)) :]


def _repeat(dice: Random, content: bytes, _: bytes) -> bytes:
    at, size = dice.randrange(len(content) + 1), dice.choice((1, 4, 16, 64, 256))
    return content[:at] + content[at : at + size] * dice.choice((2, 3, 50)) + content[at + size :]


def _splice(dice: Random, content: bytes, other: bytes) -> bytes:
    return content[: dice.randrange(len(content) + 1)] + other[dice.randrange(len(other) + 1) :]


def _word(dice: Random, content: bytes, _: bytes) -> bytes:
    lines = [line.split(b" ") for line in content.split(b"\n")]
    line = dice.choice(lines)
    line[dice.randrange(len(line))] = dice.choice(WORDS)
    return b"\n".join(b" ".join(line) for line in lines)


def _value(dice: Random, content: bytes, other: bytes) -> bytes:
    """A word of XML, STEP and their like, between quotes, commas, brackets or tags, by another one."""
    here, there = list(_VALUE.finditer(content)), _VALUE.findall(other)
    if not here or not there:
        return _flip(dice, content, b"")
    place, word = dice.choice(here), dice.choice(WORDS) if dice.random() < 0.5 else dice.choice(there)
    return content[: place.start()] + word + content[place.end() :]


def _lines(dice: Random, content: bytes, other: bytes) -> bytes:
    """A line more, less, twice, moved or from another file."""
    lines = content.split(b"\n")
    at = dice.randrange(len(lines))
    match dice.randrange(4):
        case 0:
            del lines[at]
        case 1:
            lines.insert(dice.randrange(len(lines)), lines[at])
        case 2:
            lines.insert(at, dice.choice(other.split(b"\n")))
        case _:
            lines[at] += b" " + dice.choice(WORDS)
    return b"\n".join(lines)


def _json(dice: Random, content: bytes, _: bytes) -> bytes:
    """A value of the document replaced, removed, repeated or moved; what is no document stays as it is."""
    binary = content[:4] == b"glTF"
    start = 20 if binary else 0
    end = start + int.from_bytes(content[12:16], "little") if binary else len(content)
    try:
        document = json.loads(content[start:end])
    except ValueError:
        return _flip(dice, content, b"")
    places = list(_places(document))
    if not places:
        return content
    holder, key = dice.choice(places)
    match dice.randrange(8):
        case 0 | 1 | 2:
            holder[key] = dice.choice(VALUES)
        case 3 if isinstance(holder[key], int | float):
            holder[key] = holder[key] + dice.choice((-1, 1, 1, 4, 0.5))
        case 4:
            del holder[key]
        case 5 if isinstance(holder, list):
            holder.extend([holder[key]] * dice.choice((1, 2, 40)))
        case 6:
            holder[key] = [holder[key]]
        case _:
            source, name = dice.choice(places)
            holder[key] = json.loads(json.dumps(source[name])) if name in _keys(source) else None
    text = json.dumps(document).encode()
    if not binary:
        return text
    text += b" " * (-len(text) % 4)
    rest = content[end:]
    head = b"glTF" + struct.pack("<II", 2, 20 + len(text) + len(rest))
    return head + struct.pack("<II", len(text), 0x4E4F534A) + text + rest


def _places(value: Any) -> Any:
    """Every holder with a key, from the outside in."""
    for key in _keys(value):
        yield value, key
        yield from _places(value[key])


def _keys(value: Any) -> list[Any]:
    return list(value) if isinstance(value, dict) else list(range(len(value))) if isinstance(value, list) else []


_ANY = (_flip, _number, _cut, _remove, _repeat, _splice)
_TEXT = (_word, _word, _value, _value, _value, _lines, _flip, _cut, _repeat, _splice)
