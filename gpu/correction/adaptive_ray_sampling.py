"""Where rays of the brightest shading points go (gpu.correction.adaptive_rays): even steps through all light that an
SP might get.

What is near is walked as gpu.indirect.fuzzy_shading walks it, in parts, since there are few such SPs for a GPU's
threads. Of far light representatives have tables.
"""

from functools import cache

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.intrinsics import bits_of_warp, lowest_bit
from gpu.correction.vpl_sampling import cluster_pick_of, cluster_visibility_of, far_sample_of, member_of
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.far_field import FarLight
from gpu.indirect.fuzzy_shading import REGISTERS, guides_of, words_a_part
from gpu.indirect.irradiance import NEAR_PARTS, Indirect
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.form_factor import unoccluded_irradiance
from gpu.vpl.vpl_clusters import VplClusters

RAYS = 24
# Rays find what clusters believe to be off, of which this share is taken for granted: where clusters are right that
# leaves little noise, where all is hidden, rays do that alone.
TRUST = wp.constant(0.6)
GOLDEN = wp.constant(0.6180339887)
# Of a step between rays: more than rounding.
ROUNDING = wp.constant(0.01)
BRIGHT_KEY, GUIDE_KEY = wp.constant(wp.uint32(0x7A3D70A1)), wp.constant(wp.uint32(0x3D4D51CB))


@wp.struct
class Rays:
    """Rays of listed SPs, (ray, place): those that run side by side go from neighbours to much the same light.

    vpl: the VPL that each goes to, −1 for none; share: its light over its density [W/m²]; found: that times what rays
    find, less what is taken for granted. Before they are drawn, vpl is the near VPL cluster, −1 for a far one, and
    share where the ray falls in all light.
    """

    vpl: wp.array2d[int]
    share: wp.array2d[float]
    found: wp.array2d[float]


@wp.kernel
def step_kernel(first: int, pixels: wp.array[int], numbers: wp.array[int], count: wp.array[int], indirect: Indirect,
                seed: wp.array[int], rays: Rays) -> None:  # fmt: skip
    """One thread a ray: where it falls in all light, in RAYS even steps, later rays further on.

    Read by all who compare it, since rounding that differs between them would lose rays.
    """
    index = first + wp.tid()
    if index >= RAYS * count[0]:
        return
    place = index % count[0]
    ray = index // count[0]
    rays.vpl[ray, place] = -1
    sp = numbers[place]
    state = hashed(wp.uint32(pixels[place]) ^ hashed(BRIGHT_KEY + wp.uint32(seed[0])))
    whole = indirect.unoccluded_near[sp] + indirect.unoccluded_far[sp]
    rays.share[ray, place] = (float(ray) + float(state) * TO_UNIT) / float(RAYS) * whole


@wp.func
def step_at(rays: Rays, place: int, ray: int) -> float:
    """Where a ray falls in all light, above that for none."""
    if ray >= RAYS:
        return FAR_AWAY
    return rays.share[ray, place]


