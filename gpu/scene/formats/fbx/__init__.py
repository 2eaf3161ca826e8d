"""FBX scenes (.fbx), text and binary, read with ufbx, an extra: https://ufbx.github.io."""

from pathlib import Path
from typing import Any

from gpu.scene.assemble import assemble
from gpu.scene.formats.extras import library
from gpu.scene.formats.fbx.extracted import Extracted, run_extract
from gpu.scene.formats.fbx.materials import Materials
from gpu.scene.formats.fbx.nodes import read_camera, read_light, read_parts
from gpu.scene.formats.files import read_bytes
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Scene


def load_fbx(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the FBX file at `path`, in the pose that it has without animation.

    Raises SceneError for what is broken or too large, and where ufbx is not installed.
    """
    library(str(path), "ufbx", "fbx")
    found = run_extract(path, read_bytes(path, limits), limits)
    materials = Materials(found)
    shown = [node for node in found.told["nodes"] if _shown(found, node)]
    parts = list(read_parts(found, shown, materials))
    scene = SceneParts(
        meshes=parts,
        materials=materials.materials,
        textures=materials.textures,
        lights=[read_light(found, node) for node in shown if "light" in node],
        cameras=[camera for node in shown if "camera" in node and (camera := read_camera(found, node))],
        ignored=found.remarks.sentences(),
        up=found.told["up"],
        metres_per_unit=found.told["metres"],
    )
    return assemble(str(path), scene, limits, options)


def _shown(found: Extracted, node: dict[str, Any]) -> bool:
    if not node["visible"]:
        found.remarks.add("invisible nodes were left out", node["name"])
    return bool(node["visible"])
