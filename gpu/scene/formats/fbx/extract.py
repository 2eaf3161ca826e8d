"""Reads an FBX file in a process, `python -m gpu.scene.formats.fbx.extract`: stdin has the file, stdout gets arrays.

ufbx 0.0.5 frees objects that its scene still hands out, so that any of them may be gone when it is next used. So here
none is ever freed, and the process ends without tidying up. The answer is an .npz file: "json" has what is no array.
"""

import ctypes
import gc
import io
import json
import os
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import ufbx

_AXES = (ufbx.axes_right_handed_y_up, ufbx.axes_right_handed_z_up)
_CLASSIC = (ufbx.ShaderType.UNKNOWN, ufbx.ShaderType.FBX_LAMBERT, ufbx.ShaderType.FBX_PHONG)
# Colours and numbers of a material, by the name of ufbx's map; those with a texture name it.
_MAPS = (
    *(
        "base_factor",
        "base_color",
        "roughness",
        "glossiness",
        "metalness",
        "specular_factor",
        "specular_color",
        "specular_ior",
    ),
    *("emission_factor", "emission_color", "opacity", "transmission_factor", "transmission_color"),
    "normal_map",
)


def extract(content: bytes) -> dict[str, Any]:
    """The arrays of the FBX file in `content` by name, with all else as JSON text. Raises ufbx.UfbxError."""
    scene = _loaded(content)
    arrays: dict[str, Any] = {}
    nodes, meshes, materials, textures = (_kept(scene, name) for name in ("nodes", "meshes", "materials", "textures"))
    for number, mesh in enumerate(_items(meshes)):
        arrays |= {f"mesh{number}.{name}": array for name, array in _mesh(mesh).items()}
    for number, texture in enumerate(_items(textures)):
        arrays[f"texture{number}"] = np.frombuffer(_kept(texture, "content"), np.uint8)
    settings = _kept(scene, "settings")
    told = {
        "up": "z" if _kept(settings, "axes") == ufbx.axes_right_handed_z_up else "y",
        "metres": _kept(settings, "unit_meters"),
        "animated": len(_kept(scene, "anim_stacks")) > 0,
        "skinned": len(_kept(scene, "skin_deformers")) > 0,
        "curves": sum(len(_kept(scene, name)) for name in ("line_curves", "nurbs_curves", "nurbs_surfaces")),
        "nodes": [_node(node) for node in _items(nodes)],
        "materials": [_material(material) for material in _items(materials)],
        "textures": [_texture(texture) for texture in _items(textures)],
    }
    arrays["json"] = np.frombuffer(json.dumps(told).encode(), np.uint8)
    return arrays


def _loaded(content: bytes) -> Any:
    """The scene in its own axes, if they are right-handed with Y or Z up, else turned to have Y up."""
    own = {
        "target_camera_axes": ufbx.axes_right_handed_y_up,
        "ignore_animation": True,
        "file_format": ufbx.FileFormat.FBX,
    }
    scene = ufbx.load_memory(content, **own)
    if _kept(_kept(scene, "settings"), "axes") not in _AXES:
        _keep(scene)
        scene = ufbx.load_memory(content, **own, target_axes=ufbx.axes_right_handed_y_up)
    return scene


def _keep(found: Any) -> Any:
    """`found`, which is never freed."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(found))
    return found


def _kept(owner: Any, name: str) -> Any:
    return _keep(getattr(owner, name))


def _items(elements: Any) -> Iterator[Any]:
    return (_keep(element) for element in elements)


def _rows(values: Any, columns: int) -> Any:
    return np.array(memoryview(values), np.float64).reshape(-1, columns) if len(values) else np.empty((0, columns))


def _integers(values: Any) -> Any:
    return np.fromiter(values, np.int64, len(values))


def _mesh(mesh: Any) -> dict[str, Any]:
    """Points, polygons, and what each of their corners has."""
    faces = _kept(mesh, "faces")
    found = {
        "points": _rows(_kept(mesh, "vertices"), 3),
        "corners": _integers(_kept(mesh, "vertex_indices")),
        "counts": np.array(memoryview(faces), np.int64).reshape(-1, 2)[:, 1] if len(faces) else np.empty(0, np.int64),
        "materials": _integers(_kept(mesh, "face_material")),
        "holes": _integers(_kept(mesh, "face_hole")),
    }
    for name, columns in (("normal", 3), ("uv", 2), ("color", 4)):
        attribute = _kept(mesh, f"vertex_{name}")
        if _kept(attribute, "exists"):
            rows = _rows(_kept(attribute, "values"), columns)
            found[name] = rows[_integers(_kept(attribute, "indices"))]
    return found


def _node(node: Any) -> dict[str, Any]:
    told = {
        "name": _kept(node, "name"),
        "visible": bool(_kept(node, "visible")),
        "to_world": [list(column) for column in _kept(node, "node_to_world")],
    }
    mesh, light, camera = (_kept(node, name) for name in ("mesh", "light", "camera"))
    if mesh is not None:
        told["mesh"] = _kept(mesh, "typed_id")
        told["geometry_to_world"] = [list(column) for column in _kept(node, "geometry_to_world")]
        told["materials"] = [_kept(material, "typed_id") for material in _items(_kept(node, "materials"))]
    if light is not None:
        told["light"] = {
            name: _plain(_kept(light, name))
            for name in ("color", "intensity", "local_direction", "type", "decay", "inner_angle", "outer_angle")
        }
    if camera is not None:
        told["camera"] = {
            name: _plain(_kept(camera, name)) for name in ("projection_mode", "field_of_view_tan", "orthographic_size")
        }
    return told


def _material(material: Any) -> dict[str, Any]:
    maps, features = _kept(material, "pbr"), _kept(material, "features")
    told = {
        "name": _kept(material, "name"),
        "double_sided": _kept(_kept(features, "double_sided"), "enabled"),
        "classic": _kept(material, "shader_type") in _CLASSIC,
    }
    for name in _MAPS:
        found = _kept(maps, name)
        texture = _kept(found, "texture") if _kept(found, "texture_enabled") else None
        told[name] = {
            "value": _plain(_kept(found, "value_vec4")) if _kept(found, "has_value") else None,
            "texture": None if texture is None else _kept(texture, "typed_id"),
        }
    return told


def _texture(texture: Any) -> dict[str, Any]:
    return {
        "file": _kept(texture, "type") == ufbx.TextureType.FILE,
        "names": [_kept(texture, name) for name in ("relative_filename", "filename", "absolute_filename")],
        "clamped": [_kept(texture, name) == ufbx.WrapMode.CLAMP for name in ("wrap_u", "wrap_v")],
        "transform": [list(column) for column in _kept(texture, "uv_to_texture")],
    }


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else float(value)


if __name__ == "__main__":
    gc.disable()
    answer = io.BytesIO()
    try:
        np.savez(answer, **extract(sys.stdin.buffer.read()))
    except ufbx.UfbxError as problem:
        sys.stderr.write(str(problem))
        os._exit(1)
    sys.stdout.buffer.write(answer.getbuffer())
    sys.stdout.flush()
    os._exit(0)
