"""Indirect light in narrow specular lobes: a ray of each glossy pixel, which ends in the light that VPLs know.

The ray is drawn as the lobe reflects (gpu.device_scene.bsdf.sample_specular). Where it ends, the light that is
reflected there counts; what emits, and the sky, are direct light, which has rays of the lobe itself. Pixels share what
they find as far as their lobes overlap, and a walk's frames as far as roughness lets them (gpu.denoise.direct_history).
"""

from dataclasses import dataclass
from functools import cache

import warp as wp

from gpu.core.constants import PI, RAY_LENGTH
from gpu.core.device import allocate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.morton import morton_2d
from gpu.core.parameters import parameters
from gpu.device_scene.bsdf import (
    MIN_COSINE,
    even_matt,
    even_reflectance,
    fresnel,
    sample_specular,
    specular_lobe,
    traced_share,
)
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import closest_hit, offset_origin
from gpu.device_scene.surface import Surface, surface_at
from gpu.direct.direct_light import DirectSamples
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, surface_of
from gpu.sampling.sobol import sobol_pair_at
from gpu.vpl.radiosity_cache import RadiosityCache
from gpu.vpl.radiosity_mean import mean_irradiance

# The sequence of `sobol_pair_at` that lobes take, beside those of direct light and chains.
LOBE_PAIR = wp.constant(8)
# Of the à-trous transform, each twice the one before; a launch each.
STEPS = (1, 2, 4, 8)
# Of a ray into the surface itself, which others may still hear of.
NO_REACH = wp.constant(1.0e-6)


@wp.struct
@dataclass
class GlossParameters:
    """What pixels share of what their rays find.

    lobe_share: of a lobe's width where its ray ends, over which lobes are alike; plane_tolerance: how far off its plane
    a pixel still shows a surface, in its spacings a step; roughness_tolerance: roughness that differs by this is of
    another surface.
    """

    lobe_share: float = 0.5
    plane_tolerance: float = 0.5
    roughness_tolerance: float = 0.05


GLOSS_PARAMETERS: GlossParameters = parameters(GlossParameters)


@wp.struct
class LobeLight:
    """What rays of specular lobes find, (pixel,) each. light: over `even_specular` of the SP [W/m²/sr]; reach: of
    `lobe_reach`, 0 where there is no ray.
    """

    light: wp.array[wp.vec3]
    reach: wp.array[float]


@wp.func
def even_specular(surface: Surface, view: wp.vec3) -> wp.vec3:
    """What the specular lobe reflects of light that is even all around; more than zero."""
    return wp.max(even_reflectance(surface, view) - even_matt(surface), wp.vec3(1.0e-4, 1.0e-4, 1.0e-4))


@wp.func
def lobe_reach(gbuffer: GBuffer, pixel: int, camera: CameraData, image: ImageSize, distance: float,
               chosen: GlossParameters) -> float:  # fmt: skip
    """How far from a pixel's SP its lobe is about the same, where what it shows is at `distance`."""
    roughness = gbuffer.roughness[pixel]
    # Facets tilt by about α, light by twice that. Rays of pixels beside each other spread, too.
    width = 2.0 * roughness * roughness * distance
    if camera.orthographic:
        return chosen.lobe_share * width
    way = gbuffer.spacing[pixel] * float(image.height) / (2.0 * camera.half_height)
    return chosen.lobe_share * width * way / (way + distance)


