"""EXT_meshopt_compression: buffer views packed by meshoptimizer, read with the library meshopt, an extra.

KHR_meshopt_compression is the same with one more filter and a newer bitstream.
"""

from gpu.scene.formats.extras import library
from gpu.scene.formats.gltf.values import Value
from gpu.scene.limits import SceneLimits
from gpu.scene.validate import check_count

_NAMES = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_MODES = ("ATTRIBUTES", "TRIANGLES", "INDICES")
_FILTERS = ("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR")


def packed_view(view: Value) -> Value | None:
    """The extension of the buffer view, or None where it is not packed."""
    if not view.has("extensions"):
        return None
    found = (view.extension(name) for name in _NAMES)
    return next((extension for extension in found if extension is not None), None)


def unpack_view(packed: Value, data: memoryview, limits: SceneLimits) -> memoryview:
    """The bytes of a view with the extension `packed`, of which `data` are the packed ones.

    Raises SceneError when they are broken, hold less than the extension says, or the extra is not installed;
    ForbiddenError when they would be more than `limits` allow.
    """
    meshopt = library(packed.source, "meshopt", "meshopt")
    mode, filter_ = packed.text("mode"), packed.text("filter", "NONE")
    for key, value, known in (("mode", mode, _MODES), ("filter", filter_, _FILTERS)):
        if value not in known:
            raise packed.get(key).error(f"must be one of {', '.join(known)}, not {value!r:.40}")
    count, stride = packed.integer("count", low=1), packed.integer("byteStride", low=1, high=256)
    check_count(f"{packed.source}: {packed.path}", "bytes", count * stride, limits.max_file_bytes, "max_file_bytes")
    try:
        rows = meshopt.decode_gltf_buffer(bytes(data), count, stride, mode, filter_)
    except (ValueError, RuntimeError, MemoryError) as error:
        raise packed.error(f"not data that meshoptimizer packed: {error}") from error
    return memoryview(rows.tobytes())
