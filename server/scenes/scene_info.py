"""What viewers are told of a scene."""

from dataclasses import asdict
from math import atan, radians, tan
from pathlib import Path

import numpy as np

from gpu.scene.edits import AIMED, PLACED
from gpu.scene.floats import triple
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.lighting.added_daylight import has_sun, with_daylight
from gpu.scene.lighting.surroundings import EVEN, surrounded
from gpu.scene.parts import LightPart, lights_of, material_ids
from gpu.scene.types import Camera, Doubles, Material, Scene
from server.wire.browser import (
    AnimationInfo,
    Bounds,
    CameraInfo,
    LightInfo,
    MaterialInfo,
    ObjectInfo,
    SceneFrame,
    SceneInfo,
)

MOST_CAMERAS = 256  # that are listed, more than anyone chooses from; the others can be named by their number

# Fields of view of cameras that are listed: within those of a pose, and of an orthographic one [rad].
FIELDS_OF_VIEW, PLAN_FIELDS_OF_VIEW = (0.011, 3.09), (radians(1.0), radians(120.0))
MOST_PARTS = 1000  # lights, and materials, that are listed: who edits chooses from them


def describe_scene(
    scene_id: str, scene: Scene, options: ImportOptions = DEFAULT_OPTIONS, *, in_environment: bool = False
) -> SceneInfo:
    """A scene's cameras and bounds in world space, its lights and materials, and its notes; options: how it was read;
    in_environment: an environment of the service's will be around it.

    Of a scene as `load_scene` gives it this is less than two megabytes of JSON.
    """
    if in_environment:
        scene = surrounded(scene, EVEN)
    notes = scene.report.notes + scene.report.ignored
    if scene.report.dropped_triangles:
        notes += (f"{scene.report.dropped_triangles} triangles without area were dropped",)
    if len(scene.cameras) > MOST_CAMERAS:
        notes += (f"{len(scene.cameras)} cameras, of which the first {MOST_CAMERAS} are listed",)
    lights, ids = lights_of(scene), material_ids(scene)
    for count, what in ((len(lights), "lights"), (len(ids), "materials"), (len(scene.objects), "objects")):
        if count > MOST_PARTS:
            notes += (f"{count} {what}, of which the first {MOST_PARTS} can be edited",)
    low, high = scene.bounds
    listed = scene.cameras[:MOST_CAMERAS]
    return SceneInfo(
        id=scene_id,
        name=Path(scene_id).stem,
        cameras=tuple(_describe_camera(camera, np.mean(scene.bounds, axis=0)) for camera in listed),
        bounds=Bounds(min=low, max=high),
        frame=SceneFrame(**asdict(scene.frame)),
        options=options,
        choices={name: tuple(offered) for name, offered in scene.choices.items()},
        lights=_describe_lights(scene, lights[:MOST_PARTS]),
        materials=tuple(map(_describe_material, ids[:MOST_PARTS], scene.materials)),
        objects=_describe_objects(scene),
        animations=_describe_animations(scene),
        triangles=len(scene.triangles),
        notes=notes,
    )


def _describe_objects(scene: Scene) -> tuple[ObjectInfo, ...]:
    boxes = zip(*scene.object_boxes, strict=True)
    listed = zip(scene.objects[:MOST_PARTS], boxes, strict=False)
    return tuple(ObjectInfo(id=one, box=Bounds(min=triple(low), max=triple(high))) for one, (low, high) in listed)


def _describe_animations(scene: Scene) -> tuple[AnimationInfo, ...]:
    listed = () if scene.motion is None else scene.motion.animations
    return tuple(AnimationInfo(id=animation.id, seconds=animation.seconds) for animation in listed)


def _describe_lights(scene: Scene, parts: tuple[LightPart, ...]) -> tuple[LightInfo, ...]:
    lit = with_daylight(scene, sun=not has_sun(scene), sky=False)
    return tuple(_describe_light(part, lit) for part in parts)


def _describe_light(part: LightPart, scene: Scene) -> LightInfo:
    info = LightInfo(id=part.id, form=part.form, color=part.color, added=part.added)
    if part.form not in PLACED and part.form not in AIMED:
        return info
    light, placement = scene.lights[part.index], scene.placement
    place = triple(np.array(light.position) / placement.scale + placement.centre)
    moved = {"position": place} if part.form in PLACED else {}
    return info.model_copy(update=moved | ({"direction": light.direction} if part.form in AIMED else {}))


def _describe_material(one: str, material: Material) -> MaterialInfo:
    red, green, blue = (min(max(value, 0.0), 1.0) for value in material.base_color[:3])
    return MaterialInfo(
        id=one,
        color=(red, green, blue),
        roughness=material.roughness,
        metallic=material.metallic,
        emission=material.emission,
    )


def _describe_camera(camera: Camera, centre: Doubles) -> CameraInfo:
    """A camera that a walk can begin with. An orthographic one becomes a perspective one that shows as much at the
    scene's centre, from nearer or farther away where that would be too narrow or too wide for a walk.
    """
    to_world, near = camera.to_world.copy(), camera.near
    if camera.orthographic:
        distance = float(np.linalg.norm(to_world[:3, 3] - centre))
        farthest, nearest = (camera.half_height / tan(angle / 2.0) for angle in PLAN_FIELDS_OF_VIEW)
        kept = min(max(distance, nearest), farthest)
        to_world[:3, 3] += (kept - distance) * to_world[:3, 2]
        yfov, near = 2.0 * atan(camera.half_height / kept), max(near + kept - distance, 0.0)
    else:
        yfov = min(max(2.0 * atan(camera.half_height), FIELDS_OF_VIEW[0]), FIELDS_OF_VIEW[1])
    return CameraInfo(
        name=camera.name,
        matrix=tuple(float(value) for value in to_world.T.flatten()),
        yfov=yfov,
        aspect=camera.aspect,
        orthographic=camera.orthographic,
        near=near,
    )
