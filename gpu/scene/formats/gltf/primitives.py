"""Mesh primitives of a glTF file: attributes and triangles, in the mesh's own space."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gpu.scene.animation.motion import MorphTarget
from gpu.scene.formats.gltf.accessors import check_finite, read_floats, read_indices
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.draco import read_draco
from gpu.scene.formats.gltf.values import Value, kind_of
from gpu.scene.types import Doubles

_POINTS_AND_LINES = (0, 1, 2, 3)
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_COMPONENTS = {"POSITION": (3,), "NORMAL": (3,), "TANGENT": (4,), "COLOR": (3, 4), "TEXCOORD": (2,), "JOINTS": (4,),
               "WEIGHTS": (4,)}  # fmt: skip
# What stands for a row that is not finite; a normal of 0 becomes the geometric one.
_OTHERWISE = {"NORMAL": (0.0, "geometric normals were"), "COLOR": (1.0, "white was")}


@dataclass(frozen=True, eq=False)
class Primitive:
    """One primitive. attributes: rows (vertex, component) by glTF's name; triangles: (triangle, 3) indices."""

    path: str
    attributes: dict[str, Doubles]
    triangles: NDArray[np.int64]
    targets: tuple[MorphTarget, ...]


def read_primitive(buffers: Buffers, entry: Value, uv_sets: int, targets: Collection[int], *,
                   tangents: bool = False) -> Primitive | None:  # fmt: skip
    """The primitive at `entry` with its first `uv_sets` UV sets, with those of its morph targets that are named, and
    with its tangents if these are wanted.

    None, and said, where there is no surface: points, lines, no positions. Attributes other than positions are left
    out when they are broken. Raises SceneError when positions or indices are.
    """
    ignored = buffers.document.ignored
    mode = entry.integer("mode", _TRIANGLES, 0, 6)
    if mode in _POINTS_AND_LINES:
        ignored.add("points and lines have no surface and were ignored")
        return None
    listed = entry.part("attributes")
    if not listed.has("POSITION"):
        ignored.add("has no positions and was left out", entry.path)
        return None
    components = {name: _COMPONENTS[_base(name)] for name in sorted(listed.raw) if _is_read(name, uv_sets, tangents)}
    compressed = entry.extension("KHR_draco_mesh_compression")
    decoded, indices = read_draco(buffers, entry, compressed, components) if compressed else ({}, None)
    positions = decoded["POSITION"] if "POSITION" in decoded else read_floats(buffers, listed, "POSITION", (3,))
    attributes = {"POSITION": positions}
    for name in [name for name in components if name != "POSITION"]:
        read = partial(_attribute, buffers, listed, name, decoded.get(name), len(positions))
        rows = buffers.document.attempt(read, name)
        if rows is not None:
            attributes[name] = rows
    morphs = tuple(_targets(buffers, entry, targets, attributes))
    if indices is None:
        indices = read_indices(buffers, entry, "indices") if entry.has("indices") else np.arange(len(positions))
    if len(indices) and int(indices.max()) >= len(positions):
        at = int(np.argmax(indices >= len(positions)))
        raise entry.error(f"index {at} is {indices[at]}, there are {len(positions)} vertices")
    if mode == _TRIANGLES and len(indices) % 3:
        ignored.add("ends with an incomplete triangle, which was ignored", entry.path)
    triangles = to_triangles(indices, mode)
    if not len(triangles):
        ignored.add("has no triangles and was left out", entry.path)
        return None
    finite = np.isfinite(positions)
    if not finite.all():
        used = np.zeros(len(positions), bool)
        used[triangles] = True
        check_finite(buffers, listed, "POSITION", positions, used)
        attributes["POSITION"] = np.where(finite, positions, 0.0)
    return Primitive(entry.path, attributes, triangles, morphs)


def to_triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """Triangles (triangle, 3) of a list (4), strip (5) or fan (6); winding as glTF 2.0, section 3.7.2.1 has it."""
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    first = np.arange(max(len(indices) - 2, 0))
    if mode == _STRIP:
        return indices[np.stack([first, first + 1 + first % 2, first + 2 - first % 2], axis=1)]
    return indices[np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)]


def _base(name: str) -> str:
    return name.rpartition("_")[0] or name


def _is_read(name: str, uv_sets: int, tangents: bool) -> bool:
    """Whether the attribute is one of those that surfaces and skins are made of."""
    base, _, number = name.rpartition("_")
    if base == "TEXCOORD":
        return number in map(str, range(uv_sets))
    if name == "TANGENT":
        return tangents
    return name in ("POSITION", "NORMAL", "COLOR_0") or (base in ("JOINTS", "WEIGHTS") and number.isdecimal())


def _attribute(buffers: Buffers, listed: Value, name: str, decoded: Doubles | None, vertices: int) -> Doubles:
    """The rows of an attribute, with what is wrong in some of them mended. Raises SceneError when all of it is."""
    place, base = f"{listed.path}.{name}", _base(name)
    rows = read_floats(buffers, listed, name, _COMPONENTS[base]) if decoded is None else decoded
    if len(rows) != vertices:
        raise listed.error(f"{name} has {len(rows)} elements, POSITION {vertices}")
    finite = np.isfinite(rows)
    if not finite.all():
        wrong = np.logical_not(finite.all(axis=1, keepdims=True))
        value, said = _OTHERWISE.get(base, (0.0, "0 was"))
        problem = f"{np.count_nonzero(wrong)} of {vertices} are not finite: {said} used"
        listed.notes.add(problem, place, kind=kind_of(place))
        rows = np.where(wrong, value, rows)
    if base == "COLOR" and ((rows < 0.0) | (rows > 1.0)).any():
        listed.notes.add("has colours outside 0 to 1, which were clamped", place, kind="colours")
        rows = np.clip(rows, 0.0, 1.0)
    return np.maximum(rows, 0.0) if base == "WEIGHTS" else rows


def _targets(
    buffers: Buffers, entry: Value, wanted: Collection[int], attributes: dict[str, Doubles]
) -> Iterator[MorphTarget]:
    """The morph targets of `entry`; those that are not `wanted`, or broken, change nothing."""
    for number, target in enumerate(entry.parts("targets")):
        shifts: dict[str, Doubles | None] = {"POSITION": None, "NORMAL": None}
        for name in shifts:
            if number in wanted and name in attributes and target.has(name):
                read = partial(_attribute, buffers, target, name, None, len(attributes[name]))
                shifts[name] = buffers.document.attempt(read, "the morph target")
        yield MorphTarget(shifts["POSITION"], shifts["NORMAL"])