@cache
def glossy_ray_kernel(alpha: bool, textures: bool) -> wp.Kernel:
    """The kernel for scenes with or without these of gpu.device_scene.features."""

    @wp.kernel(module="unique")
    def glossy_ray_kernel(
        first: int,
        scene: SceneData,
        cameras: wp.array[CameraData],
        image: ImageSize,
        gbuffer: GBuffer,
        lit: RadiosityCache,
        samples: DirectSamples,
        chosen: GlossParameters,
        out: LobeLight,
    ) -> None:
        """One thread a pixel: a ray of its SP's specular lobe, if that is narrow. cameras: one element."""
        pixel = first + wp.tid()
        out.light[pixel] = wp.vec3(0.0, 0.0, 0.0)
        out.reach[pixel] = 0.0
        if gbuffer.face[pixel] == NO_HIT:
            return
        if traced_share(gbuffer.roughness[pixel], gbuffer.f90[pixel]) == 0.0:
            return
        if wp.static(not alpha):
            scene.ignore_alpha = True
        if wp.static(not textures):
            scene.textured = False
        surface = surface_of(gbuffer, pixel)
        view = gbuffer.to_camera[pixel]
        place = morton_2d(pixel % image.width, pixel // image.width)
        point = sobol_pair_at(place, samples.moment[0], LOBE_PAIR, samples.seed)
        lobe = sample_specular(surface, view, point.x, point.y)
        out.reach[pixel] = NO_REACH
        if lobe.density == 0.0 or wp.dot(lobe.direction, surface.geometric_normal) <= 0.0:
            return
        origin = offset_origin(surface.position, surface.geometric_normal, lobe.direction)
        hit = closest_hit(scene, origin, lobe.direction, RAY_LENGTH)
        if hit.face == NO_HIT:
            out.reach[pixel] = lobe_reach(gbuffer, pixel, cameras[0], image, 1.0, chosen)
            return
        out.reach[pixel] = lobe_reach(gbuffer, pixel, cameras[0], image, hit.t, chosen)
        met = surface_at(scene, hit, lobe.direction)
        arriving = mean_irradiance(lit, met.position, met.geometric_normal)
        found = wp.cw_mul(even_reflectance(met, -lobe.direction), arriving) / PI
        half = wp.normalize(view + lobe.direction)
        cos_view = wp.max(wp.dot(surface.normal, view), MIN_COSINE)
        cos_light = wp.dot(surface.normal, lobe.direction)
        weight = specular_lobe(surface, cos_view, cos_light, half) * cos_light / lobe.density
        reflected = fresnel(surface, wp.dot(view, half)) * weight
        out.light[pixel] = wp.cw_div(wp.cw_mul(reflected, found), even_specular(surface, view))

    return glossy_ray_kernel


@wp.kernel
def share_gloss_kernel(first: int, gbuffer: GBuffer, image: ImageSize, step: int, chosen: GlossParameters,
                       reach: wp.array[float], light: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: its light mixed with that of the eight pixels `step` away, as far as their lobes overlap."""
    pixel = first + wp.tid()
    out[pixel] = light[pixel]
    if reach[pixel] == 0.0:
        return
    x = pixel % image.width
    y = pixel // image.width
    away = gbuffer.spacing[pixel] * float(step)
    total = float(4.0)
    mixed = light[pixel] * 4.0
    for neighbour in range(9):
        dx = neighbour % 3 - 1
        dy = neighbour // 3 - 1
        column = x + dx * step
        row = y + dy * step
        if neighbour != 4 and column >= 0 and column < image.width and row >= 0 and row < image.height:
            other = row * image.width + column
            if reach[other] > 0.0:
                share = float((2 - wp.abs(dx)) * (2 - wp.abs(dy)))
                # Of both lobes, so that what one takes of another it gives back.
                alike = wp.clamp(2.0 - 2.0 * away / (reach[pixel] + reach[other]), 0.0, 1.0)
                rougher = (gbuffer.roughness[other] - gbuffer.roughness[pixel]) / chosen.roughness_tolerance
                weight = share * alike * wp.exp(-rougher * rougher)
                if weight > 0.0:
                    weight *= edge_stopping_weight(gbuffer, pixel, other, step, chosen.plane_tolerance)
                    total += weight
                    mixed += light[other] * weight
    out[pixel] = mixed / total


@wp.kernel
def add_gloss_kernel(first: int, gbuffer: GBuffer, light: wp.array[wp.vec3], radiance: wp.array[wp.vec3]) -> None:
    """One thread a pixel: adds to `radiance` (pixel,) what its specular lobe reflects of the `light` (pixel,)."""
    pixel = first + wp.tid()
    if gbuffer.face[pixel] != NO_HIT:
        share = traced_share(gbuffer.roughness[pixel], gbuffer.f90[pixel])
        if share > 0.0:
            even = even_specular(surface_of(gbuffer, pixel), gbuffer.to_camera[pixel]) * share
            radiance[pixel] += wp.cw_mul(gbuffer.throughput[pixel], wp.cw_mul(even, light[pixel]))


class GlossyReflection:
    """Of an image of `size` (width, height) of a scene with these `features`; its arrays are allocated once.

    light (pixel,): what the lobes' rays found, over what lobes reflect of even light [W/m²/sr].
    """

    def __init__(self, size: tuple[int, int], device: wp.Device, features: SceneFeatures,
                 chosen: GlossParameters = GLOSS_PARAMETERS) -> None:  # fmt: skip
        self._image, self._device, self._features, self._chosen = image_size(size), device, features, chosen
        pixels = size[0] * size[1]
        self._found: LobeLight = allocate(LobeLight, pixels, device)
        self.light = self._found.light
        self._other = wp.zeros(pixels, dtype=wp.vec3, device=device)

    def trace(self, scene: SceneData, camera: wp.array, gbuffer: GBuffer, lit: RadiosityCache,
              samples: DirectSamples) -> None:  # fmt: skip
        """Find the light that the SPs' lobes reflect, by the cache `lit`, by one ray each.

        camera: (1,) CameraData; samples: which of the lobes' they are.
        """
        kernel = glossy_ray_kernel(self._features.alpha, self._features.textures)
        inputs = [scene, camera, self._image, gbuffer, lit, samples, self._chosen, self._found]
        launch(kernel, len(self.light), inputs, self._device)

    def share(self, gbuffer: GBuffer) -> None:
        """Share the light between pixels of one surface."""
        source, target = self.light, self._other
        for step in STEPS:
            inputs = [gbuffer, self._image, step, self._chosen, self._found.reach, source, target]
            launch(share_gloss_kernel, len(source), inputs, self._device)
            source, target = target, source

    def add(self, gbuffer: GBuffer, radiance: wp.array) -> None:
        """Add what the lobes reflect to `radiance` (pixel,)."""
        launch(add_gloss_kernel, len(radiance), [gbuffer, self.light, radiance], self._device)
