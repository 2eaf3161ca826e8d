"""Transforms of glTF nodes as 4×4 column-vector matrices."""

from collections.abc import Sequence

import numpy as np

from gpu.scene.formats.gltf.accessors import read_finite
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.values import Value
from gpu.scene.transforms import LEAST_QUATERNION, compose
from gpu.scene.types import Doubles

_NEARLY = 1e-5  # what float32 arithmetic makes of a matrix's last row
_ROUNDED = 0.02  # what quantization makes of a quaternion's length
_IDENTITY = tuple(float(value) for value in np.eye(4).reshape(-1))


def local_matrices(nodes: Sequence[Value]) -> Doubles:
    """The nodes' matrices (node, 4, 4), from `matrix` or translation, rotation and scale. Raises SceneError."""
    matrices = np.empty((len(nodes), 4, 4))
    made = [number for number, node in enumerate(nodes) if not node.has("matrix")]
    parts = local_parts([nodes[number] for number in made])
    matrices[made] = compose(parts[:, 0:3], parts[:, 3:7], parts[:, 7:10])
    lengths = np.ones(len(nodes))
    lengths[made] = np.linalg.norm(parts[:, 3:7], axis=1)
    for number in np.flatnonzero(np.abs(lengths - 1.0) > _ROUNDED).tolist():
        _say_odd(nodes[number], lengths[number : number + 1])
    for number, node in enumerate(nodes):
        if node.has("matrix"):
            matrices[number] = _given_matrix(node)
    return matrices


def _given_matrix(node: Value) -> Doubles:
    matrix = np.array(node.numbers("matrix", _IDENTITY, -1e30, 1e30)).reshape(4, 4).T
    if np.abs(matrix[3] - _IDENTITY[12:]).max() > _NEARLY:
        node.get("matrix").mend(f"its last row must be 0, 0, 0, 1, not {matrix[3].tolist()}, and was taken as that")
    matrix[3] = _IDENTITY[12:]
    if {"translation", "rotation", "scale"} & node.raw.keys():
        node.mend("has both a matrix and translation, rotation or scale; the matrix was used")
    return matrix


def local_parts(nodes: Sequence[Value]) -> Doubles:
    """The nodes' translations, rotations (x, y, z, w) and scales, (node, 10). Raises SceneError."""
    rows = [
        (
            *node.numbers("translation", (0.0, 0.0, 0.0), -1e30, 1e30),
            *node.numbers("rotation", (0.0, 0.0, 0.0, 1.0), -1e30, 1e30),
            *node.numbers("scale", (1.0, 1.0, 1.0), -1e30, 1e30),
        )
        for node in nodes
    ]
    return np.array(rows).reshape(-1, 10)


def instance_matrices(buffers: Buffers, extension: Value) -> Doubles:
    """Matrices (instance, 4, 4) of EXT_mesh_gpu_instancing. Raises SceneError."""
    attributes = extension.object("attributes")
    defaults = {"TRANSLATION": (0.0, 0.0, 0.0), "ROTATION": (0.0, 0.0, 0.0, 1.0), "SCALE": (1.0, 1.0, 1.0)}
    rows = {n: read_finite(buffers, attributes, n, (len(d),)) for n, d in defaults.items() if attributes.has(n)}
    counts = {len(values) for values in rows.values()}
    if len(counts) != 1:
        raise attributes.error("needs TRANSLATION, ROTATION or SCALE, each with as many elements as the others")
    count = counts.pop()
    translation, rotation, scale = (rows.get(name, np.tile(value, (count, 1))) for name, value in defaults.items())
    _say_odd(extension, np.linalg.norm(rotation, axis=1))
    return compose(translation, rotation, scale)


def _say_odd(place: Value, lengths: Doubles) -> None:
    """Say what is odd about quaternions of these lengths (quaternion,) at `place`."""
    if (lengths < LEAST_QUATERNION).any():
        place.mend("a rotation is a quaternion without direction (0, 0, 0, 0): it turns nothing")
    elif (np.abs(lengths - 1.0) > _ROUNDED).any():
        place.mend("a rotation is a quaternion whose length is not 1: it turns as the one of length 1 does")
