"""Where rays of the brightest shading points go (gpu.correction.adaptive_rays): even steps through all light that an
SP might get.

What is near is walked as gpu.indirect.fuzzy_shading walks it, in parts, since there are few such SPs for a GPU's
threads. Of far light representatives have tables.
"""

from functools import cache

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY, GOLDEN_RATIO
from gpu.core.intrinsics import bits_of_warp, lowest_bit
from gpu.correction.vpl_sampling import VplSampleParameters, vpl_sample_of
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.indirect.clustered_light import ClusteredLight, guides_of
from gpu.indirect.fuzzy_shading import REGISTERS, words_a_part
from gpu.indirect.irradiance import NEAR_PARTS, Indirect
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.vpl.form_factor import unoccluded_irradiance
from gpu.vpl.shadow_rays import NO_RAY, ShadowRays, ray_index, thread_ray

# Of each listed SP: arrays have room for so many.
RAYS = 24
# Of a step between rays: more than rounding.
ROUNDING = wp.constant(0.01)
BRIGHT_KEY, GUIDE_KEY = wp.constant(wp.uint32(0x7A3D70A1)), wp.constant(wp.uint32(0x3D4D51CB))


@wp.kernel
def adaptive_step_kernel(first: int, points: PointList, indirect: Indirect, seed: wp.array[int],
                         rays: ShadowRays) -> None:  # fmt: skip
    """One thread a ray: where it falls in all light, in even steps, later rays further on, as its `share`.

    Read by all who compare it, since rounding that differs between them would lose rays. seed: (1,).
    """
    thread = first + wp.tid()
    if thread >= rays.per_point * points.count[0]:
        return
    at = thread_ray(rays, thread, points.count[0])
    index = ray_index(rays, at[0], at[1])
    sp = points.numbers[at[0]]
    state = hashed(wp.uint32(points.pixels[at[0]]) ^ hashed(BRIGHT_KEY + wp.uint32(seed[0])))
    whole = indirect.unoccluded_near[sp] + indirect.unoccluded_far[sp]
    rays.vpl[index] = NO_RAY
    rays.share[index] = (float(at[1]) + float(state) * TO_UNIT) / float(RAYS) * whole


@wp.func
def step_at(rays: ShadowRays, place: int, ray: int) -> float:
    """Where a ray falls in all light, above that for none."""
    if ray >= RAYS:
        return FAR_AWAY
    return rays.share[ray_index(rays, place, ray)]


@cache
def adaptive_near_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that finds the near VPL clusters that rays of SPs of F = `fuzziness` clusters each go to."""
    guides = guides_of(fuzziness)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def adaptive_near_kernel(
        first: int, gbuffer: GBuffer, points: PointList, known: ClusteredLight, indirect: Indirect, rays: ShadowRays
    ) -> None:
        """One thread a part at one listed SP: walks its near VPL clusters; leaves those that rays fall into.

        Neighbouring threads have neighbouring SPs.
        """
        index = first + wp.tid()
        if index >= NEAR_PARTS * points.count[0]:
            return
        place = index % points.count[0]
        part = index // points.count[0]
        vpls = known.vpls
        words = (vpls.count + 31) // 32
        begin = part * words_a_part(vpls)
        end = wp.min(begin + words_a_part(vpls), words)
        if begin >= words:
            return
        sp = points.numbers[place]
        pixel = points.pixels[place]
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
        guided = guides(known, sp, position, normal)
        last = int(-1)
        for word in range(begin, end):
            bits = wp.uint32(0)
            if step < most:
                for f in range(wp.static(fuzziness)):
                    if guided.weight[f] > 0.0:
                        bits |= known.far.near[guided.cluster[f], word]
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
                        rays.vpl[ray_index(rays, place, ray)] = last
                        ray += 1
                        step = step_at(rays, place, ray)
        # By rounding, a part may end a little short.
        while step < most:
            rays.vpl[ray_index(rays, place, ray)] = last
            ray += 1
            step = step_at(rays, place, ray)

    return adaptive_near_kernel


@cache
def adaptive_ray_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws VPLs for rays of SPs of F = `fuzziness` clusters each."""
    sample_vpl = vpl_sample_of(fuzziness, weighted=False)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def adaptive_ray_kernel(
        first: int,
        gbuffer: GBuffer,
        points: PointList,
        known: ClusteredLight,
        indirect: Indirect,
        seed: wp.array[int],
        rays: ShadowRays,
        limits: VplSampleParameters,
    ) -> None:
        """One thread a ray: draws to which member of which VPL cluster it goes.

        Rays to far ones take the tables of the SP's clusters by turns, each further on in its own. seed: (1,).
        """
        thread = first + wp.tid()
        if thread >= rays.per_point * points.count[0]:
            return
        at = thread_ray(rays, thread, points.count[0])
        index = ray_index(rays, at[0], at[1])
        sp = points.numbers[at[0]]
        pixel = points.pixels[at[0]]
        near = indirect.unoccluded_near[sp]
        far = indirect.unoccluded_far[sp]
        own = hashed(wp.uint32(pixel) ^ hashed(GUIDE_KEY + wp.uint32(seed[0])))
        turn = float(own) * TO_UNIT + GOLDEN_RATIO * float(at[1])
        pick = wp.vec2((turn - wp.floor(turn)) * far, (rays.share[index] - near) / far)
        state = hashed(own + wp.uint32(at[1]))
        sample = sample_vpl(
            gbuffer.position[pixel], gbuffer.normal[pixel], sp, known, rays.vpl[index], pick, state, limits
        )
        rays.vpl[index] = sample.vpl
        if sample.vpl >= 0:
            rays.share[index] = sample.share * sample.scale * (near + far)
            rays.cluster_visibility[index] = sample.cluster_visibility

    return adaptive_ray_kernel
