"""Scenes: from a file or a built-in name to plain arrays that a device can take."""

from pathlib import Path

from gpu.errors import SceneError
from gpu.scene.gltf import load_gltf
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.meshes import load_mesh
from gpu.scene.obj import load_obj
from gpu.scene.types import Scene

__all__ = ["DEFAULT_LIMITS", "Scene", "SceneLimits", "load_scene"]


def load_scene(source: str, limits: SceneLimits = DEFAULT_LIMITS) -> Scene:
    """The built-in scene called `source`, or the scene in the file at that path (glTF, GLB, OBJ, PLY, STL, OFF).

    Raises SceneError when there is no such scene, its format is not known, or its content is not sound.
    """
    from gpu.scene.builtin import BUILTIN

    if source in BUILTIN:
        return BUILTIN[source]()
    path = Path(source)
    readers = {
        ".gltf": load_gltf,
        ".glb": load_gltf,
        ".obj": load_obj,
        ".ply": load_mesh,
        ".stl": load_mesh,
        ".off": load_mesh,
    }
    reader = readers.get(path.suffix.lower())
    if reader is None:
        known = f"a file ({', '.join(readers)}) or one of {', '.join(BUILTIN)}"
        raise SceneError(source, "", f"is not a scene; give {known}")
    return reader(path, limits)
