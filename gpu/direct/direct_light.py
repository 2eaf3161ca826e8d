"""Direct light at shading points: soft shadows of emissive triangles and the sky, hard ones of punctual lights.

A light sample is resampled from a few candidates by what they would contribute unshadowed (Talbot et al., Importance
Resampling for Global Illumination, 2005), so that its shadow ray is spent where it counts. Where there are several
emitters, candidates are of those that the surfaces around see (gpu.direct.light_selection). On glossy surfaces a ray of
the specular lobe shares the work by the balance heuristic (Veach 1997, 9.2).
"""

import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import RAY_REGISTERS, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.morton import morton_2d
from gpu.device_scene.bsdf import (
    all_diffuse,
    is_behind,
    is_fibrous,
    is_glossy,
    largest,
    reflected,
    sample_specular,
    side_towards,
    specular_density,
)
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import EVERYTHING, SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import crossed_tint, stops_at_pane, transmittance
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.specialisation import LOOK, made_for, specialisation
from gpu.device_scene.surface import Surface
from gpu.direct.light_selection import LightPick, LightProbes, LightSelection, bins_at, learnt_pick
from gpu.gbuffer.gbuffer import GBuffer, surface_reader
from gpu.lights.light_sampling import LightSample, light_at_hit, punctual_sample, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.resampling import candidate_at
from gpu.sampling.sobol import Pair, sobol_pair_at

# Light samples of which one gets the shadow ray, one of each of so many strata of all light: the length of vectors.
CANDIDATES = wp.constant(8)
STRATUM = wp.constant(wp.uint32(2**32 // int(CANDIDATES)))
Weights = wp.types.vector(length=int(CANDIDATES), dtype=float)
# `area_light` takes sample pairs below this one; the rest are free for its callers.
DIRECT_PAIRS = wp.constant(3)
BY_POWER = wp.constant(-1)


@wp.struct
class PointSamples:
    """Which samples of soft light a point takes.

    place, seed: as for gpu.sampling.sobol.sobol_pair_at; index: of the first of `count` samples; selection: what is
    learnt of its lights, from element `bins` on (gpu.direct.light_selection), or BY_POWER.
    """

    place: int
    index: int
    count: int
    seed: int
    selection: LightSelection
    bins: int


@wp.func
def samples_by_power(place: int, index: int, count: int, seed: int) -> PointSamples:
    """Those of lights that are chosen by power; as PointSamples."""
    samples = PointSamples()
    samples.place = place
    samples.index = index
    samples.count = count
    samples.seed = seed
    samples.bins = BY_POWER
    return samples


@wp.func
def unshadowed_light(surface: Surface, view: wp.vec3, sample: LightSample, glossy: bool) -> wp.vec3:
    """What `surface` reflects of a light sample that nothing hides.

    glossy: weighed by the balance heuristic against `bsdf_sampled_light`.
    """
    light = wp.cw_mul(reflected(surface, view, sample.direction), sample.irradiance)
    if glossy and not is_behind(surface, sample.direction):
        light = light / (1.0 + specular_density(surface, view, sample.direction) * sample.solid_angle)
    return light


@wp.func
def candidate_pick(samples: PointSamples, pick: Pair, candidate: int) -> LightPick:
    """The emitter of a candidate, as `pick` chooses one of each stratum."""
    if samples.bins != BY_POWER:
        return learnt_pick(samples.selection, samples.bins, (float(candidate) + pick.x) / float(CANDIDATES))
    chosen = LightPick()
    chosen.value = STRATUM * wp.uint32(candidate) + pick.a // wp.uint32(CANDIDATES)
    chosen.density = 1.0
    chosen.visible = 1.0
    return chosen


@wp.func
def ris_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, samples: PointSamples, index: int,
              glossy: bool) -> wp.vec3:  # fmt: skip
    """An estimate of the light of `table.sampled` that `surface` reflects to `view`, with one shadow ray.

    Candidates share a place on their emitters and stand in the emitters' order. So the choice among them, by one number
    along the sum of their weights, leaves the samples as well stratified as they come.
    """
    pick = sobol_pair_at(samples.place, index, 0, samples.seed)
    point = sobol_pair_at(samples.place, index, 1, samples.seed)
    light = LightPick()
    sample = LightSample()
    unshadowed = wp.vec3()
    weights = Weights()
    total = float(0.0)
    weight = float(0.0)
    # Its last turn is the chosen one's again: written apart, that would double the code of a kernel.
    for turn in range(CANDIDATES + 1):
        candidate = turn
        if turn == CANDIDATES:
            if total <= 0.0:
                return wp.vec3(0.0, 0.0, 0.0)
            candidate = candidate_at(weights, pick.y * total)
            weight = weights[candidate]
        light = candidate_pick(samples, pick, candidate)
        sample = sample_light(scene, table, table.sampled, surface.position, light.value, point)
        unshadowed = unshadowed_light(surface, view, sample, glossy)
        if turn < CANDIDATES:
            weights[turn] = largest(unshadowed) * (light.visible / light.density)
            total += weights[turn]
    side = side_towards(surface, sample.direction)
    reached = transmittance(scene, surface.position, side, sample.point, sample.normal)
    if largest(reached) <= 0.0:
        return reached
    return wp.cw_mul(reached, unshadowed * (total / (weight * light.density * float(CANDIDATES))))


@wp.func
def bsdf_sampled_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, samples: PointSamples,
                       index: int) -> wp.vec3:  # fmt: skip
    """The other part of the estimate on a glossy surface: light that a ray of the specular lobe hits."""
    point = sobol_pair_at(samples.place, index, 2, samples.seed)
    lobe = sample_specular(surface, view, point.x, point.y)
    if lobe.density == 0.0 or wp.dot(lobe.direction, surface.geometric_normal) <= 0.0:
        return wp.vec3(0.0, 0.0, 0.0)
    origin = offset_origin(surface.position, surface.geometric_normal, lobe.direction)
    hit = closest_hit(scene, origin, lobe.direction, RAY_LENGTH)
    found = light_at_hit(scene, table, table.sampled, origin, lobe.direction, hit)
    if stops_at_pane(scene, origin, lobe.direction, hit.t):
        return wp.vec3(0.0, 0.0, 0.0)
    light = wp.cw_mul(found.radiance, crossed_tint(scene, origin, lobe.direction, hit.t, False))
    return wp.cw_mul(reflected(surface, view, lobe.direction), light) / (lobe.density + found.density)


