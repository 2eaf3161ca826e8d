"""Nodes of an FBX scene as mesh parts, lights and cameras, in the file's coordinates."""

from collections.abc import Iterator, Sequence
from math import cos, radians
from typing import Any

import numpy as np

from gpu.scene.floats import triple
from gpu.scene.formats.fbx.extracted import Extracted, matrix_of
from gpu.scene.formats.fbx.materials import Materials
from gpu.scene.geometry.normals import unit_rows
from gpu.scene.geometry.polygons import TOO_LARGE, triangulate
from gpu.scene.scene_parts import MeshPart
from gpu.scene.transforms import placed, rigid
from gpu.scene.types import Camera, Light, LightKind
from gpu.scene.validate import check_count, check_finite, check_indices

_KINDS = {0: LightKind.POINT, 1: LightKind.DIRECTIONAL, 2: LightKind.SPOT}
_QUADRATIC = 2


def read_parts(found: Extracted, nodes: Sequence[dict[str, Any]], materials: Materials) -> Iterator[MeshPart]:
    """The meshes of `nodes`, a part a material. Raises SceneError when one is broken or limits are exceeded."""
    triangles = 0
    for node in nodes:
        if "mesh" in node:
            for part in _mesh_parts(found, node, materials):
                triangles += len(part.triangles)
                check_count(str(found.path), "triangles", triangles, found.limits.max_triangles, "max_triangles")
                yield placed(part, matrix_of(node["geometry_to_world"])[None])


def _mesh_parts(found: Extracted, node: dict[str, Any], materials: Materials) -> Iterator[MeshPart]:
    source, name = str(found.path), node["name"] or f"mesh {node['mesh']}"

    def array(key: str) -> Any:
        return found.arrays.get(f"mesh{node['mesh']}.{key}")

    points, corners, counts = array("points"), array("corners"), array("counts")
    check_finite(source, f"{name}: vertices", points)
    check_indices(source, f"{name}: polygons", corners, len(points))
    cut = triangulate(points, corners, counts)
    if cut.crossing:
        found.remarks.add("faces that cross themselves were filled as far as they can be", name)
    if cut.too_small:
        found.remarks.add("faces of fewer than 3 corners were left out", name)
    if cut.too_large:
        found.remarks.add(TOO_LARGE, name)
    holes, numbers = array("holes"), array("materials")
    shown = ~holes[cut.polygons].astype(bool) if len(holes) else np.ones(len(cut.polygons), bool)
    slots = numbers[cut.polygons] if len(numbers) == len(counts) else np.zeros(len(cut.polygons), np.int64)
    normals, uv, color = array("normal"), array("uv"), array("color")
    for slot in np.unique(slots[shown]):
        triangles = cut.triangles[shown & (slots == slot)]
        used, compact = np.unique(triangles, return_inverse=True)
        listed = node["materials"]
        yield MeshPart(
            positions=points[corners[used]],
            triangles=compact.reshape(-1, 3),
            normals=None if normals is None else normals[used],
            # FBX's v = 0 is the bottom of a texture, glTF's the top.
            uvs=() if uv is None else (uv[used] * (1.0, -1.0) + (0.0, 1.0),),
            colors=None if color is None else color[used],
            material=materials.number(listed[slot] if slot < len(listed) else None),
            name=name,
        )


def read_light(found: Extracted, node: dict[str, Any]) -> Light:
    """The light of a node. Its intensity has no unit in FBX, and is taken as W/sr or, of directional ones, W/m²."""
    light, matrix = node["light"], matrix_of(node["to_world"])
    kind = _KINDS.get(int(light["type"]))
    if kind is None:
        found.remarks.add("area and volume lights are shown as point lights", node["name"])
    if kind is not LightKind.DIRECTIONAL and int(light["decay"]) != _QUADRATIC:
        found.remarks.add("lights fade with the square of the distance, whatever their decay", node["name"])
    direction = unit_rows((matrix[:3, :3] @ light["local_direction"])[None])[0][0]
    outer = radians(min(light["outer_angle"], 180.0)) / 2.0
    inner = min(radians(light["inner_angle"]) / 2.0, outer)
    return Light(
        name=node["name"],
        kind=LightKind.POINT if kind is None else kind,
        intensity=triple(np.maximum(np.array(light["color"]) * light["intensity"], 0.0)),
        position=triple(matrix[:3, 3]),
        direction=triple(direction) if direction.any() else (0.0, 0.0, -1.0),
        cos_inner=cos(inner),
        cos_outer=cos(outer),
    )


def read_camera(found: Extracted, node: dict[str, Any]) -> Camera | None:
    """The camera of a node; None, and said, if it has no extent."""
    camera = node["camera"]
    orthographic = bool(camera["projection_mode"])
    width, height = camera["orthographic_size" if orthographic else "field_of_view_tan"]
    if not (width > 0.0 and height > 0.0):
        found.remarks.add("a camera without a field of view was left out", node["name"])
        return None
    half_height = height / 2.0 if orthographic else height
    return Camera(node["name"], rigid(matrix_of(node["to_world"])), half_height, width / height, orthographic)
