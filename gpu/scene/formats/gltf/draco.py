"""KHR_draco_mesh_compression: attributes and indices from a Draco bitstream."""

import DracoPy
import numpy as np
from numpy.typing import NDArray

from gpu.scene.formats.gltf.accessors import dequantised
from gpu.scene.formats.gltf.buffers import Buffers
from gpu.scene.formats.gltf.values import Value
from gpu.scene.types import Doubles


def read_draco(
    buffers: Buffers, entry: Value, extension: Value, components: dict[str, tuple[int, ...]]
) -> tuple[dict[str, Doubles], NDArray[np.int64]]:
    """The attributes that the primitive `entry` has compressed, and its triangles' indices (index,).

    components: the wanted attributes, and how many components each may have.

    Raises SceneError when the bitstream is broken or does not hold what `extension` says.
    """
    data, _ = buffers.view(extension, "bufferView")
    try:
        mesh = DracoPy.decode(bytes(data))
        faces = np.asarray(mesh.faces, np.int64)
        streams = {stream["unique_id"]: np.asarray(stream["data"]) for stream in mesh.attributes}
    except Exception as error:  # DracoPy raises several unrelated kinds; a point cloud has no `faces`
        raise extension.error(f"not a Draco mesh: {error}") from error
    if entry.integer("mode", 4) not in (4, 5):
        raise entry.error("only triangles can be compressed with Draco")
    compressed = extension.object("attributes")
    attributes = {}
    for name, expected in components.items():
        if compressed.has(name):
            number = compressed.integer(name)
            if number not in streams:
                raise compressed.get(name).error(f"the Draco data has no attribute {number}")
            accessor = buffers.document.referred(entry.get("attributes"), name, "accessors")
            rows = streams[number].reshape(len(streams[number]), -1)
            if rows.shape[1] not in expected:
                raise compressed.get(name).error("the Draco data has another type there")
            attributes[name] = dequantised(rows, accessor.flag("normalized"))
    vertices = len(next(iter(streams.values()), ()))
    if faces.size and not 0 <= int(faces.min()) <= int(faces.max()) < vertices:
        raise extension.error(f"the Draco data has an index out of range, there are {vertices} vertices")
    return attributes, faces.reshape(-1)