@wp.func
def delta_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3) -> wp.vec3:
    """Radiance that `surface` scatters of the visited punctual lights towards unit `view` [W/m²/sr]: without noise."""
    light = wp.vec3(0.0, 0.0, 0.0)
    for number in range(table.enumerated_count):
        sample = punctual_sample(table.lights[number], surface.position)
        reached = wp.cw_mul(reflected(surface, view, sample.direction), sample.irradiance)
        if largest(reached) > 0.0:
            side = side_towards(surface, sample.direction)
            left = transmittance(scene, surface.position, side, sample.point, sample.normal)
            light += wp.cw_mul(reached, left)
    return light


@wp.func
def area_light(scene: SceneData, table: LightTable, surface: Surface, view: wp.vec3, samples: PointSamples) -> wp.vec3:
    """Radiance that `surface` reflects of all other lights [W/m²/sr]: the mean of estimates by these samples."""
    light = wp.vec3(0.0, 0.0, 0.0)
    if table.sampled.count > 0 and (largest(all_diffuse(surface)) > 0.0 or surface.f90 > 0.0 or is_fibrous(surface)):
        glossy = scene.glossy and is_glossy(surface)
        for index in range(samples.index, samples.index + samples.count):
            estimate = ris_light(scene, table, surface, view, samples, index, glossy)
            if glossy:
                estimate += bsdf_sampled_light(scene, table, surface, view, samples, index)
            light += estimate / float(samples.count)
    return light


@wp.func
def demodulation(gbuffer: GBuffer, pixel: int) -> wp.vec3:
    """What soft light is divided by while it is smoothed, so that textures stay sharp (C. Schied et al. 2017): how much
    an SP scatters by both lobes.
    """
    reflected = gbuffer.diffuse[pixel] + gbuffer.f0[pixel]
    if gbuffer.translucent:
        reflected += gbuffer.through[pixel]
    return wp.max(reflected, wp.vec3(0.01, 0.01, 0.01))


@wp.struct
class DirectSamples:
    """Which samples of soft light a frame takes: `count` shadow rays a pixel.

    frame_index (1,): the frame's number among those that complement each other; seed: of all of these; selection: what
    is learnt of the lights, if anything; known (pixel,): the light of how many frames of a walk joins in, from
    `settled` of which on half as many rays do; an empty array: none.
    """

    count: int
    frame_index: wp.array[int]
    seed: int
    selection: LightSelection
    known: wp.array[int]
    settled: int


