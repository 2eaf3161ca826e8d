"""What a camera sees at one point of its picture: which triangle, for who points at it."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.device_scene.data import NO_HIT, WHOLE, SceneData
from gpu.device_scene.rays import first_hit, seen_hit
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import CameraData, camera_data, camera_ray
from gpu.scene.floats import triple
from gpu.scene.types import Camera, Rgb


@dataclass(frozen=True)
class PickedPoint:
    """Where a camera's ray ends: triangle, of the scene's; point, in world space; its distance from the camera [m]."""

    triangle: int
    point: Rgb
    distance: float


@wp.kernel
def pick_kernel(
    first: int,
    scene: SceneData,
    camera: CameraData,
    x: float,
    y: float,
    faces: wp.array[int],
    ends: wp.array[wp.vec4],
) -> None:
    """One thread: the first surface, clear glass and veils too, along the ray through the point (x, y) in [0, 1]² of a
    picture, from the top left. faces (1,): its triangle or NO_HIT; ends (1,): where that is and how far from the
    camera, in unit space.
    """
    ray = camera_ray(camera, x, y)
    scene.coverage = WHOLE
    hit = seen_hit(scene, ray.origin, ray.direction)
    if scene.pane_count > 0:
        pane = first_hit(scene.panes, ray.origin, ray.direction, hit.t, scene.one_sided)
        if pane.face != NO_HIT:
            hit = pane
            hit.face += scene.opaque_count
    faces[first + wp.tid()] = hit.face
    end = ray.origin + ray.direction * hit.t
    ends[first + wp.tid()] = wp.vec4(end[0], end[1], end[2], ray.start + hit.t)


def pick(scene: DeviceScene, camera: Camera, place: tuple[float, float]) -> PickedPoint | None:
    """The first surface that `camera` sees at `place` in [0, 1]² of its picture, from the top left; None where it sees
    none. Masks let through what they let through in pictures.
    """
    device, placement = scene.device, scene.scene.placement
    data = camera_data(camera, placement, camera.aspect)
    faces, ends = wp.zeros(1, int, device=device), wp.zeros(1, wp.vec4, device=device)
    launch(pick_kernel, 1, [scene.view(lambertian=False), data, *place, faces, ends], device)
    face, (*end, distance) = int(faces.numpy()[0]), ends.numpy()[0].astype(np.float64)
    if face == NO_HIT:
        return None
    point = triple(np.array(end) / placement.scale + placement.centre)
    return PickedPoint(int(scene.triangle_order[face]), point, float(distance / placement.scale))
