"""More rays for the shading points that neighbours must not speak for. Beyond the 2022 paper.

gpu.dispute tells which. Their light is taken in parts of neighbouring VPL clusters, each of which gets a few rays, in
proportion to what its clusters would send were nothing between; what clusters of SPs believe does not count. Only SPs
that these rays, too, find to be much darker take what they say.
"""

from functools import cache

import warp as wp

from gpu.correct import member_of
from gpu.device import launch
from gpu.dispute import WorstPoints
from gpu.gbuffer import GBuffer
from gpu.grid import FAR_AWAY
from gpu.rays import connection
from gpu.resident import SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.transfer import brightness, unoccluded
from gpu.vpl_clusters import VplClusters, out_of_reach

PARTS = 16
RAYS = 4  # of each part
# Where more rays find more than this share of what was believed, that has less noise than they.
CONFIRMED = wp.constant(0.5)
REFINE_KEY = wp.constant(wp.uint32(0x2C1B3C6D))
Ints = wp.types.vector(length=RAYS, dtype=int)
Floats = wp.types.vector(length=RAYS, dtype=float)


@wp.struct
class Rays:
    """Rays of refined SPs, (part, ray, place) flattened: the VPL that each goes to, −1 for none, and its light.

    light: in units of what its part would send were nothing between, 0 once it was stopped; whole (part, place),
    flattened: that, its brightness [W/m²].
    """

    vpl: wp.array[int]
    light: wp.array[float]
    whole: wp.array[float]


@wp.kernel
def draw_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters,
                seed: int, rays: Rays) -> None:  # fmt: skip
    """One thread a part of the VPL clusters at one SP: draws where its rays go."""
    index = first + wp.tid()
    capacity = pixels.shape[0]
    place = index % capacity
    part = index // capacity
    for ray in range(wp.static(RAYS)):
        rays.vpl[(part * wp.static(RAYS) + ray) * capacity + place] = -1
    if place >= count[0]:
        return
    pixel = pixels[place]
    position = gbuffer.position[pixel]
    normal = gbuffer.normal[pixel]
    state = hashed(wp.uint32(pixel) ^ hashed(REFINE_KEY + wp.uint32(part) + wp.uint32(PARTS) * wp.uint32(seed)))
    target = Ints()
    following = Floats()
    next_change = float(0.0)
    whole = float(0.0)
    for ray in range(wp.static(RAYS)):
        target[ray] = -1
        following[ray] = 0.0
    begin = int(wp.int64(part) * wp.int64(vpls.count) / wp.int64(PARTS))
    end = int(wp.int64(part + 1) * wp.int64(vpls.count) / wp.int64(PARTS))
    per_group = vpls.per_group
    for group in range(begin // per_group, (end + per_group - 1) // per_group):
        if out_of_reach(position, normal, vpls, group):
            continue
        for vpl in range(wp.max(per_group * group, begin), wp.min(per_group * (group + 1), end)):
            light = brightness(unoccluded(position, normal, vpls, vpl))
            if light > 0.0:
                whole += light
                if whole >= next_change:
                    next_change = FAR_AWAY
                    for ray in range(wp.static(RAYS)):
                        if whole >= following[ray]:
                            state = hashed(state)
                            target[ray] = vpl
                            following[ray] = whole / ((float(state) + 1.0) * TO_UNIT)
                        next_change = wp.min(next_change, following[ray])
    rays.whole[index] = whole
    for ray in range(wp.static(RAYS)):
        if target[ray] >= 0:
            state = hashed(state)
            member = member_of(position, normal, vpls, target[ray], state)
            rays.vpl[(part * wp.static(RAYS) + ray) * capacity + place] = member.vpl
            rays.light[(part * wp.static(RAYS) + ray) * capacity + place] = member.share


@cache
def trace_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        vpls: VplClusters,
        rays: Rays,
    ) -> None:
        """One thread a ray: takes its light away if it is stopped."""
        index = first + wp.tid()
        vpl = rays.vpl[index]
        if vpl < 0:
            return
        pixel = pixels[index % pixels.shape[0]]
        position = vpls.members.position[vpl]
        normal = vpls.members.normal[vpl]
        if not connect(scene, gbuffer.position[pixel], gbuffer.geometric[pixel], position, normal):
            rays.light[index] = 0.0

    return kernel


@wp.kernel
def sum_kernel(first: int, pixels: wp.array[int], count: wp.array[int], vpls: VplClusters, rays: Rays,
               irradiance: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a refined SP: its irradiance becomes what arrived, if that is so much less that it was not chance."""
    place = first + wp.tid()
    if place >= count[0]:
        return
    capacity = pixels.shape[0]
    total = wp.vec3(0.0, 0.0, 0.0)
    for part in range(PARTS):
        arrived = wp.vec3(0.0, 0.0, 0.0)
        for ray in range(RAYS):
            index = (part * RAYS + ray) * capacity + place
            if rays.vpl[index] >= 0:
                flux = vpls.members.flux[rays.vpl[index]]
                arrived += flux * (rays.light[index] / brightness(flux))
        total += arrived * (rays.whole[part * capacity + place] / float(RAYS))
    if brightness(total) < CONFIRMED * brightness(irradiance[pixels[place]]):
        irradiance[pixels[place]] = total


class Refinement:
    """Re-shades up to `capacity` SPs with rays of their own; its arrays are allocated once."""

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.device, self._capacity = device, capacity
        self._rays = Rays()
        self._rays.vpl = wp.zeros(PARTS * RAYS * capacity, dtype=int, device=device)
        self._rays.light = wp.zeros(PARTS * RAYS * capacity, dtype=float, device=device)
        self._rays.whole = wp.zeros(PARTS * capacity, dtype=float, device=device)

    def run(self, scene: SceneData, gbuffer: GBuffer, points: WorstPoints, vpls: VplClusters, seed: int,
            irradiance: wp.array) -> None:  # fmt: skip
        """Overwrite the irradiance (pixel,) of those of `points` that rays of their own find to be much darker."""
        rays, capacity, device = self._rays, self._capacity, self.device
        inputs = [gbuffer, points.pixels, points.count, vpls, seed, rays]
        launch(draw_kernel, PARTS * capacity, inputs, device)
        inputs = [scene, gbuffer, points.pixels, vpls, rays]
        launch(trace_kernel(connection(scene)), PARTS * RAYS * capacity, inputs, device)
        launch(sum_kernel, capacity, [points.pixels, points.count, vpls, rays, irradiance], device)