def direct_samples(count: int, frame_index: wp.array, seed: int, probes: LightProbes | None = None,
                   known: wp.array | None = None, settled: int = 0) -> DirectSamples:  # fmt: skip
    """The struct of these; probes: that have learnt, if any have."""
    samples = DirectSamples()
    samples.count, samples.frame_index, samples.seed = count, frame_index, seed
    samples.known, samples.settled = known, settled
    if probes:
        samples.selection = probes.selection
    return samples


@wp.func
def count_of(samples: DirectSamples, pixel: int) -> int:
    """How many shadow rays a pixel has."""
    if samples.known.shape[0] == 0:
        return samples.count
    return wp.where(samples.known[pixel] < samples.settled, samples.count, (samples.count + 1) // 2)


@made_for(*LOOK, "gloss", "backdrop", "panes", "environment")
def direct_light_kernel(features: SceneFeatures, learnt: bool) -> wp.Kernel:
    """The kernel for scenes of these `features`; learnt: samples have a selection."""
    specialise = specialisation(features)
    surface_of_pixel = surface_reader(sheen=features.sheen, grain=features.grain, translucent=features.translucent)

    # Unrolled, the candidates make code three times as long, which fits no instruction cache and takes long to compile.
    @wp.kernel(module="unique", module_options={"max_unroll": 1, "fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def direct_light_kernel(
        first: int,
        scene: SceneData,
        table: LightTable,
        gbuffer: GBuffer,
        image: ImageSize,
        samples: DirectSamples,
        out: wp.array[wp.vec3],
        soft: wp.array[wp.vec3],
    ) -> None:
        """One thread a pixel: what the camera sees of emitters and hard light (out), and its SP's soft light (soft).

        Pixels take their samples from one sequence in the order of a space-filling curve, so that neighbours complement
        each other and the noise is blue (Ahmed and Wonka, Screen-Space Blue-Noise Diffusion, 2020). So do a pixel's
        samples, over all frames of a view: their mean converges faster than that of independent ones.
        """
        pixel = first + wp.tid()
        out[pixel] = gbuffer.emitted[pixel]
        soft[pixel] = wp.vec3(0.0, 0.0, 0.0)
        if gbuffer.face[pixel] == NO_HIT:
            return
        scene = specialise(scene)
        gbuffer.translucent = wp.static(features.translucent)
        surface = surface_of_pixel(gbuffer, pixel)
        view = gbuffer.to_camera[pixel]
        out[pixel] += wp.cw_mul(gbuffer.throughput[pixel], delta_light(scene, table, surface, view))
        place = morton_2d(pixel % image.width, pixel // image.width)
        count = count_of(samples, pixel)
        own = samples_by_power(place, samples.frame_index[0] * count, count, samples.seed)
        if wp.static(learnt):
            own.selection = samples.selection
            own.bins = bins_at(samples.selection, pixel, image.width)
        light = area_light(scene, table, surface, view, own)
        soft[pixel] = wp.cw_div(light, demodulation(gbuffer, pixel))

    return direct_light_kernel


@wp.kernel
def add_soft_kernel(first: int, gbuffer: GBuffer, soft: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:
    """One thread a pixel: adds its soft light to what the camera sees."""
    pixel = first + wp.tid()
    if gbuffer.face[pixel] != NO_HIT:
        light = wp.cw_mul(soft[pixel], demodulation(gbuffer, pixel))
        out[pixel] += wp.cw_mul(gbuffer.throughput[pixel], light)


def trace_direct_light(scene: SceneData, table: LightTable, gbuffer: GBuffer, size: tuple[int, int],
                       samples: DirectSamples, out: wp.array, soft: wp.array,
                       features: SceneFeatures = EVERYTHING) -> None:  # fmt: skip
    """Write what the camera sees of emitters and hard light into `out`, and soft light into `soft`.

    out: (pixel,) vec3 of linear radiance [W/m²/sr]; soft: (pixel,) the same per reflectance of the SP, for
    gpu.denoise.atrous and `add_soft_light`. size: (width, height).
    """
    kernel = direct_light_kernel(features, bool(samples.selection.columns))
    inputs = [scene, table, gbuffer, image_size(size), samples, out, soft]
    launch(kernel, size[0] * size[1], inputs, out.device, weight=samples.count)


def add_soft_light(gbuffer: GBuffer, soft: wp.array, out: wp.array) -> None:
    """Add the light in `soft` to what the camera sees, `out`; both (pixel,)."""
    launch(add_soft_kernel, len(out), [gbuffer, soft, out], out.device)
