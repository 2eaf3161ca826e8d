"""A stage as the parts of a scene."""

from pathlib import Path

from pxr import UsdGeom, UsdLux, UsdSkel

from gpu.scene.assemble import assemble
from gpu.scene.formats.usd.cameras import read_camera
from gpu.scene.formats.usd.hierarchy import shown_prims
from gpu.scene.formats.usd.lights import Lights
from gpu.scene.formats.usd.materials import Materials
from gpu.scene.formats.usd.meshes import Meshes
from gpu.scene.formats.usd.shapes import SHAPES
from gpu.scene.formats.usd.stage import Stage, open_stage, refusing
from gpu.scene.formats.usd.variants import choose_variant
from gpu.scene.import_options import ImportOptions
from gpu.scene.limits import SceneLimits
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.transforms import placed
from gpu.scene.types import Camera, Scene
from gpu.scene.validate import check_count


def read_scene(path: Path, limits: SceneLimits, options: ImportOptions) -> Scene:
    """The scene in the USD file at `path`. Raises SceneError."""
    with refusing(path):
        return assemble(str(path), _parts(open_stage(path, limits), limits, options), limits, options)


def _parts(stage: Stage, limits: SceneLimits, options: ImportOptions) -> SceneParts:
    """What a stage has that is shown. Raises SceneError, and the errors of USD."""
    variants = choose_variant(stage.usd, options.variant)
    metres = UsdGeom.GetStageMetersPerUnit(stage.usd)
    materials = Materials(stage)
    meshes, lights = Meshes(stage, materials), Lights(materials, metres)
    parts: list[MeshPart] = []
    cameras: list[Camera] = []
    triangles = 0
    for shown in shown_prims(stage):
        prim = shown.prim
        if any(prim.IsA(kind) for kind in (UsdGeom.Mesh, *SHAPES)):
            for part in meshes.parts(prim):
                triangles += len(part.triangles) * len(shown.to_world)
                check_count(str(stage.path), "triangles", triangles, limits.max_triangles, "max_triangles")
                parts.append(placed(part, shown.to_world))
            if prim.HasAPI(UsdLux.LightAPI):
                stage.remarks.add("lights of kind MeshLightAPI are not shown", str(prim.GetPath()))
        elif prim.HasAPI(UsdLux.LightAPI):
            lights.read(shown)
        elif prim.IsA(UsdGeom.Camera):
            camera = read_camera(stage, shown)
            cameras += [camera] if camera else []
        elif prim.IsA(UsdSkel.Root):
            stage.remarks.add("skinned meshes are shown in their bind pose", str(prim.GetPath()))
        elif prim.IsA(UsdGeom.Gprim):
            stage.remarks.add(f"prims of kind {prim.GetTypeName()} are not shown", str(prim.GetPath()))
    return SceneParts(
        meshes=[*parts, *lights.parts],
        materials=materials.materials,
        textures=materials.textures.textures,
        lights=lights.lights,
        cameras=cameras,
        sky=lights.sky,
        ignored=stage.remarks.sentences(),
        up="z" if UsdGeom.GetStageUpAxis(stage.usd) == UsdGeom.Tokens.z else "y",
        metres_per_unit=metres,
        choices={"variant": variants} if variants else {},
    )
