"""Shading points (SPs): primary rays, and what is needed to shade where they end. Step 3 of the 2022 paper."""

from functools import cache

import numpy as np
import warp as wp

from gpu.device import launch
from gpu.lights import FAR, sky_radiance
from gpu.needs import EVERYTHING, Needs
from gpu.rays import closest_hit
from gpu.resident import NO_HIT, ResidentScene, SceneData
from gpu.sampling import PI
from gpu.scene.types import Camera, Placement
from gpu.surface import surface_at

RAY_LENGTH = wp.constant(1.0e6)
# The face of a pixel that sees nothing but is worked on like the others.
BACKDROP = wp.constant(-2)


@wp.struct
class CameraData:
    """A camera in unit space. right, up, back: unit axes; half_width, half_height: of the image plane at distance 1.

    An orthographic camera's are in unit lengths instead. x, y: where in a pixel its ray goes through, in [0, 1).
    """

    origin: wp.vec3
    right: wp.vec3
    up: wp.vec3
    back: wp.vec3
    half_width: float
    half_height: float
    orthographic: bool
    x: float
    y: float


@wp.struct
class GBuffer:
    """What the camera sees, one element a pixel, row by row from the top left.

    face: triangle of the SP, NO_HIT where there is none (or BACKDROP); position, geometric, normal: of the SP in unit
    space, normals on the side it is seen from; view: unit direction to where the SP is seen from; spacing: size of a
    pixel there; albedo, diffuse, f0, roughness: as gpu.surface.Surface; throughput: share of the SP's light that
    reaches the camera; shown: radiance that reaches the camera from emitters and the sky without the SP [W/m²/sr].
    """

    face: wp.array[int]
    position: wp.array[wp.vec3]
    geometric: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    view: wp.array[wp.vec3]
    spacing: wp.array[float]
    albedo: wp.array[wp.vec3]
    diffuse: wp.array[wp.vec3]
    f0: wp.array[wp.vec3]
    roughness: wp.array[float]
    throughput: wp.array[wp.vec3]
    shown: wp.array[wp.vec3]


