"""Files for uploads to survive: the Khronos validator's corpus, its samples, and GLBs broken at random."""

import io
import json
import random
import struct
import zipfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any
from urllib.parse import unquote

SMALL_BYTES = 200_000


@dataclass(frozen=True)
class Case:
    """A file to upload. valid: what the validator says, if it was asked."""

    name: str
    content: bytes
    valid: bool | None = None


@cache
def malformed(shared: Path) -> list[Case]:
    """The validator's own test files, each with its report beside it."""
    return [
        _packed(path, json.loads(report.read_bytes())["issues"]["numErrors"] == 0)
        for path in _gltf_files(shared / "malformed")
        if (report := path.with_name(path.name + ".report.json")).is_file()
    ]


@cache
def samples(shared: Path) -> list[Case]:
    """Khronos' sample models, in each form."""
    return [_packed(path, True) for path in _gltf_files(shared / "gltf-samples")]


def mutated(shared: Path, seeds: Iterable[int]) -> Iterator[Case]:
    """Small GLBs with something wrong in them, the same one for a seed each time."""
    sound = [path.read_bytes() for path in sorted((shared / "gltf-samples").rglob("*.glb"))]
    sound = [content for content in sound if len(content) < SMALL_BYTES]
    ways: list[Callable[[random.Random, bytearray], bytes]] = [_flip, _flip_header, _cut, _swap, _length, _number]
    for seed in seeds:
        dice = random.Random(seed)
        way = dice.choice(ways)
        yield Case(f"mutated-{seed}.glb", way(dice, bytearray(dice.choice(sound))))


def _gltf_files(folder: Path) -> list[Path]:
    return sorted([*folder.rglob("*.glb"), *folder.rglob("*.gltf")])


def _packed(path: Path, valid: bool) -> Case:
    """The file itself, or an archive of it with the files beside it that it refers to."""
    content = path.read_bytes()
    beside = _referred(path, content)
    if not beside:
        return Case(path.name, content, valid)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(path.name, content)
        for uri in sorted(beside):
            archive.write(path.parent / uri, uri)
    return Case(f"{path.stem}.zip", packed.getvalue(), valid)


def _referred(path: Path, content: bytes) -> set[str]:
    try:
        document = json.loads(content)
        entries = [*document.get("buffers", []), *document.get("images", [])]
        uris = {unquote(entry["uri"]) for entry in entries if "uri" in entry}
        return {uri for uri in uris if ".." not in uri and (path.parent / uri).is_file()}
    except (ValueError, AttributeError, TypeError, OSError):
        return set()


def _flip(dice: random.Random, content: bytearray) -> bytes:
    for _ in range(dice.choice((1, 4, 64))):
        content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    return bytes(content)


def _flip_header(dice: random.Random, content: bytearray) -> bytes:
    content[dice.randrange(20)] ^= 1 << dice.randrange(8)
    return bytes(content)


def _cut(dice: random.Random, content: bytearray) -> bytes:
    return bytes(content[: dice.randrange(len(content))])


def _swap(dice: random.Random, content: bytearray) -> bytes:
    """A piece of the file over another one."""
    size = dice.choice((4, 64, 1024))
    source, target = (dice.randrange(max(len(content) - size, 1)) for _ in range(2))
    content[target : target + size] = content[source : source + size]
    return bytes(content)


def _length(dice: random.Random, content: bytearray) -> bytes:
    """A wrong length of the file or of a chunk."""
    json_bytes = struct.unpack_from("<I", content, 12)[0]
    place = dice.choice((8, 12, min(20 + json_bytes, len(content) - 4)))
    struct.pack_into("<I", content, place, dice.choice((0, 1, 2**31, 2**32 - 1, dice.randrange(2**20))))
    return bytes(content)


def _number(dice: random.Random, content: bytearray) -> bytes:
    """A number of the JSON replaced by one that is wrong, or may be."""
    json_bytes = struct.unpack_from("<I", content, 12)[0]
    document = json.loads(content[20 : 20 + json_bytes])
    places = list(_numbers(document))
    for setter in dice.sample(places, min(len(places), dice.choice((1, 1, 3)))):
        setter(dice.choice((-1, 0, 1, 7, 5126, 65_535, 2**31 - 1, 2**32, 2**63, 1e30, -1e-30, 0.5, 1e308)))
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = bytes(content[20 + json_bytes :])
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(binary), len(text), 0x4E4F534A) + text + binary


def _numbers(value: Any) -> Iterator[Callable[[Any], None]]:
    """A setter for each number in a JSON value."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in inner:
        if isinstance(item, int | float) and not isinstance(item, bool):
            yield partial(value.__setitem__, key)
        yield from _numbers(item)
