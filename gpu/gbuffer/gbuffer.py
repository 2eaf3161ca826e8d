"""Shading points (SPs): primary rays, and what is needed to shade where they end. Step 3 of the 2022 paper."""

from functools import cache

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.panes import transmitted
from gpu.device_scene.rays import seen_hit
from gpu.device_scene.surface import surface_at
from gpu.gbuffer.camera_rays import CameraData, pixel_ray
from gpu.lights.background import background


@wp.struct
class GBuffer:
    """What the camera sees, one element a pixel, row by row from the top left.

    face: triangle of the SP, NO_HIT where there is none; position, geometric_normal, normal: of the SP in unit space,
    normals on the side it is seen from; to_camera: unit direction to where the SP is seen from; spacing: size of a
    pixel there; albedo, diffuse, f0, f90, roughness: as gpu.device_scene.surface.Surface; throughput: share of the SP's
    light that reaches the camera; emitted: radiance that reaches the camera from emitters and the sky without the SP
    [W/m²/sr].
    """

    face: wp.array[int]
    position: wp.array[wp.vec3]
    geometric_normal: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    to_camera: wp.array[wp.vec3]
    spacing: wp.array[float]
    albedo: wp.array[wp.vec3]
    diffuse: wp.array[wp.vec3]
    f0: wp.array[wp.vec3]
    f90: wp.array[float]
    roughness: wp.array[float]
    throughput: wp.array[wp.vec3]
    emitted: wp.array[wp.vec3]


@wp.func
def reflectance(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """Radiance that the camera gets of an SP per irradiance."""
    return wp.cw_mul(gbuffer.throughput[pixel], gbuffer.albedo[pixel]) / PI


@cache
def primary_ray_kernel(texels: bool, one_sided: bool, backdrop: bool, panes: bool, environment: bool) -> wp.Kernel:
    """The kernel for scenes whose surfaces show `texels`, or neither textures nor masks, and with or without the others
    of gpu.device_scene.features.
    """

    @wp.kernel(module="unique")
    def primary_ray_kernel(
        first: int, scene: SceneData, cameras: wp.array[CameraData], image: ImageSize, out: GBuffer
    ) -> None:
        """One thread a pixel: its ray and the surface that it meets. cameras: one element."""
        pixel = first + wp.tid()
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        if wp.static(not one_sided):
            scene.one_sided = False
        if wp.static(not backdrop):
            scene.backdrop_count = 0
        if wp.static(not panes):
            scene.pane_count = 0
        if wp.static(not environment):
            scene.has_environment = False
        camera = cameras[0]
        ray = pixel_ray(camera, pixel, image)
        hit = seen_hit(scene, ray.origin, ray.direction)
        out.face[pixel] = hit.face
        out.to_camera[pixel] = -ray.direction
        throughput = transmitted(scene, ray.origin, ray.direction, hit.t)
        out.throughput[pixel] = throughput
        if hit.face == NO_HIT:
            out.emitted[pixel] = wp.cw_mul(throughput, background(scene, ray.origin, ray.direction))
            return
        surface = surface_at(scene, hit, ray.direction)
        out.position[pixel] = surface.position
        out.geometric_normal[pixel] = surface.geometric_normal
        out.normal[pixel] = surface.normal
        distance = wp.where(camera.orthographic, 1.0, ray.start + hit.t)
        out.spacing[pixel] = distance * 2.0 * camera.half_height / float(image.height)
        out.albedo[pixel] = surface.albedo
        out.diffuse[pixel] = surface.diffuse
        out.f0[pixel] = surface.f0
        out.f90[pixel] = surface.f90
        out.roughness[pixel] = surface.roughness
        out.emitted[pixel] = wp.cw_mul(throughput, surface.emission)

    return primary_ray_kernel


def trace_primary_rays(scene: SceneData, camera: wp.array, size: tuple[int, int], out: GBuffer,
                       features: SceneFeatures = EVERYTHING) -> None:  # fmt: skip
    """Fill `out` for an image of `size` (width, height) through `camera`, (1,) CameraData."""
    inputs, has = [scene, camera, image_size(size), out], features
    kernel = primary_ray_kernel(has.texels, has.one_sided, has.backdrop, has.panes, has.environment)
    launch(kernel, size[0] * size[1], inputs, out.face.device)