@cache
def near_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that finds the near VPL clusters that rays of SPs of F = `fuzziness` clusters each go to."""
    guides = guides_of(fuzziness)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def kernel(
        first: int,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        numbers: wp.array[int],
        count: wp.array[int],
        clusters: SpClusters,
        vpls: VplClusters,
        far: FarLight,
        indirect: Indirect,
        rays: Rays,
    ) -> None:
        """One thread a part at one listed SP: walks its near VPL clusters; leaves those that rays fall into.

        Neighbouring threads have neighbouring SPs.
        """
        index = first + wp.tid()
        if index >= NEAR_PARTS * count[0]:
            return
        place = index % count[0]
        part = index // count[0]
        words = (vpls.count + 31) // 32
        begin = part * words_a_part(vpls)
        end = wp.min(begin + words_a_part(vpls), words)
        if begin >= words:
            return
        sp = numbers[place]
        pixel = pixels[place]
        near = indirect.unoccluded_near[sp]
        whole = near + indirect.unoccluded_far[sp]
        total = indirect.unoccluded_prefix[part, sp]
        most = near
        if end < words:
            most = indirect.unoccluded_prefix[part + 1, sp]
        ray = int(wp.max(total / whole * float(RAYS) - ROUNDING, 0.0))
        step = step_at(rays, place, ray)
        while step < total:
            ray += 1
            step = step_at(rays, place, ray)
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        guided = guides(clusters, sp, position, normal)
        last = int(-1)
        for word in range(begin, end):
            bits = wp.uint32(0)
            if step < most:
                for f in range(wp.static(fuzziness)):
                    if guided.weight[f] > 0.0:
                        bits |= far.near[guided.cluster[f], word]
            together = bits_of_warp(bits)
            while together != wp.uint32(0):
                bit = wp.uint32(lowest_bit(together))
                together &= together - wp.uint32(1)
                if ((bits >> bit) & wp.uint32(1)) == wp.uint32(0):
                    continue
                amount = brightness(unoccluded_irradiance(position, normal, vpls, 32 * word + int(bit)))
                if amount > 0.0:
                    total += amount
                    last = 32 * word + int(bit)
                    while step < wp.min(total, most):
                        rays.vpl[ray, place] = last
                        ray += 1
                        step = step_at(rays, place, ray)
        # By rounding, a part may end a little short.
        while step < most:
            rays.vpl[ray, place] = last
            ray += 1
            step = step_at(rays, place, ray)

    return kernel


@cache
def draw_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws VPLs for rays of SPs of F = `fuzziness` clusters each."""
    guides, pick_cluster, sample_far = guides_of(fuzziness), cluster_pick_of(fuzziness), far_sample_of(fuzziness)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def kernel(
        first: int,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        numbers: wp.array[int],
        count: wp.array[int],
        clusters: SpClusters,
        visibility: wp.array2d[wp.uint32],
        vpls: VplClusters,
        far: FarLight,
        indirect: Indirect,
        seed: wp.array[int],
        rays: Rays,
    ) -> None:
        """One thread a ray: draws to which member of which VPL cluster it goes.

        Rays to far ones take the tables of the SP's clusters by turns, each further on in its own.
        """
        index = first + wp.tid()
        if index >= RAYS * count[0]:
            return
        place = index % count[0]
        ray = index // count[0]
        sp = numbers[place]
        pixel = pixels[place]
        near = indirect.unoccluded_near[sp]
        whole = near + indirect.unoccluded_far[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        guided = guides(clusters, sp, position, normal)
        own = hashed(wp.uint32(pixel) ^ hashed(GUIDE_KEY + wp.uint32(seed[0])))
        state = hashed(own + wp.uint32(ray))
        drawn = rays.vpl[ray, place]
        cluster_visibility = float(0.0)
        scale = float(1.0)
        if drawn < 0:
            turn = float(own) * TO_UNIT + GOLDEN * float(ray)
            guide = pick_cluster(guided, far.unoccluded_cdf, (turn - wp.floor(turn)) * indirect.unoccluded_far[sp])
            if guide.cluster >= 0:
                on = (rays.share[ray, place] - near) / indirect.unoccluded_far[sp]
                guide.u = wp.clamp(on, 0.0, 1.0) * far.unoccluded_cdf[far.unoccluded_cdf.shape[0] - 1, guide.cluster]
            far_drawn = sample_far(position, normal, guided, visibility, vpls, far.near, far.unoccluded_importance,
            far.unoccluded_cdf,
                                 1.0, guide, state)  # fmt: skip
            drawn = far_drawn.cluster
            if drawn < 0:
                return
            state = far_drawn.state
            cluster_visibility = far_drawn.cluster_visibility
            scale = far_drawn.scale
        else:
            cluster_visibility = cluster_visibility_of(guided, visibility, drawn, wp.static(fuzziness))
        target = member_of(position, normal, vpls, drawn, hashed(state))
        rays.vpl[ray, place] = target.vpl
        rays.share[ray, place] = target.share * scale * whole
        rays.found[ray, place] = -TRUST * cluster_visibility * rays.share[ray, place]

    return kernel
