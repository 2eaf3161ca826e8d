"""More rays for the shading points that may be brightest, where surfaces are uneven. Beyond the 2022 paper.

Errors grow with light, their squares with its square. Where the sun shines on mouldings, one SP in seven holds three
quarters of what the clusters of a whole living-room are wrong by, and its neighbours have other light. So such SPs send
more rays, drawn from all their light in even steps, so that each part of it has its share. What they find is their own.
"""

from functools import cache

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.aim import believed_share, far_draw_of, guide_at_of, member_of, sees_member_of
from gpu.bits import lowest_bit
from gpu.device import allocate, launch
from gpu.dispute import SAMPLES, MeanBrightness
from gpu.far_light import FarLight
from gpu.gbuffer import GBuffer, reflectance
from gpu.interpolate import is_even
from gpu.lanes import bits_of_warp
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.selection import LAST, Selection
from gpu.shade import CHECKS, REGISTERS, Indirect, guides_of
from gpu.shading_points import ShadingPoints
from gpu.sp_clusters import SpClusters
from gpu.transfer import brightness, unoccluded
from gpu.vpl_clusters import VplClusters

RAYS = 24
# Bright is what may have this share of the brightness that only so many of the picture's SAMPLES are above.
LEAST_BRIGHT, BRIGHTER = wp.constant(0.6), 10
STEPS_PER_OCTAVE, MOST_OCTAVES = wp.constant(16.0), wp.constant(8.0)
# Rays find what clusters believe to be off, of which this share is taken for granted: where clusters are right that
# leaves little noise, where all is hidden, rays do that alone.
TRUST = wp.constant(0.6)
# What frames before knew counts as the rays of so many of them, at most.
FRAMES = wp.constant(6)
# Share of what neighbours share, in what is shown. What is so much darker, as gpu.refine leaves it, is shown alone.
MIX, DARKER = wp.constant(0.4), wp.constant(0.3)
GOLDEN = wp.constant(0.6180339887)
BRIGHT_KEY, GUIDE_KEY = wp.constant(wp.uint32(0x7A3D70A1)), wp.constant(wp.uint32(0x3D4D51CB))


@wp.struct
class Rays:
    """Rays of listed SPs, (place, ray) flattened.

    vpl: the VPL that each goes to, −1 for none, before that is drawn the near VPL cluster, −1 for a far one; share: its
    light over its density [W/m²]; found: that times what rays find, less what is taken for granted.
    """

    vpl: wp.array[int]
    share: wp.array[float]
    found: wp.array[float]


