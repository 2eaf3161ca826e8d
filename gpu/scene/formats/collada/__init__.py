"""COLLADA scenes (.dae, .zae), versions 1.4 and 1.5: https://www.khronos.org/collada."""

from pathlib import Path

from gpu.scene.assemble import assemble
from gpu.scene.formats.collada.document import open_document
from gpu.scene.formats.collada.geometry import Meshes
from gpu.scene.formats.collada.lights_and_cameras import read_camera, read_light
from gpu.scene.formats.collada.materials import Materials
from gpu.scene.formats.collada.nodes import placed_instances
from gpu.scene.formats.collada.unread import say_unread
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Camera, Light, Scene


def load_collada(path: Path, limits: SceneLimits = DEFAULT_LIMITS, options: ImportOptions = DEFAULT_OPTIONS) -> Scene:
    """The scene in the COLLADA file at `path`, in the pose that it has without animation.

    Raises SceneError for what is broken or too large.
    """
    document = open_document(path, limits)
    materials = Materials(document)
    meshes = Meshes(document, materials)
    lights: list[Light] = []
    cameras: list[Camera] = []
    for instance in placed_instances(document):
        if instance.kind in ("instance_geometry", "instance_controller"):
            meshes.add(instance)
        elif instance.kind == "instance_light":
            lights += read_light(document, instance)
        else:
            cameras += read_camera(document, instance)
    parts, metres = meshes.parts(), document.metres_per_unit
    say_unread(document)
    scene = SceneParts(
        meshes=parts,
        materials=materials.materials,
        textures=materials.textures,
        lights=lights,
        cameras=cameras,
        ignored=document.remarks.sentences(),
        up=document.up,
        metres_per_unit=metres,
    )
    return assemble(str(path), scene, limits, options)
