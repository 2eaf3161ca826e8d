"""The container of a glTF file: .glb chunks or .gltf text, its JSON, and what was read of it but not understood."""

import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

from gpu.errors import SceneError
from gpu.scene.files import read_bytes
from gpu.scene.gltf.values import Value
from gpu.scene.limits import SceneLimits

_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


@dataclass(frozen=True)
class Document:
    """An opened glTF file. binary: the GLB's binary chunk or None; ignored: sentences for the report, in order."""

    path: Path
    root: Value
    binary: bytes | None
    limits: SceneLimits
    ignored: dict[str, None] = field(default_factory=dict)

    def referred(self, place: Value, key: str, array: str) -> Value:
        """The object of the file's `array` whose index `place` has at `key`. Raises SceneError when there is none."""
        objects = self.root.raw.get(array, [])
        if not isinstance(objects, list):
            raise self.root.get(array).error("must be an array")
        number = place.get(key).as_index(len(objects))
        found = Value(self.root.source, f"{array}[{number}]", objects[number])
        if not isinstance(found.raw, dict):
            raise found.error("must be an object")
        return found

    def say(self, sentence: str) -> None:
        """Tell the user once that something in the file is not taken as it is."""
        self.ignored[sentence] = None


def open_document(path: Path, limits: SceneLimits) -> Document:
    """Read `path`. Raises SceneError when the container or JSON is broken, or the file is not glTF 2."""
    content = read_bytes(path, limits)
    text, binary = _chunks(str(path), content) if content[:4] == b"glTF" else (content, None)
    try:
        raw = json.loads(text.decode("utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise SceneError(str(path), "", f"not a glTF file: {error}") from error
    document = Document(path, Value(str(path), "", raw), binary, limits)
    _check_version(document.root.get("asset"))
    return document


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


def _chunks(source: str, content: bytes) -> tuple[bytes, bytes | None]:
    """The JSON and binary chunks of a GLB (glTF 2.0, section 4.4)."""
    if len(content) < 20:
        raise SceneError(source, "GLB header", "the file is cut off")
    _, version, length = struct.unpack_from("<4sII", content)
    if version != 2:
        raise SceneError(source, "GLB header", f"version {version}; only glTF 2.0 is read")
    if length > len(content):
        raise SceneError(source, "GLB header", f"the file has {len(content)} of {length} bytes; it is cut off")
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
    for key in ("minVersion", "version"):
        if asset.has(key) or key == "version":
            version = asset.text(key)
            if not version.startswith("2."):
                raise asset.get(key).error(f"glTF {version!r:.20}; only glTF 2.0 is read")
    if asset.text("minVersion", "2.0") != "2.0":
        raise asset.get("minVersion").error(f"needs glTF {asset.text('minVersion')!r:.20}; only 2.0 is read")
