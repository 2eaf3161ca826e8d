"""Indirect light in narrow specular lobes: a ray of each glossy pixel, which ends in the light that VPLs know.

The ray is drawn as the lobe reflects (gpu.device_scene.bsdf.sample_specular). Where it ends, the light that is
reflected there counts; what emits, and the sky, are direct light, which has rays of the lobe itself. Pixels share what
they find as far as their lobes overlap, and a walk's frames as far as roughness lets them (gpu.denoise.direct_history).
"""

import warp as wp

from gpu.core.color import brightness
from gpu.core.device import allocate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.morton import morton_2d
from gpu.core.stencil import binomial_weight, pixel_beside
from gpu.denoise.lost_light import restore
from gpu.device_scene.bsdf import sample_lobe, traced_share
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.even_light import even_below, even_diffuse
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.direct.direct_light import DirectSamples
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.edge_stopping import edge_stopping_weight
from gpu.gbuffer.gbuffer import GBuffer, surface_of, surface_reader
from gpu.indirect.frosted_glass import frosted_ray_kernel
from gpu.indirect.lobe_light import (
    GLOSS_PARAMETERS,
    LOBE_PAIR,
    LOBE_REGISTERS,
    NO_EMISSION,
    NO_REACH,
    GlossParameters,
    KnownLight,
    LobeLight,
    light_along,
    lobe_ray,
    lobe_reach,
)
from gpu.sampling.sobol import sobol_pair_at

# The reach of a pixel whose light is that of those around. These must be of its surface that much.
BETWEEN = wp.constant(-1.0)
LEAST_ALIKE = wp.constant(0.5)

# Of the à-trous transform, each twice the one before; a launch each. RESTORING: of what is cut off, which is given back
# whole where a part in BELIEVED of the pixels around is of the surface.
STEPS, RESTORING, BELIEVED = (1, 2, 4, 8), (1, 2, 4, 8, 16), 4


@wp.func
def even_specular(surface: Surface, view: wp.vec3) -> wp.vec3:
    """What the specular lobe reflects of light that is even all around; more than zero."""
    return wp.max(even_below(surface, view) - even_diffuse(surface), wp.vec3(1.0e-4, 1.0e-4, 1.0e-4))


@wp.func
def alike(gbuffer: GBuffer, pixel: int, other: int, chosen: GlossParameters) -> float:
    """How far the lobes of two pixels side by side show the same, 0 to 1."""
    rougher = (gbuffer.roughness[other] - gbuffer.roughness[pixel]) / chosen.roughness_tolerance
    weight = edge_stopping_weight(gbuffer, pixel, other, 1, chosen.plane_tolerance)
    return wp.where(gbuffer.f90[other] > 0.0, weight * wp.exp(-rougher * rougher), 0.0)


@wp.func
def is_between(gbuffer: GBuffer, pixel: int, image: ImageSize, samples: DirectSamples, chosen: GlossParameters) -> bool:
    """Whether the rays of the pixels above and below speak for this one's, too, since earlier frames knew its light."""
    row = pixel // image.width
    if samples.known.shape[0] == 0 or (row + samples.frame_index[0]) % 2 == 0 or row == 0 or row == image.height - 1:
        return False
    if samples.known[pixel] < samples.settled:
        return False
    above = alike(gbuffer, pixel, pixel - image.width, chosen)
    below = alike(gbuffer, pixel, pixel + image.width, chosen)
    return wp.min(above, below) > LEAST_ALIKE


@wp.kernel
def fill_gloss_kernel(first: int, image: ImageSize, found: LobeLight) -> None:
    """One thread a pixel: where it is BETWEEN, what the pixels above and below found."""
    pixel = first + wp.tid()
    if found.reach[pixel] == BETWEEN:
        above = pixel - image.width
        below = pixel + image.width
        found.light[pixel] = (found.light[above] + found.light[below]) * 0.5
        found.reach[pixel] = 0.5 * (found.reach[above] + found.reach[below])


