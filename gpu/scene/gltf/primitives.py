"""Mesh primitives of a glTF file: attributes and triangles, in the mesh's own space."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gpu.scene.gltf.accessors import read_floats, read_indices
from gpu.scene.gltf.buffers import Buffers
from gpu.scene.gltf.draco import read_draco
from gpu.scene.gltf.values import Value
from gpu.scene.types import Doubles

_POINTS_AND_LINES = (0, 1, 2, 3)
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_COMPONENTS = {"POSITION": (3,), "NORMAL": (3,), "COLOR": (3, 4), "TEXCOORD": (2,), "JOINTS": (4,), "WEIGHTS": (4,)}


@dataclass(frozen=True, eq=False)
class Primitive:
    """One primitive. attributes: rows (vertex, component) by glTF's name; triangles: (triangle, 3) indices."""

    path: str
    attributes: dict[str, Doubles]
    triangles: NDArray[np.int64]


def read_primitive(buffers: Buffers, entry: Value, uv_sets: int, weights: tuple[float, ...]) -> Primitive | None:
    """The primitive at `entry` with its first `uv_sets` UV sets, bent by its morph targets' `weights`.

    None for points and lines, which have no surface. Raises SceneError when the primitive is broken.
    """
    mode = entry.integer("mode", _TRIANGLES, 0, 6)
    if mode in _POINTS_AND_LINES:
        buffers.document.say("points and lines have no surface and were ignored")
        return None
    listed = entry.get("attributes")
    wanted = ["POSITION", "NORMAL", "COLOR_0", "JOINTS_0", "WEIGHTS_0", *(f"TEXCOORD_{n}" for n in range(uv_sets))]
    components = {name: _COMPONENTS[name.rpartition("_")[0] or name] for name in wanted if listed.has(name)}
    if "POSITION" not in components:
        raise listed.error("'POSITION' is missing")
    compressed = entry.extension("KHR_draco_mesh_compression")
    decoded, indices = read_draco(buffers, entry, compressed, components) if compressed else ({}, None)
    attributes = {
        name: decoded[name] if name in decoded else read_floats(buffers, listed, name, expected)
        for name, expected in components.items()
    }
    vertices = len(attributes["POSITION"])
    for name, rows in attributes.items():
        if len(rows) != vertices:
            raise entry.error(f"{name} has {len(rows)} elements, POSITION {vertices}")
    _morph(buffers, entry, weights, attributes)
    if indices is None:
        indices = read_indices(buffers, entry, "indices") if entry.has("indices") else np.arange(vertices)
    if len(indices) and int(indices.max()) >= vertices:
        at = int(np.argmax(indices >= vertices))
        raise entry.error(f"index {at} is {indices[at]}, there are {vertices} vertices")
    if mode == _TRIANGLES and len(indices) % 3:
        buffers.document.say(f"{entry.path} ends with an incomplete triangle, which was ignored")
    return Primitive(entry.path, attributes, to_triangles(indices, mode))


def to_triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """Triangles (triangle, 3) of a list (4), strip (5) or fan (6); winding as glTF 2.0, section 3.7.2.1 has it."""
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    first = np.arange(max(len(indices) - 2, 0))
    if mode == _STRIP:
        return indices[np.stack([first, first + 1 + first % 2, first + 2 - first % 2], axis=1)]
    return indices[np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)]


def _morph(buffers: Buffers, entry: Value, weights: tuple[float, ...], attributes: dict[str, Doubles]) -> None:
    """Add the morph targets of `entry`, weighted, to the positions and normals in `attributes`."""
    for target, weight in zip(entry.objects("targets"), weights, strict=False):
        for name in {"POSITION", "NORMAL"} & attributes.keys():
            if weight != 0.0 and target.has(name):
                shift = read_floats(buffers, target, name, (3,))
                if len(shift) != len(attributes[name]):
                    raise target.error(f"{name} has {len(shift)} elements, the mesh {len(attributes[name])}")
                attributes[name] = attributes[name] + weight * shift