@wp.kernel
def key_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int], listed: wp.array[int],
               width: int, height: int, indirect: Indirect, samples: wp.array[float], bright: int,
               keys: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: how bright it may be, relative to sample `bright` of the picture, as a key; brightest first.

    listed (pixel,): 1 where there is an SP. None is chosen that speaks for the pixels beside it.
    """
    sp = first + wp.tid()
    keys[sp] = LAST
    if sp >= count[0]:
        return
    pixel = pixels[sp]
    most = (indirect.open_near[sp] + indirect.open_far[sp]) * brightness(reflectance(gbuffer, pixel))
    ratio = most / (LEAST_BRIGHT * samples[bright] + 1.0e-30)
    if ratio >= 1.0 and not is_even(listed, pixel, width, height):
        keys[sp] = wp.clamp(int(STEPS_PER_OCTAVE * (MOST_OCTAVES - wp.log2(ratio))), 0, LAST - 1)


@wp.func
def step_of(pixel: int, ray: int, seed: int, whole: float) -> float:
    """Where ray `ray` falls in the whole: evenly in one of RAYS steps, later rays further on."""
    state = hashed(wp.uint32(pixel) ^ hashed(BRIGHT_KEY + wp.uint32(ray) + wp.uint32(RAYS) * wp.uint32(seed)))
    return (float(ray) + float(state) * TO_UNIT) / float(RAYS) * whole


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
        seed: wp.array[int],
        rays: Rays,
    ) -> None:
        """One thread a listed SP: walks its near VPL clusters as gpu.shade does; leaves those that rays fall into."""
        place = first + wp.tid()
        if place >= count[0]:
            return
        sp = numbers[place]
        pixel = pixels[place]
        near = indirect.open_near[sp]
        whole = near + indirect.open_far[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        guided = guides(clusters, sp, position, normal)
        ray = int(0)
        step = step_of(pixel, ray, seed[0], whole)
        total = float(0.0)
        last = int(-1)
        for word in range((vpls.count + 31) // 32):
            bits = wp.uint32(0)
            if step < near and ray < RAYS:
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
                    last = 32 * word + int(bit)
                    while ray < RAYS and step < wp.min(total, near):
                        rays.vpl[place * RAYS + ray] = last
                        ray += 1
                        step = step_of(pixel, ray, seed[0], whole)
        while ray < RAYS:
            # By rounding, near light may end a little short.
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


@cache
def trace_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""
    sees = sees_member_of(connect)

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        vpls: VplClusters,
        rays: Rays,
    ) -> None:
        """One thread a ray: adds its light if nothing stops it."""
        index = first + wp.tid()
        vpl = rays.vpl[index]
        if vpl < 0:
            return
        if sees(scene, gbuffer, pixels[index // RAYS], vpls, vpl):
            rays.found[index] += rays.share[index]

    return kernel


@wp.kernel
def take_kernel(first: int, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters, rays: Rays,
                told: wp.array[wp.vec3], frames: wp.array[int], light: wp.array[wp.vec3],
                irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a listed SP: takes what its rays found into its `light`, and most of that into its `irradiance`.

    All (pixel,). told: irradiance as its clusters tell it; frames: how many frames before knew the light.
    """
    place = first + wp.tid()
    if place >= count[0]:
        return
    pixel = pixels[place]
    total = wp.vec3(0.0, 0.0, 0.0)
    for ray in range(RAYS):
        index = place * RAYS + ray
        vpl = rays.vpl[index]
        if vpl >= 0:
            flux = vpls.members.flux[vpl]
            total += flux * (rays.found[index] / brightness(flux))
    found = told[pixel] * TRUST + total / float(RAYS)
    known = CHECKS * wp.min(frames[pixel] + 1, FRAMES)
    mean = light[pixel] + (found - light[pixel]) * (float(RAYS) / float(RAYS + known))
    light[pixel] = mean
    if brightness(irradiance[pixel]) >= DARKER * brightness(mean):
        mixed = mean * (1.0 - MIX) + irradiance[pixel] * MIX
        irradiance[pixel] = wp.max(mixed, wp.vec3(0.0, 0.0, 0.0))


class BrightPoints(Selection):
    """Of an image of `size` (width, height) the at most `capacity` SPs that may be brightest, with RAYS rays for each.

    Its arrays are allocated once.
    """

    def __init__(self, size: tuple[int, int], capacity: int, device: wp.Device) -> None:
        super().__init__(size[0] * size[1], capacity, int(LAST), device)
        self._size = size
        self._samples = wp.zeros(2 * int(SAMPLES), dtype=float, device=device)
        self._sample_order = wp.zeros(2 * int(SAMPLES), dtype=int, device=device)
        self._rays: Rays = allocate(Rays, RAYS * self.capacity, device)

    def trace(self, scene: SceneData, gbuffer: GBuffer, sps: ShadingPoints, clusters: SpClusters, words: wp.array,
              vpls: VplClusters, far: FarLight, indirect: Indirect, seed: wp.array,
              picture: MeanBrightness) -> None:  # fmt: skip
        """Choose of `sps`, shaded by all these, and trace the rays.

        words: visibility bits of `clusters`; seed: (1,); picture: how bright it is.
        """
        fuzziness, device, rays = clusters.cluster.shape[0], self.device, RAYS * self.capacity
        wp.copy(self._samples, picture.samples, count=int(SAMPLES))
        radix_sort_pairs(self._samples, self._sample_order, int(SAMPLES))
        inputs = [gbuffer, sps.pixels, sps.count, sps.listed, *self._size, indirect]
        launch(key_kernel, sps.capacity, [*inputs, self._samples, int(SAMPLES) - 1 - BRIGHTER, self.keys], device)
        self.choose(sps)
        listed = gbuffer, self.pixels, self.numbers, self.count, clusters
        inputs = [*listed, vpls, far, indirect, seed, self._rays]
        launch(near_kernel(fuzziness), self.capacity, inputs, device)
        launch(draw_kernel(fuzziness), rays, [*listed, words, vpls, far, indirect, seed, self._rays], device)
        launch(trace_kernel(connection(scene)), rays, [scene, gbuffer, self.pixels, vpls, self._rays], device)

    def take(self, vpls: VplClusters, told: wp.array, frames: wp.array, light: wp.array, irradiance: wp.array) -> None:
        """Have what the rays found in `light` and `irradiance`, as `take_kernel` tells; (pixel,) each."""
        inputs = [self.pixels, self.count, vpls, self._rays, told, frames, light, irradiance]
        launch(take_kernel, self.capacity, inputs, self.device)
