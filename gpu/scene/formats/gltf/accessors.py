"""Typed arrays of a glTF file: plain, interleaved, normalised and sparse accessors."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gpu.scene.floats import doubles
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.values import Value
from gpu.scene.types import Doubles, Mask
from gpu.scene.validate import check_count

Array = NDArray[Any]

_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_CODES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_DTYPES = {code: np.dtype(name) for code, name in _CODES.items()}


def read_indices(buffers: Buffers, place: Value, key: str) -> NDArray[np.int64]:
    """The unsigned scalars (index,) of the accessor that `place` names at `key`. Raises SceneError."""
    accessor, values = _read(buffers, place, key)
    if values.shape[1] != 1 or values.dtype.kind != "u":
        raise accessor.error("indices must be unsigned integer scalars")
    return values[:, 0].astype(np.int64)


def read_floats(buffers: Buffers, place: Value, key: str, components: tuple[int, ...]) -> Doubles:
    """Rows (row, component) of the accessor at `key`, integers scaled when it says `normalized`.

    components: how many a row may have; NaN and infinity are left in. Raises SceneError when the accessor is broken.
    """
    accessor, values = _read(buffers, place, key)
    if values.shape[1] not in components:
        raise accessor.error(f"has {values.shape[1]} components, expected {' or '.join(map(str, components))}")
    return dequantised(values, accessor.flag("normalized"))


def read_finite(buffers: Buffers, place: Value, key: str, components: tuple[int, ...]) -> Doubles:
    """As `read_floats`. Raises SceneError when a number is not finite, too."""
    rows = read_floats(buffers, place, key, components)
    check_finite(buffers, place, key, rows)
    return rows


def check_finite(buffers: Buffers, place: Value, key: str, rows: Doubles, used: Mask | None = None) -> None:
    """Raise SceneError naming the first of the `rows` of the accessor at `key` that is used (row,) but not finite."""
    wrong = ~np.isfinite(rows).all(axis=1)
    wrong = wrong if used is None else wrong & used
    if wrong.any():
        row = int(np.argmax(wrong))
        accessor = buffers.document.referred(place, key, "accessors")
        raise accessor.error(f"element {row} is not finite: {rows[row].tolist()}; repair it in the file")


def dequantised(values: Array, normalized: bool) -> Doubles:
    """Values as float64; normalised integers divided by their largest value (glTF 2.0, section 3.11)."""
    if not normalized or values.dtype.kind == "f":
        return doubles(values)
    return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)


def _read(buffers: Buffers, place: Value, key: str) -> tuple[Value, Array]:
    """The accessor and its raw elements, (element, component)."""
    accessor = buffers.document.referred(place, key, "accessors")
    dtype = _dtype(accessor)
    kind = accessor.text("type")
    if kind not in _COMPONENTS or (kind == "MAT4" and dtype.kind != "f"):
        raise accessor.error(f"type {kind!r:.20} of {dtype.name} is not one that meshes have")
    components, count = _COMPONENTS[kind], accessor.integer("count")
    limits = buffers.document.limits
    most = max(limits.max_vertices, 3 * limits.max_triangles)
    check_count(f"{accessor.source}: {accessor.path}", "elements", count, most, "max_vertices")
    if accessor.has("bufferView") and count:
        values = _elements(buffers, accessor, dtype, components, count)
    else:
        values = np.zeros((count, components), dtype)
    if accessor.has("sparse"):
        values = values.copy()
        _substitute(buffers, accessor.object("sparse"), values)
    return accessor, values


def _dtype(place: Value) -> "np.dtype[Any]":
    code = place.integer("componentType")
    if code not in _DTYPES:
        raise place.get("componentType").error(f"{code} is not a component type")
    return _DTYPES[code]


def _elements(buffers: Buffers, place: Value, dtype: "np.dtype[Any]", components: int, count: int) -> Array:
    """`count` elements of the buffer view of `place`, (element, component), without a copy."""
    data, stride = buffers.view(place, "bufferView")
    start, size = place.integer("byteOffset", 0), components * dtype.itemsize
    stride = stride or size
    end = start + stride * (count - 1) + size
    if stride < size or end > len(data):
        raise place.error(f"{count} elements end at byte {end} of a buffer view of {len(data)} bytes")
    return np.ndarray((count, components), dtype, data, start, (stride, dtype.itemsize))


def _substitute(buffers: Buffers, sparse: Value, values: Array) -> None:
    """Replace the elements of `values` that a sparse accessor lists."""
    count = sparse.integer("count", low=1, high=len(values))
    where, what = sparse.object("indices"), sparse.object("values")
    rows = _elements(buffers, where, _dtype(where), 1, count)[:, 0]
    if rows.dtype.kind != "u" or int(rows.max()) >= len(values):
        raise where.error(f"must be unsigned integers below {len(values)}")
    values[rows] = _elements(buffers, what, values.dtype, values.shape[1], count)
