"""Shading points (SPs): primary rays, and what is needed to shade where they end. Step 3 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.surface import surface_at
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import RAY_LENGTH, CameraData, CameraRay, pixel_ray
from gpu.lights.light_table import FAR, sky_radiance

# The face of a pixel that sees nothing but is worked on like the others.
BACKDROP = wp.constant(-2)


@wp.struct
class GBuffer:
    """What the camera sees, one element a pixel, row by row from the top left.

    face: triangle of the SP, NO_HIT where there is none (or BACKDROP); position, geometric, normal: of the SP in unit
    space, normals on the side it is seen from; view: unit direction to where the SP is seen from; spacing: size of a
    pixel there; albedo, diffuse, f0, roughness: as gpu.device_scene.surface.Surface; throughput: share of the SP's
    light that reaches the camera; shown: radiance that reaches the camera from emitters and the sky without the SP
    [W/m²/sr].
    """

    face: wp.array[int]
    position: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
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


@wp.func
def set_backdrop(ray: CameraRay, spacing: float, pixel: int, out: GBuffer) -> None:
    """Give a pixel that sees nothing the SP of something black and far away; spacing: of pixels at distance 1."""
    black = wp.vec3(0.0, 0.0, 0.0)
    out.face[pixel] = BACKDROP
    out.position[pixel] = ray.origin + ray.direction * FAR
    out.geometric_normal[pixel] = -ray.direction
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
        out.geometric_normal[pixel] = surface.geometric_normal
        out.normal[pixel] = surface.normal
        out.spacing[pixel] = wp.where(camera.orthographic, 1.0, hit.t) * 2.0 * camera.half_height / float(height)
        out.albedo[pixel] = surface.albedo
        out.diffuse[pixel] = surface.diffuse
        out.f0[pixel] = surface.f0
        out.roughness[pixel] = surface.roughness
        out.shown[pixel] = surface.emission

    return kernel


def trace_primary_rays(device_scene: DeviceScene, scene: SceneData, camera: wp.array, size: tuple[int, int],
                       out: GBuffer, needs: SceneFeatures = EVERYTHING, *, backdrop: bool = False) -> None:  # fmt: skip
    """Fill `out` for an image of `size` (width, height).

    camera: (1,) CameraData; needs: of the scene; backdrop: pixels that see nothing get the SP of something black, so
    that they are worked on like the others.
    """
    width, height = size
    kernel = primary_ray_kernel(needs.texels, backdrop)
    launch(kernel, width * height, [scene, camera, width, height, out], device_scene.device)
