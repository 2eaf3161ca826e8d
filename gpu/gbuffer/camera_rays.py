"""Cameras as kernels see them: rays through pixels, and pixels of points."""

from math import sqrt
from typing import Any

import warp as wp

from gpu.core.image_size import ImageSize
from gpu.scene.types import Camera, Placement


@wp.struct
class CameraData:
    """A camera in unit space. right, up, back: unit axes; half_width, half_height: of the image plane at distance 1.

    An orthographic camera's are in unit lengths instead. near: how far in front of it the view begins. x, y: where in a
    pixel its ray goes through, in [0, 1).
    """

    origin: wp.vec3
    right: wp.vec3
    up: wp.vec3
    back: wp.vec3
    half_width: float
    half_height: float
    orthographic: bool
    near: float
    x: float
    y: float


def camera_values(
    camera: Camera, placement: Placement, aspect: float, place: tuple[float, float] = (0.5, 0.5)
) -> tuple[Any, ...]:
    """The fields of CameraData in their order, as `camera_data` has them, for an array of such on the host."""
    # NumPy would take ten times as long for so few numbers.
    *axes, eye = zip(*camera.to_world.tolist()[:3], strict=True)
    units = (tuple(part / sqrt(x * x + y * y + z * z) for part in (x, y, z)) for x, y, z in axes)
    origin = tuple((part - centre) * placement.scale for part, centre in zip(eye, placement.centre, strict=True))
    half_height = camera.half_height * (placement.scale if camera.orthographic else 1.0)
    halves = half_height * aspect, half_height
    return origin, *units, *halves, camera.orthographic, camera.near * placement.scale, *place


def camera_data(
    camera: Camera, placement: Placement, aspect: float, place: tuple[float, float] = (0.5, 0.5)
) -> CameraData:
    """`camera` in unit space, for an image whose width is `aspect` times its height; place: in each pixel, for rays."""
    struct: Any = CameraData
    data: CameraData = struct()
    for name, value in zip(struct.vars, camera_values(camera, placement, aspect, place), strict=True):
        setattr(data, name, wp.vec3(*value) if isinstance(value, tuple) else value)
    return data


@wp.struct
class CameraRay:
    """A camera's ray from where its view begins; direction: unit length; start: distance from the camera to there."""

    origin: wp.vec3
    direction: wp.vec3
    start: float


@wp.func
def camera_ray(camera: CameraData, x: float, y: float) -> CameraRay:
    """The ray through the image's point (x, y) in [0, 1]², from the top left."""
    right = (2.0 * x - 1.0) * camera.half_width
    up = (1.0 - 2.0 * y) * camera.half_height
    ray = CameraRay()
    ray.origin = camera.origin
    ray.direction = -camera.back
    if camera.orthographic:
        ray.origin += camera.right * right + camera.up * up
    else:
        ray.direction = wp.normalize(camera.right * right + camera.up * up - camera.back)
    ray.start = camera.near / -wp.dot(ray.direction, camera.back)
    ray.origin += ray.direction * ray.start
    return ray


@wp.func
def pixel_ray(camera: CameraData, pixel: int, image: ImageSize) -> CameraRay:
    """The ray through the camera's place in `pixel` of an image."""
    x = (float(pixel % image.width) + camera.x) / float(image.width)
    y = (float(pixel // image.width) + camera.y) / float(image.height)
    return camera_ray(camera, x, y)


@wp.func
def image_point(camera: CameraData, position: wp.vec3, image: ImageSize) -> wp.vec2:
    """Where `position` is in the image [pixels]: whole numbers where pixels' rays pass; −1, −1 where it is outside."""
    offset = position - camera.origin
    depth = -wp.dot(offset, camera.back)
    if depth <= camera.near:
        return wp.vec2(-1.0, -1.0)
    if camera.orthographic:
        depth = 1.0
    right = wp.dot(offset, camera.right) / (depth * camera.half_width)
    up = wp.dot(offset, camera.up) / (depth * camera.half_height)
    if wp.abs(right) > 1.0 or wp.abs(up) > 1.0:
        return wp.vec2(-1.0, -1.0)
    x = 0.5 * (right + 1.0) * float(image.width) - camera.x
    return wp.vec2(x, 0.5 * (1.0 - up) * float(image.height) - camera.y)


@wp.func
def pixel_of(camera: CameraData, position: wp.vec3, image: ImageSize) -> wp.vec2i:
    """Column and row of the pixel whose ray passes nearest to `position`; outside of the image for what it lacks."""
    place = image_point(camera, position, image)
    return wp.vec2i(int(wp.floor(place[0] + 0.5)), int(wp.floor(place[1] + 0.5)))
