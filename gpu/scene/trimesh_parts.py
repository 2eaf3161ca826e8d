"""Meshes read by trimesh as mesh parts: whatever it raises is a SceneError, whatever it returns is checked later."""

import io
import warnings
from typing import Any

import numpy as np
import trimesh

from gpu.errors import SceneError
from gpu.scene.assemble import MeshPart
from gpu.scene.colors import srgb_to_linear


def load_parts(
    source: str, content: bytes, kind: str, shaded: bool, flip_v: bool = False, **options: Any
) -> list[MeshPart]:
    """The meshes in `content`, a file of `kind` ("ply", …), a part each; one with a number for name has that material.

    shaded: whether the file has vertex normals; flip_v: whether v counts from a texture's bottom. Files that the
    content names are not opened. Raises SceneError when trimesh cannot read it.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # trimesh and NumPy only warn of text that they skip
            scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False, **options)
            meshes = [(name, mesh) for name, mesh in scene.geometry.items() if isinstance(mesh, trimesh.Trimesh)]
            return [_part(name, mesh, shaded, flip_v) for name, mesh in meshes]
    except Exception as error:  # trimesh's readers raise whatever their parsing meets
        raise SceneError(source, "", f"not a {kind.upper()} file that can be read: {error}") from error


def _part(name: str, mesh: Any, shaded: bool, flip_v: bool) -> MeshPart:
    uv = getattr(mesh.visual, "uv", None)
    uvs = () if uv is None else (np.asarray(uv, np.float64)[:, :2] * (1.0, -1.0 if flip_v else 1.0) + (0.0, flip_v),)
    colors = None
    if mesh.visual.kind == "vertex":  # 0–255, encoded as on a display
        levels = np.asarray(mesh.visual.vertex_colors)
        colors = np.column_stack([srgb_to_linear(levels[:, :3]), levels[:, 3] / 255.0])
    return MeshPart(
        positions=np.asarray(mesh.vertices, np.float64),
        triangles=np.asarray(mesh.faces, np.int64),
        normals=np.asarray(mesh.vertex_normals, np.float64) if shaded else None,
        uvs=uvs,
        colors=colors,
        material=int(name) if name.isdigit() else 0,
        name=name,
    )
