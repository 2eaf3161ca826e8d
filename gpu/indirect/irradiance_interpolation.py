"""Irradiance between the centres of shading clusters, interpolated as in irradiance caching (Ward et al., A Ray Tracing
Solution for Diffuse Interreflection, 1988; 2009 paper, section 3.4), but for the harmonic mean distance of a centre's
rays, by which its weight grows there.

That is how far apart Ward's samples are, too: one with much around it rules where there are no others. Centres of
clusters are placed before their rays are known, so one in the open rules the neighbourhood of another whose rays are
short, where its light is wrong: in slits, and on what is close to something bright. The spacing that centres have
around a point takes its place, the same for all of them.

What centres count for is told by where they are and by their shortest rays, before anything is known of their light.
"""

from dataclasses import dataclass
from functools import cache

import warp as wp

from gpu.clustering.grid import Representatives, level_of, separation
from gpu.clustering.nearest import nearest_of_some, nearest_search
from gpu.clustering.points import Points
from gpu.core.device import RAY_REGISTERS, allocate, launch
from gpu.core.parameters import parameters
from gpu.device_scene.bsdf import traced_share
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import unblocked
from gpu.device_scene.specialisation import made_for, masks_of, specialisation
from gpu.gbuffer.gbuffer import surface_of
from gpu.gbuffer.point_list import PointList
from gpu.indirect.final_gather import Gathered
from gpu.indirect.gathered_directions import GlossyReceivers
from gpu.indirect.lobe_harmonics import lobe_harmonics, reflected_channel
from gpu.indirect.spherical_harmonics import Harmonics

# Centres that are looked for around an SP; the last only bounds the weights of the others.
SAMPLES = 8
# With fewer, harmonics of three channels and of a lobe would mostly be in memory.
GLOSS_REGISTERS = 96

nearest_centres = nearest_search(SAMPLES, widens=True)


@wp.struct
@dataclass
class InterpolationParameters:
    """search: of all centres, about so many are looked at where none is near. free_share: of the shortest ray of a
    centre; what is nearer to it is not hidden from it.
    """

    search: int = 256
    free_share: float = 0.5


INTERPOLATION_PARAMETERS: InterpolationParameters = parameters(InterpolationParameters)


@wp.struct
class CentreWeights:
    """What centres around SPs count for, (sample, sp) each. cluster: whose they are; weight: 0 where it is hidden, or
    none.
    """

    cluster: wp.array2d[int]
    weight: wp.array2d[float]


def allocate_weights(sps: int, device: wp.Device) -> CentreWeights:
    """Those of so many SPs."""
    weights: CentreWeights = allocate(CentreWeights, sps, device, SAMPLES)
    return weights


@made_for("masks", "alpha", "cutouts", "part_glass")
def weigh_centres_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def weigh_centres_kernel(first: int, scene: SceneData, points: Points, centres: Representatives,
                             least_distance: wp.array[float], chosen: InterpolationParameters,
                             out: CentreWeights) -> None:  # fmt: skip
        """One thread an SP: Ward's weights of the centres around it, less that of the farthest one, so that no centre
        comes or goes with a step; of those that it sees, if there are any. least_distance: as of Gathered.
        """
        sp = first + wp.tid()
        if sp >= points.count[0]:
            return
        scene = specialise(scene)
        position = points.position[sp]
        normal = points.normal[sp]
        found = nearest_centres(centres, position, normal, level_of(centres.chosen, points.spacing[sp]))
        if found.cluster[0] < 0:
            count = centres.spacing.shape[0]
            found.cluster[0] = nearest_of_some(centres, count, position, normal, chosen.search)
        least = float(1.0e30)
        for f in range(wp.static(SAMPLES)):
            weight = float(0.0)
            cluster = found.cluster[f]
            if cluster >= 0:
                other = centres.normal[cluster]
                distance = separation(centres.chosen, position, normal, centres.position[cluster], other)
                change = distance / points.spacing[sp] + wp.sqrt(wp.max(2.0 - 2.0 * wp.dot(normal, other), 0.0))
                weight = 1.0 / wp.max(change, 1.0e-4)
            found.distance[f] = weight
            least = wp.min(least, weight)
        seen = bool(False)
        for f in range(wp.static(SAMPLES)):
            weight = found.distance[f] - least
            cluster = found.cluster[f]
            if weight > 0.0:
                centre = centres.position[cluster]
                free = wp.length(centre - position) < chosen.free_share * least_distance[cluster]
                if not free:
                    free = unblocked(scene, position, normal, centre, centres.normal[cluster])
                if free:
                    seen = True
                else:
                    weight = float(0.0)
            out.cluster[f, sp] = cluster
            out.weight[f, sp] = weight
        if not seen and found.cluster[0] >= 0:
            out.weight[0, sp] = 1.0

    return weigh_centres_kernel


