"""Makes small glTF files in code, so that each test shows what is in its file."""

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from gpu.scene.formats.gltf import load_gltf
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import Material, Scene

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
UV = TRIANGLE[:, :2]
_CODES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class GltfFile:
    """A glTF file in the making: `json` is free to be changed, data goes into the one binary buffer."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}}
        self.binary = bytearray()

    def add(self, array: str, **entry: Any) -> int:
        self.json.setdefault(array, []).append(entry)
        return len(self.json[array]) - 1

    def view(self, data: bytes, **more: Any) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        start = len(self.binary)
        self.binary += data
        return self.add("bufferViews", buffer=0, byteOffset=start, byteLength=len(data), **more)

    def accessor(self, values: Any, **more: Any) -> int:
        values = np.asarray(values)
        values = values.astype(np.float32) if values.dtype == np.float64 else values
        kind = _TYPES[values.shape[1] if values.ndim > 1 else 1]
        code = _CODES[values.dtype.name]
        return self.add("accessors", bufferView=self.view(values.tobytes()), componentType=code, count=len(values),
                        type=kind, **more)  # fmt: skip

    def primitive(self, positions: Any = TRIANGLE, indices: Any = None, **more: Any) -> dict[str, Any]:
        """A primitive. Keys of `more` in capitals are attributes (values, or an accessor's number)."""
        names = {"POSITION": positions, **{key: more.pop(key) for key in list(more) if key.isupper() or "_0" in key}}
        attributes = {n: value if isinstance(value, int) else self.accessor(value) for n, value in names.items()}
        if indices is not None:
            more["indices"] = self.accessor(np.asarray(indices, np.uint16))
        return {"attributes": attributes, **more}

    def mesh_node(self, *primitives: dict[str, Any], mesh: dict[str, Any] | None = None, **node: Any) -> int:
        number = self.add("meshes", primitives=list(primitives) or [self.primitive()], **(mesh or {}))
        return self.add("nodes", mesh=number, **node)

    def write(self, name: str = "scene.glb") -> Path:
        if self.binary:
            self.binary += b"\0" * (-len(self.binary) % 4)
            self.json.setdefault("buffers", [{}])
            self.json["buffers"][0]["byteLength"] = len(self.binary)
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if self.binary:
            chunks += struct.pack("<II", len(self.binary), 0x004E4942) + bytes(self.binary)
        path = self.folder / name
        path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
        return path

    def load(self, limits: SceneLimits = DEFAULT_LIMITS) -> Scene:
        return load_gltf(self.write(), limits)


def corners(scene: Scene) -> np.ndarray:
    """World positions (triangle, 3, 3) of all triangles' corners."""
    world = scene.vertices.astype(np.float64) / scene.placement.scale + scene.placement.centre
    return np.round(world[scene.triangles], 5) + 0.0


def image(gltf: GltfFile, kind: str = "PNG", size: tuple[int, int] = (2, 1), **options: object) -> int:
    """Adds a red image of `size` (width, height) to the file's binary data; its number."""
    file = io.BytesIO()
    Image.new("RGB", size, (255, 0, 0)).save(file, kind, **options)
    return gltf.add("images", bufferView=gltf.view(file.getvalue()), mimeType=f"image/{kind.lower()}")


def material_of(gltf: GltfFile, uvs: int = 1, **material: object) -> Material:
    """What is read of a material, used by a triangle with so many sets of UVs."""
    gltf.add("materials", **material)
    gltf.mesh_node(gltf.primitive(material=0, **{f"TEXCOORD_{number}": UV for number in range(uvs)}))
    return gltf.load().materials[0]
