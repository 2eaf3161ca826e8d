"""The container of a glTF file: .glb chunks or .gltf text, its JSON, and what was read of it but not understood."""

import json
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.formats.files import read_bytes
from gpu.scene.formats.gltf.values import Value
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks

T = TypeVar("T")

_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


@dataclass(frozen=True)
class Document:
    """An opened glTF file. binary: the GLB's binary chunk or None; ignored: what is not used of it."""

    path: Path
    root: Value
    binary: bytes | None
    limits: SceneLimits
    ignored: Remarks = field(default_factory=Remarks)

    @property
    def notes(self) -> Remarks:
        """What is shown otherwise than the file says."""
        return self.root.notes

    def referred(self, place: Value, key: str, array: str) -> Value:
        """The object of the file's `array` whose index `place` has at `key`. Raises SceneError when there is none."""
        return self.root.element(array, place, key)

    def attempt(self, read: Callable[[], T], what: str) -> T | None:
        """What `read` returns; None, and said that `what` was left out, when what it reads is broken.

        Raises ForbiddenError.
        """
        try:
            return read()
        except ForbiddenError:
            raise
        except SceneError as error:
            self.ignored.add(f"{error.problem}; {what} was left out", error.field, kind=what)
            return None


def open_document(path: Path, limits: SceneLimits) -> Document:
    """Read `path`. Raises SceneError when the container or JSON is broken, or the file is not glTF 2."""
    return read_document(path, read_bytes(path, limits), limits)


def read_document(path: Path, content: bytes, limits: SceneLimits) -> Document:
    """`content`, of the file at `path` or made from it, as `open_document` reads it."""
    notes = Remarks()
    text, binary = _chunks(str(path), content, notes) if content[:4] == b"glTF" else (content, None)
    try:
        raw = json.loads(_text(text, notes))
    except (ValueError, RecursionError) as error:
        raise SceneError(str(path), "", f"not a glTF file, neither GLB nor JSON: {error}") from error
    document = Document(path, Value(str(path), "", raw, notes), binary, limits)
    if not isinstance(raw, dict):
        raise document.root.error("must be an object")
    _check_version(document.root.part("asset"))
    return document


def _text(content: bytes, notes: Remarks) -> str:
    """JSON's text: UTF-8, or UTF-16 as some editors write it, with or without a mark of the byte order."""
    encoding = json.detect_encoding(content)
    if encoding != "utf-8":
        notes.add(f"its text is {encoding} where glTF has UTF-8 without a byte order mark")
    try:
        return content.decode(encoding)
    except UnicodeDecodeError:
        notes.add("its text is not UTF-8 and was read as Windows-1252: names may be wrong")
        return content.decode("cp1252", "replace")


def _chunks(source: str, content: bytes, notes: Remarks) -> tuple[bytes, bytes | None]:
    """The JSON and binary chunks of a GLB (glTF 2.0, section 4.4)."""
    if len(content) < 20:
        raise SceneError(source, "GLB header", "the file is cut off")
    _, version, length = struct.unpack_from("<4sII", content)
    if version != 2:
        raise SceneError(source, "GLB header", f"version {version}; only glTF 2.0 is read")
    if length > len(content):
        raise SceneError(source, "GLB header", f"the file has {len(content)} of {length} bytes; it is cut off")
    notes.add_count("bytes after the end that the GLB header says were ignored", len(content) - length)
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", content, start)
        if start + 8 + size > length:
            raise SceneError(source, f"GLB chunk at byte {start}", f"its {size} bytes reach beyond the file's end")
        if start == 12 and kind != _JSON_CHUNK:
            raise SceneError(source, "GLB chunk at byte 12", "the first chunk must be JSON")
        chunks.setdefault(kind, content[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON_CHUNK not in chunks:
        raise SceneError(source, "GLB header", "the file has no JSON chunk")
    return chunks[_JSON_CHUNK], chunks.get(_BINARY_CHUNK)


def _check_version(asset: Value) -> None:
    """Raise SceneError for a file that is, or needs, another glTF than 2.0; one that does not say is taken for it."""
    for key in ("version", "minVersion"):
        text = str(asset.raw.get(key, "2.0" if key == "minVersion" else ""))
        found = re.match(r"(\d+)\.(\d+)", text)
        if found is None:
            asset.mend(f"its {key} is {text!r:.20}; the file was read as glTF 2.0")
        elif found[1] != "2":
            raise asset.get(key).error(f"glTF {text!r:.20}; only glTF 2.0 is read")
        elif key == "minVersion" and found[2] != "0":
            raise asset.get(key).error(f"needs glTF {text!r:.20}; only 2.0 is read")
