"""Where rays of the brightest shading points go (gpu.bright): even steps through all light that an SP might get.

What is near is walked as gpu.shade walks it, in parts, since there are few such SPs for a GPU's threads: once for how
much light each part has, once more for what the rays that fall into it go to. Of far light representatives have tables.
"""

from functools import cache

import warp as wp

from gpu.aim import believed_share, far_draw_of, guide_at_of, member_of
from gpu.bits import lowest_bit
from gpu.far_light import FarLight
from gpu.gbuffer import GBuffer
from gpu.lanes import bits_of_warp
from gpu.sampling import TO_UNIT, hashed
from gpu.shade import REGISTERS, Indirect, guides_of
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, unoccluded
from gpu.vpl_clusters import VplClusters

RAYS = 24
PARTS = 8
# Rays find what clusters believe to be off, of which this share is taken for granted: where clusters are right that
# leaves little noise, where all is hidden, rays do that alone.
TRUST = wp.constant(0.6)
GOLDEN = wp.constant(0.6180339887)
BRIGHT_KEY, GUIDE_KEY = wp.constant(wp.uint32(0x7A3D70A1)), wp.constant(wp.uint32(0x3D4D51CB))


@wp.struct
class Rays:
    """Rays of listed SPs, (place, ray) flattened.

    near (part, place): light of each part of the near VPL clusters, were nothing hidden [W/m²]; vpl: the VPL that each
    ray goes to, −1 for none, before that is drawn the near VPL cluster, −1 for a far one; share: its light over its
    density [W/m²]; found: that times what rays find, less what is taken for granted.
    """

    near: wp.array2d[float]
    vpl: wp.array[int]
    share: wp.array[float]
    found: wp.array[float]


@wp.func
def step_of(pixel: int, ray: int, seed: int, whole: float) -> float:
    """Where ray `ray` falls in the whole: evenly in one of RAYS steps, later rays further on."""
    state = hashed(wp.uint32(pixel) ^ hashed(BRIGHT_KEY + wp.uint32(ray) + wp.uint32(RAYS) * wp.uint32(seed)))
    return (float(ray) + float(state) * TO_UNIT) / float(RAYS) * whole


@cache
def near_kernel(fuzziness: int, *, places: bool) -> wp.Kernel:
    """The kernel that walks the near VPL clusters of SPs of F = `fuzziness` clusters each.

    places: whether it finds which of them rays go to, or, before that, what each part of them sends.
    """
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
        seed: wp.array[int],
        rays: Rays,
    ) -> None:
        """One thread a part at one listed SP; neighbours have neighbouring SPs. The last takes what is beyond."""
        index = first + wp.tid()
        capacity = rays.near.shape[1]
        place = index % capacity
        part = index // capacity
        if place >= count[0]:
            return
        sp = numbers[place]
        pixel = pixels[place]
        near = indirect.open_near[sp]
        whole = near + indirect.open_far[sp]
        total = float(0.0)
        end = near
        ray = int(0)
        step = float(0.0)
        if wp.static(places):
            for before in range(part):
                total += rays.near[before, place]
            total = wp.min(total, near)
            if part < PARTS - 1:
                end = wp.min(total + rays.near[part, place], near)
            # From the ray before, too: rounding must leave none to nobody.
            ray = int(wp.max(total / whole * float(RAYS) - 0.01, 0.0))
            step = step_of(pixel, ray, seed[0], whole)
            while ray < RAYS and step < total:
                ray += 1
                step = step_of(pixel, ray, seed[0], whole)
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        guided = guides(clusters, sp, position, normal)
        last = int(-1)
        words = (vpls.count + 32 * PARTS - 1) // (32 * PARTS)
        for word in range(part * words, wp.min((part + 1) * words, (vpls.count + 31) // 32)):
            bits = wp.uint32(0)
            if wp.static(not places) or (step < end and ray < RAYS):
                for f in range(wp.static(fuzziness)):
                    if guided.weight[f] > 0.0:
                        bits |= far.near[guided.cluster[f], word]
            together = bits_of_warp(bits)
            while together != wp.uint32(0):
                bit = wp.uint32(lowest_bit(together))
                together &= together - wp.uint32(1)
                if ((bits >> bit) & wp.uint32(1)) == wp.uint32(0):
                    continue
                amount = brightness(unoccluded(position, normal, vpls, 32 * word + int(bit)))
                if amount > 0.0:
                    total += amount
                    if wp.static(places):
                        last = 32 * word + int(bit)
                        while ray < RAYS and step < wp.min(total, end):
                            rays.vpl[place * RAYS + ray] = last
                            ray += 1
                            step = step_of(pixel, ray, seed[0], whole)
        if wp.static(not places):
            rays.near[part, place] = total
            return
        # By rounding, a part may end a little short.
        while ray < RAYS and (step < end or part == PARTS - 1):
            rays.vpl[place * RAYS + ray] = wp.where(step < near, last, -1)
            ray += 1
            step = step_of(pixel, ray, seed[0], whole)

    return kernel


@cache
def draw_kernel(fuzziness: int) -> wp.Kernel:
    """The kernel that draws VPLs for rays of SPs of F = `fuzziness` clusters each."""
    guides, guide_at, far_draw = guides_of(fuzziness), guide_at_of(fuzziness), far_draw_of(fuzziness)

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
        place = index // RAYS
        ray = index % RAYS
        if place >= count[0]:
            rays.vpl[index] = -1
            return
        sp = numbers[place]
        pixel = pixels[place]
        near = indirect.open_near[sp]
        whole = near + indirect.open_far[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        guided = guides(clusters, sp, position, normal)
        own = hashed(wp.uint32(pixel) ^ hashed(GUIDE_KEY + wp.uint32(seed[0])))
        state = hashed(own + wp.uint32(ray))
        drawn = rays.vpl[index]
        believed = float(0.0)
        scale = float(1.0)
        if drawn < 0:
            turn = float(own) * TO_UNIT + GOLDEN * float(ray)
            guide = guide_at(guided, far.open_totals, (turn - wp.floor(turn)) * indirect.open_far[sp])
            if guide.cluster >= 0:
                on = (step_of(pixel, ray, seed[0], whole) - near) / indirect.open_far[sp]
                guide.pick = wp.clamp(on, 0.0, 1.0) * far.open_totals[far.open_totals.shape[0] - 1, guide.cluster]
            far_drawn = far_draw(position, normal, guided, visibility, vpls, far.near, far.open_mass, far.open_totals,
                                 1.0, guide, state)  # fmt: skip
            drawn = far_drawn.cluster
            if drawn < 0:
                return
            state = far_drawn.state
            believed = far_drawn.believed
            scale = far_drawn.scale
        else:
            believed = believed_share(guided, visibility, drawn, wp.static(fuzziness))
        target = member_of(position, normal, vpls, drawn, hashed(state))
        rays.vpl[index] = target.vpl
        rays.share[index] = target.share * scale * whole
        rays.found[index] = -TRUST * believed * rays.share[index]

    return kernel