@wp.func
def reflectance(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """Radiance that the camera gets of an SP per irradiance."""
    return wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI


def camera_data(
    camera: Camera, placement: Placement, aspect: float, place: tuple[float, float] = (0.5, 0.5)
) -> CameraData:
    """`camera` in unit space, for an image whose width is `aspect` times its height; place: in each pixel, for rays."""
    axes = camera.to_world[:3, :3] / np.linalg.norm(camera.to_world[:3, :3], axis=0)
    origin = (camera.to_world[:3, 3] - np.asarray(placement.centre)) * placement.scale
    half_height = camera.half_height * (placement.scale if camera.orthographic else 1.0)
    data = CameraData()
    data.origin = wp.vec3(*origin)
    data.right, data.up, data.back = (wp.vec3(*axes[:, k]) for k in range(3))
    data.half_height, data.half_width = half_height, half_height * aspect
    data.orthographic = camera.orthographic
    data.x, data.y = place
    return data


@wp.struct
class CameraRay:
    """A camera's ray; direction: unit length."""

    origin: wp.vec3
    direction: wp.vec3


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
    return ray


@wp.func
def pixel_ray(camera: CameraData, pixel: int, width: int, height: int) -> CameraRay:
    """The ray through the camera's place in `pixel` of an image of width × height."""
    x = (float(pixel % width) + camera.x) / float(width)
    y = (float(pixel // width) + camera.y) / float(height)
    return camera_ray(camera, x, y)


@wp.func
def image_point(camera: CameraData, position: wp.vec3, width: int, height: int) -> wp.vec2:
    """Where `position` is in the image [pixels]: whole numbers where pixels' rays pass; −1, −1 where it is outside."""
    way = position - camera.origin
    depth = float(1.0)
    if not camera.orthographic:
        depth = -wp.dot(way, camera.back)
        if depth <= 0.0:
            return wp.vec2(-1.0, -1.0)
    right = wp.dot(way, camera.right) / (depth * camera.half_width)
    up = wp.dot(way, camera.up) / (depth * camera.half_height)
    if wp.abs(right) > 1.0 or wp.abs(up) > 1.0:
        return wp.vec2(-1.0, -1.0)
    return wp.vec2(0.5 * (right + 1.0) * float(width) - camera.x, 0.5 * (1.0 - up) * float(height) - camera.y)


@wp.func
def pixel_of(camera: CameraData, position: wp.vec3, width: int, height: int) -> wp.vec2i:
    """Column and row of the pixel whose ray passes nearest to `position`; outside of the image for what it lacks."""
    place = image_point(camera, position, width, height)
    return wp.vec2i(int(wp.floor(place[0] + 0.5)), int(wp.floor(place[1] + 0.5)))


@wp.func
def set_backdrop(ray: CameraRay, spacing: float, pixel: int, out: GBuffer) -> None:
    """Give a pixel that sees nothing the SP of something black and far away; spacing: of pixels at distance 1."""
    black = wp.vec3(0.0, 0.0, 0.0)
    out.face[pixel] = BACKDROP
    out.position[pixel] = ray.origin + ray.direction * FAR
    out.geometric[pixel] = -ray.direction
    out.normal[pixel] = -ray.direction
    out.spacing[pixel] = FAR * spacing
    out.albedo[pixel] = black
    out.diffuse[pixel] = black
    out.f0[pixel] = black
    out.roughness[pixel] = 1.0


@cache
def primary_ray_kernel(texels: bool, backdrop: bool) -> wp.Kernel:
    """The kernel for scenes whose surfaces show `texels`, or neither textures nor masks.

    backdrop: a pixel that sees nothing gets an SP all the same.
    """

    @wp.kernel(module="unique")
    def kernel(
        first: int, scene: SceneData, cameras: wp.array[CameraData], width: int, height: int, out: GBuffer
    ) -> None:
        """One thread a pixel: its ray and the surface that it meets. cameras: one element."""
        pixel = first + wp.tid()
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        camera = cameras[0]
        ray = pixel_ray(camera, pixel, width, height)
        hit = closest_hit(scene, ray.origin, ray.direction, RAY_LENGTH)
        out.face[pixel] = hit.face
        out.view[pixel] = -ray.direction
        out.throughput[pixel] = wp.vec3(1.0, 1.0, 1.0)
        if hit.face == NO_HIT:
            out.shown[pixel] = sky_radiance(scene, ray.direction)
            if wp.static(backdrop):
                set_backdrop(ray, 2.0 * camera.half_height / float(height), pixel, out)
            return
        surface = surface_at(scene, hit, ray.direction)
        out.position[pixel] = surface.position
        out.geometric[pixel] = surface.geometric
        out.normal[pixel] = surface.normal
        out.spacing[pixel] = wp.where(camera.orthographic, 1.0, hit.t) * 2.0 * camera.half_height / float(height)
        out.albedo[pixel] = surface.albedo
        out.diffuse[pixel] = surface.diffuse
        out.f0[pixel] = surface.f0
        out.roughness[pixel] = surface.roughness
        out.shown[pixel] = surface.emission

    return kernel


def trace_primary_rays(resident: ResidentScene, scene: SceneData, camera: wp.array, size: tuple[int, int],
                       out: GBuffer, needs: Needs = EVERYTHING, *, backdrop: bool = False) -> None:  # fmt: skip
    """Fill `out` for an image of `size` (width, height).

    camera: (1,) CameraData; needs: of the scene; backdrop: pixels that see nothing get the SP of something black, so
    that they are worked on like the others.
    """
    width, height = size
    kernel = primary_ray_kernel(needs.texels, backdrop)
    launch(kernel, width * height, [scene, camera, width, height, out], resident.device)