@cache
def interpolate_irradiance_kernel(glossy: bool) -> wp.Kernel:
    """The kernel with or without gloss."""

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=GLOSS_REGISTERS)
    def interpolate_irradiance_kernel(first: int, listed: PointList, weights: CentreWeights, gathered: Gathered,
                                      irradiance: wp.array[wp.vec3], receivers: GlossyReceivers) -> None:  # fmt: skip
        """One thread an SP: the mean of the centres around it by their weights. irradiance (pixel,) [W/m²]."""
        sp = first + wp.tid()
        if sp >= listed.count[0]:
            return
        total = float(0.0)
        light = wp.vec3(0.0, 0.0, 0.0)
        for f in range(wp.static(SAMPLES)):
            weight = weights.weight[f, sp]
            if weight > 0.0:
                light += gathered.irradiance[weights.cluster[f, sp]] * weight
                total += weight
        if total > 0.0:
            light = light / total
        pixel = listed.pixels[sp]
        irradiance[pixel] = light
        if wp.static(glossy):
            receivers.light[pixel] = wp.vec3(0.0, 0.0, 0.0)
            share = traced_share(receivers.gbuffer.roughness[pixel], receivers.gbuffer.f90[pixel])
            if share == 0.0 or total == 0.0:
                return
            red = Harmonics()
            green = Harmonics()
            blue = Harmonics()
            for f in range(wp.static(SAMPLES)):
                weight = weights.weight[f, sp] / total
                if weight > 0.0:
                    cluster = weights.cluster[f, sp]
                    red += receivers.coefficients[cluster, 0] * weight
                    green += receivers.coefficients[cluster, 1] * weight
                    blue += receivers.coefficients[cluster, 2] * weight
            surface = surface_of(receivers.gbuffer, pixel)
            lobe = lobe_harmonics(surface, receivers.gbuffer.to_camera[pixel])
            reflected = wp.vec3(
                reflected_channel(lobe, surface.f0[0], surface.f90, red),
                reflected_channel(lobe, surface.f0[1], surface.f90, green),
                reflected_channel(lobe, surface.f0[2], surface.f90, blue),
            )
            receivers.light[pixel] = wp.cw_mul(receivers.gbuffer.throughput[pixel], reflected) * share

    return interpolate_irradiance_kernel


def weigh_centres(
    scene: SceneData,
    points: Points,
    centres: Representatives,
    least_distance: wp.array,
    weights: CentreWeights,
    chosen: InterpolationParameters = INTERPOLATION_PARAMETERS,
) -> None:
    """Find the `weights` of the `centres` around all `points` of `scene`; least_distance (centre,): as of Gathered."""
    inputs = [scene, points, centres, least_distance, chosen, weights]
    launch(weigh_centres_kernel(masks_of(scene)), len(points.spacing), inputs, least_distance.device)


def interpolate_irradiance(listed: PointList, weights: CentreWeights, gathered: Gathered, irradiance: wp.array,
                           receivers: "GlossyReceivers | None" = None) -> None:  # fmt: skip
    """Fill in `irradiance` (pixel,) of all SPs, which are `listed`, by what the centres around them `gathered`, and
    their `weights`; and the light of `receivers`, if it is asked for, as their lobes reflect it.
    """
    inputs = [listed, weights, gathered, irradiance, receivers or GlossyReceivers()]
    kernel = interpolate_irradiance_kernel(receivers is not None)
    launch(kernel, weights.weight.shape[1], inputs, irradiance.device)
