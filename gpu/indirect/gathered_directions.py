"""Where light at the centres of shading clusters comes from, for glossy receivers, by spherical harmonics: 2009 paper,
section 3.4.
"""

import warp as wp

from gpu.core.device import launch
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.final_gather import Gathered
from gpu.indirect.gather_rays import gather_direction
from gpu.indirect.spherical_harmonics import Harmonics, harmonics_at
from gpu.sp.centres import ShadingClusters

CHANNELS = wp.constant(3)
# Rays have density cosθ/π and count 1/cosθ. Those along the surface count as if they rose by this.
LEAST_COSINE = wp.constant(0.05)


@wp.struct
class GlossyReceivers:
    """gbuffer: what they are; coefficients (cluster, channel): of radiance about the centres; light (pixel,): what
    reaches the camera of it by narrow specular lobes [W/m²/sr].
    """

    gbuffer: GBuffer
    coefficients: wp.array2d[Harmonics]
    light: wp.array[wp.vec3]


@wp.kernel
def project_radiance_kernel(first: int, clusters: ShadingClusters, order: wp.array[int], seeds: wp.array[int],
                            gathered: Gathered, coefficients: wp.array2d[Harmonics]) -> None:  # fmt: skip
    """One thread a channel of a cluster: what its rays found in `coefficients` (cluster, channel) [W/m²/sr].

    Below the surface light is taken as the mirror image of that above, since an edge at the horizon would ring. Rays
    tell how it differs from its mean, which is known without their noise. order, seeds: as of the rays.
    """
    index = first + wp.tid()
    cluster = index // CHANNELS
    channel = index % CHANNELS
    rays = order.shape[0]
    normal = clusters.normal[cluster]
    total = Harmonics()
    if clusters.spacing[cluster] > 0.0:
        mean = gathered.irradiance[cluster][channel] / wp.pi
        for place in range(rays):
            direction = gather_direction(clusters, order, seeds, cluster, place)
            cosine = wp.dot(direction, normal)
            both = harmonics_at(direction) + harmonics_at(direction - normal * (2.0 * cosine))
            total += both * ((gathered.radiance[cluster * rays + place][channel] - mean) / wp.max(cosine, LEAST_COSINE))
        guided = gathered.guided.radiance.shape[0] // clusters.spacing.shape[0]
        for ray in range(cluster * guided, (cluster + 1) * guided):
            direction = gathered.guided.direction[ray]
            cosine = wp.dot(direction, normal)
            both = harmonics_at(direction) + harmonics_at(direction - normal * (2.0 * cosine))
            total += both * (gathered.guided.radiance[ray][channel] / wp.max(cosine, LEAST_COSINE))
        total *= wp.pi / float(rays)
        total[0] += mean * wp.sqrt(4.0 * wp.pi)
    coefficients[cluster, channel] = total


def glossy_receivers(gbuffer: GBuffer, clusters: int) -> GlossyReceivers:
    """Those in `gbuffer`, with room for so many clusters."""
    receivers, device = GlossyReceivers(), gbuffer.face.device
    receivers.gbuffer = gbuffer
    receivers.coefficients = wp.zeros((clusters, 3), dtype=Harmonics, device=device)
    receivers.light = wp.zeros(len(gbuffer.face), dtype=wp.vec3, device=device)
    return receivers


def project_radiance(clusters: ShadingClusters, order: wp.array, seed: wp.array, gathered: Gathered,
                     coefficients: wp.array) -> None:  # fmt: skip
    """Fill in the `coefficients` (cluster, channel) of what the rays, in `order` and by `seed` (1,), `gathered`."""
    inputs = [clusters, order, seed, gathered, coefficients]
    launch(project_radiance_kernel, coefficients.size, inputs, coefficients.device)
