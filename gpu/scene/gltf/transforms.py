"""Transforms of glTF nodes as 4×4 column-vector matrices."""

import numpy as np

from gpu.scene.gltf.accessors import read_finite
from gpu.scene.gltf.buffers import Buffers
from gpu.scene.gltf.values import Value
from gpu.scene.transforms import LEAST_QUATERNION, compose
from gpu.scene.types import Doubles

_NEARLY = 1e-5  # what float32 arithmetic makes of a matrix's last row
_ROUNDED = 0.02  # what quantization makes of a quaternion's length
_IDENTITY = tuple(float(value) for value in np.eye(4).reshape(-1))


def local_matrix(node: Value) -> Doubles:
    """The node's matrix (4, 4), from `matrix` or translation, rotation and scale. Raises SceneError."""
    if node.has("matrix"):
        matrix = np.array(node.numbers("matrix", _IDENTITY, -1e30, 1e30)).reshape(4, 4).T
        if np.abs(matrix[3] - _IDENTITY[12:]).max() > _NEARLY:
            node.get("matrix").mend(f"its last row must be 0, 0, 0, 1, not {matrix[3].tolist()}, and was taken as that")
        matrix[3] = _IDENTITY[12:]
        if {"translation", "rotation", "scale"} & node.raw.keys():
            node.mend("has both a matrix and translation, rotation or scale; the matrix was used")
        return matrix
    parts = local_parts(node)[None]
    return composed(node, parts[:, 0:3], parts[:, 3:7], parts[:, 7:10])[0]


def local_parts(node: Value) -> Doubles:
    """The node's translation, rotation (x, y, z, w) and scale, (10,). Raises SceneError."""
    translation = node.numbers("translation", (0.0, 0.0, 0.0), -1e30, 1e30)
    rotation = node.numbers("rotation", (0.0, 0.0, 0.0, 1.0), -1e30, 1e30)
    return np.array([*translation, *rotation, *node.numbers("scale", (1.0, 1.0, 1.0), -1e30, 1e30)])


def instance_matrices(buffers: Buffers, extension: Value) -> Doubles:
    """Matrices (instance, 4, 4) of EXT_mesh_gpu_instancing. Raises SceneError."""
    attributes = extension.object("attributes")
    defaults = {"TRANSLATION": (0.0, 0.0, 0.0), "ROTATION": (0.0, 0.0, 0.0, 1.0), "SCALE": (1.0, 1.0, 1.0)}
    rows = {n: read_finite(buffers, attributes, n, (len(d),)) for n, d in defaults.items() if attributes.has(n)}
    counts = {len(values) for values in rows.values()}
    if len(counts) != 1:
        raise attributes.error("needs TRANSLATION, ROTATION or SCALE, each with as many elements as the others")
    count = counts.pop()
    return composed(extension, *(rows.get(name, np.tile(value, (count, 1))) for name, value in defaults.items()))


def composed(place: Value, translation: Doubles, rotation: Doubles, scale: Doubles) -> Doubles:
    """`compose` of what is at `place`; said where a rotation is odd."""
    length = np.linalg.norm(rotation, axis=1)
    if (length < LEAST_QUATERNION).any():
        place.mend("a rotation is a quaternion without direction (0, 0, 0, 0): it turns nothing")
    elif (np.abs(length - 1.0) > _ROUNDED).any():
        place.mend("a rotation is a quaternion whose length is not 1: it turns as the one of length 1 does")
    return compose(translation, rotation, scale)