@made_for(*LOOK, "panes", "glass", "one_sided", "backdrop", "environment")
def glossy_ray_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)
    surface_of_pixel = surface_reader(sheen=False, grain=features.grain, translucent=False)

    @wp.kernel(module="unique", module_options={"max_unroll": 1, "fast_math": True}, cuda_max_registers=LOBE_REGISTERS)
    def glossy_ray_kernel(
        first: int,
        scene: SceneData,
        cameras: wp.array[CameraData],
        image: ImageSize,
        gbuffer: GBuffer,
        known: KnownLight,
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
        if is_between(gbuffer, pixel, image, samples, chosen):
            out.reach[pixel] = BETWEEN
            return
        scene = specialise(scene)
        surface = surface_of_pixel(gbuffer, pixel)
        view = gbuffer.to_camera[pixel]
        place = morton_2d(pixel % image.width, pixel // image.width)
        point = sobol_pair_at(place, samples.frame_index[0], LOBE_PAIR, samples.seed)
        lobe = sample_lobe(surface, view, point.x, point.y)
        out.reach[pixel] = NO_REACH
        if lobe.density == 0.0:
            return
        ray = lobe_ray(surface, lobe.direction, NO_EMISSION, place, samples.frame_index[0], samples.seed)
        seen = light_along(scene, known, ray)
        out.reach[pixel] = lobe_reach(gbuffer, pixel, cameras[0], image, seen.distance, chosen)
        out.light[pixel] = wp.cw_div(wp.cw_mul(lobe.weight, seen.light), even_specular(surface, view))

    return glossy_ray_kernel


@wp.kernel
def bound_fireflies_kernel(first: int, image: ImageSize, chosen: GlossParameters, reach: wp.array[float],
                           light: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: its light, bounded by the brightest of the eight around whose rays found some.

    One ray in hundreds that ends in a lamp by way of a mirror leaves a firefly that no neighbour would outweigh.
    """
    pixel = first + wp.tid()
    out[pixel] = light[pixel]
    if reach[pixel] == 0.0:
        return
    most = float(0.0)
    for number in range(9):
        other = pixel_beside(pixel, number, 1, image)
        if other >= 0 and other != pixel:
            most = wp.max(most, wp.where(reach[other] > 0.0, brightness(light[other]), 0.0))
    most *= chosen.most_of_brightest
    own = brightness(light[pixel])
    if most > 0.0 and own > most:
        out[pixel] = light[pixel] * (most / own)


@wp.kernel
def share_gloss_kernel(first: int, gbuffer: GBuffer, image: ImageSize, step: int, chosen: GlossParameters,
                       reach: wp.array[float], light: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a pixel: its light mixed with that of the eight pixels `step` away, as far as their lobes overlap."""
    pixel = first + wp.tid()
    out[pixel] = light[pixel]
    if reach[pixel] == 0.0:
        return
    away = gbuffer.spacing[pixel] * float(step)
    total = float(4.0)
    mixed = light[pixel] * 4.0
    for number in range(9):
        other = pixel_beside(pixel, number, step, image)
        if other >= 0 and other != pixel:
            there = reach[other]
            if there > 0.0:
                share = binomial_weight(number)
                # Of both lobes, so that what one takes of another it gives back.
                alike = wp.clamp(2.0 - 2.0 * away / (reach[pixel] + there), 0.0, 1.0)
                rougher = (gbuffer.roughness[other] - gbuffer.roughness[pixel]) / chosen.roughness_tolerance
                weight = share * alike * wp.exp(-rougher * rougher)
                if weight > 0.0:
                    weight *= edge_stopping_weight(gbuffer, pixel, other, step, chosen.plane_tolerance)
                    total += weight
                    mixed += light[other] * weight
    out[pixel] = mixed / total


@wp.kernel
def add_gloss_kernel(first: int, gbuffer: GBuffer, found: LobeLight, radiance: wp.array[wp.vec3]) -> None:
    """One thread a pixel: adds to `radiance` (pixel,) what its specular lobe or its glass shows of what is `found`."""
    pixel = first + wp.tid()
    gbuffer.translucent = False  # a lobe's share does not depend on it
    if found.reach[pixel] > 0.0:
        share = traced_share(gbuffer.roughness[pixel], gbuffer.f90[pixel])
        if share > 0.0:
            even = even_specular(surface_of(gbuffer, pixel), gbuffer.to_camera[pixel]) * share
            radiance[pixel] += wp.cw_mul(gbuffer.throughput[pixel], wp.cw_mul(even, found.light[pixel]))
        else:
            radiance[pixel] += wp.cw_mul(gbuffer.throughput[pixel], found.light[pixel])


class GlossyReflection:
    """Of an image of `size` (width, height) of a scene with these `features`; its arrays are allocated once.

    light (pixel,): what the lobes' rays found, over what lobes reflect of even light [W/m²/sr].
    """

    def __init__(self, size: tuple[int, int], device: wp.Device, features: SceneFeatures) -> None:
        self._image, self._device, self._features = image_size(size), device, features
        pixels = size[0] * size[1]
        self._found: LobeLight = allocate(LobeLight, pixels, device)
        self.light = self._found.light
        self._other, self._before = (wp.zeros(pixels, dtype=wp.vec3, device=device) for _ in range(2))
        self._believed = wp.full(pixels, BELIEVED, dtype=int, device=device)

    def trace(self, scene: SceneData, camera: wp.array, gbuffer: GBuffer, known: KnownLight,
              samples: DirectSamples) -> None:  # fmt: skip
        """Find the light that the SPs' lobes and frosted glass show, by a ray or two each, of what is `known`.

        camera: (1,) CameraData; samples: which of the lobes' they are.
        """
        has, device, pixels = self._features, self._device, len(self.light)
        inputs = [scene, camera, self._image, gbuffer, known, samples, GLOSS_PARAMETERS, self._found]
        if known.indirect:
            launch(glossy_ray_kernel(has), pixels, inputs, device)
            if samples.known is not None:
                launch(fill_gloss_kernel, pixels, [self._image, self._found], device)
        else:
            self.light.zero_()
            self._found.reach.zero_()
        if has.frosted:
            launch(frosted_ray_kernel(has), pixels, inputs, device)

    def share(self, gbuffer: GBuffer, *, restores: bool) -> None:
        """Bound fireflies, and share the light between pixels of one surface.

        restores: what is cut off is given to the surface around. Where it is one ray in ten that goes on by way of
        metal into a lamp, half of the light is cut off; of the mean of a walk's frames it is little.
        """
        source, target = self.light, self._other
        if restores:
            wp.copy(self._before, source)
        inputs = [self._image, GLOSS_PARAMETERS, self._found.reach, source, target]
        launch(bound_fireflies_kernel, len(source), inputs, self._device)
        wp.copy(source, target)
        for step in STEPS:
            inputs = [gbuffer, self._image, step, GLOSS_PARAMETERS, self._found.reach, source, target]
            launch(share_gloss_kernel, len(source), inputs, self._device)
            source, target = target, source
        if restores:
            tolerance, found = GLOSS_PARAMETERS.plane_tolerance, (self._before, source, target, self._believed)
            restore(gbuffer, self._image, RESTORING, tolerance, *found)
            wp.copy(self.light, self._before)

    def add(self, gbuffer: GBuffer, radiance: wp.array) -> None:
        """Add what the lobes reflect to `radiance` (pixel,)."""
        launch(add_gloss_kernel, len(radiance), [gbuffer, self._found, radiance], self._device)
