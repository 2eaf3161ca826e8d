"""The error of a frame's indirect light, estimated at a few pixels without a reference picture.

At probes, pixels drawn anew each frame, the light of all VPLs is gathered as `exact-vpl` does, but with few rays: each
bunch of VPL clusters sends one, from a member drawn in proportion to its unoccluded light there. That is done twice:
the product of two independent differences is right in the mean where the square of one would count the probes' own
noise. Most of an estimate's noise is the choice of pixels, so that many probes with few rays are best.
"""

from collections import deque
from functools import cache

import numpy as np
import warp as wp

from gpu.device import launch
from gpu.gbuffer import GBuffer, reflectance
from gpu.interpolate import irradiance_at
from gpu.rays import connection
from gpu.resident import NO_HIT, SceneData
from gpu.sampling import TO_UNIT, hashed
from gpu.scene.types import Floats
from gpu.transfer import brightness, disk_transfer, light_of
from gpu.view import View
from gpu.vpl_clusters import VplClusters

ON_CUDA, ON_CPU = 4096, 512
# What counts as white in gpu.metrics; of at least so many probes. Those of 32 frames were behind a camera that turns:
# errors in a conference room were taken for 0.83 to 1.23 times what they were.
WHITE_PERCENT, WHITE_PROBES = 99.0, 1 << 11
# Where the picture is brightest, which this share of it is not, it is less or more so than the truth.
BRIGHT_PERCENT = 95.0
# Rays of an estimate at a probe. With 512 probes in a conference room one frame's error has a deviation of 0.29 by the
# choice of pixels alone, of 0.37 with 64 rays for each, of 0.61 with 16, and of 0.35 to 0.41 with one for each of 192
# clusters.
BUNCHES = wp.constant(64)


@wp.kernel
def place_kernel(first: int, total: int, frame: wp.array[int], pixels: wp.array[int]) -> None:
    """One thread a probe: one pixel of each of equal runs of the image's `total`, another in each `frame` (1,)."""
    probe = first + wp.tid()
    count = pixels.shape[0]
    begin = int(wp.int64(probe) * wp.int64(total) / wp.int64(count))
    end = int(wp.int64(probe + 1) * wp.int64(total) / wp.int64(count))
    pick = hashed(wp.uint32(probe) ^ hashed(wp.uint32(frame[0])))
    pixels[probe] = begin + int(pick % wp.uint32(end - begin))


@wp.kernel
def turn_kernel(first: int, frame: wp.array[int]) -> None:
    """One thread: the next frame has other probes and rays, also where this is replayed."""
    frame[first + wp.tid()] += 1


@cache
def gather_kernel(connect: wp.Function) -> wp.Kernel:
    """The kernel that traces with `connect`, one of gpu.rays.connected and connected_solid."""

    @wp.kernel(module="unique")
    def kernel(
        first: int,
        scene: SceneData,
        gbuffer: GBuffer,
        pixels: wp.array[int],
        frame: wp.array[int],
        vpls: VplClusters,
        one: wp.array[wp.vec3],
        other: wp.array[wp.vec3],
    ) -> None:
        """One thread a BUNCHES-th of the VPL clusters at one probe: two estimates of their light there, a ray each.

        one, other: (probe, bunch), flattened [W/m²].
        """
        index = first + wp.tid()
        one[index] = wp.vec3(0.0, 0.0, 0.0)
        other[index] = wp.vec3(0.0, 0.0, 0.0)
        pixel = pixels[index // BUNCHES]
        if gbuffer.face[pixel] == NO_HIT:
            return
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        geometric = gbuffer.geometric[pixel]
        state = hashed(wp.uint32(index) ^ hashed(wp.uint32(frame[0])))
        bunch = index % BUNCHES
        this = int(-1)
        that = int(-1)
        total = float(0.0)
        for vpl in range((bunch * vpls.count) // BUNCHES, ((bunch + 1) * vpls.count) // BUNCHES):
            begin = vpls.starts[vpl]
            end = vpls.starts[vpl + 1]
            area = vpls.disks[vpl].area / float(end - begin)
            for member in range(begin, end):
                way = vpls.members.position[member] - position
                light = disk_transfer(way, normal, vpls.members.normal[member], area)
                light *= brightness(vpls.members.flux[member])
                if light > 0.0:
                    total += light
                    state = hashed(state)
                    if float(state) * TO_UNIT * total < light:
                        this = member
                    state = hashed(state)
                    if float(state) * TO_UNIT * total < light:
                        that = member
        if this < 0 or that < 0:
            return
        seen = connect(scene, position, geometric, vpls.members.position[this], vpls.members.normal[this])
        if seen:
            one[index] = light_of(vpls, this, total)
        if that != this:
            seen = connect(scene, position, geometric, vpls.members.position[that], vpls.members.normal[that])
        if seen:
            other[index] = light_of(vpls, that, total)

    return kernel


@wp.kernel
def compare_kernel(first: int, gbuffer: GBuffer, width: int, height: int, stride: int, pixels: wp.array[int],
                   one: wp.array[wp.vec3], other: wp.array[wp.vec3], irradiance: wp.array[wp.vec3],
                   radiance: wp.array2d[wp.vec3]) -> None:  # fmt: skip
    """One thread a probe: its radiance in the picture, and by the two estimates. radiance: (3, probe) [W/m²/sr]."""
    probe = first + wp.tid()
    pixel = pixels[probe]
    for row in range(3):
        radiance[row, probe] = wp.vec3(0.0, 0.0, 0.0)
    if gbuffer.face[pixel] == NO_HIT:
        return
    reflected = reflectance(gbuffer, pixel)
    light = irradiance_at(gbuffer, pixel, width, height, stride, irradiance)
    radiance[0, probe] = wp.cw_mul(reflected, light)
    this = wp.vec3(0.0, 0.0, 0.0)
    that = wp.vec3(0.0, 0.0, 0.0)
    for index in range(probe * BUNCHES, (probe + 1) * BUNCHES):
        this += one[index]
        that += other[index]
    radiance[1, probe] = wp.cw_mul(reflected, this)
    radiance[2, probe] = wp.cw_mul(reflected, that)


def white_of(render: Floats, truth: Floats) -> float:
    """What counts as white of the truth, by a render and noisy estimates of the truth at the same places.

    The noise of probes' own rays makes their brightest brighter, and few clusters make the picture's darker: by the one
    alone errors were taken for 0.90 to 0.96 times what they were, by the other for 1.0 to 1.17 times.
    """
    bright = render >= np.percentile(render, BRIGHT_PERCENT)
    mean = float(np.mean(render[bright], dtype=np.float64))
    if not mean > 0.0:
        return 0.0
    return float(np.percentile(render, WHITE_PERCENT)) * float(np.mean(truth[bright], dtype=np.float64)) / mean


def clipped_product(render: Floats, one: Floats, other: Floats, white: float) -> float:
    """MSE (gpu.metrics) of a render (probe, 3) against two independent estimates of the truth; 0 where it is black."""
    if white <= 0.0:
        return 0.0
    x, a, b = (np.clip(np.asarray(values, np.float64) / white, 0.0, 1.0) for values in (render, one, other))
    return float(np.mean((x - a) * (x - b)))


class Probes:
    """Probes of the frames of `view`; its arrays are allocated once."""

    def __init__(self, view: View) -> None:
        self._view = view
        count, device = min(ON_CUDA if view.device.is_cuda else ON_CPU, view.pixels), view.device
        self._frame = wp.zeros(1, dtype=int, device=device)
        self._pixels = wp.zeros(count, dtype=int, device=device)
        self._one = wp.zeros(count * int(BUNCHES), dtype=wp.vec3, device=device)
        self._other = wp.zeros(count * int(BUNCHES), dtype=wp.vec3, device=device)
        self._radiance = wp.zeros((3, count), dtype=wp.vec3, device=device)
        self._seen: deque[Floats] = deque(maxlen=-(-WHITE_PROBES // count))

    def run(self, vpls: VplClusters) -> None:
        """Gather the light of `vpls` at new probes, before the view's indirect light gets what is not theirs."""
        view, device, count = self._view, self._view.device, len(self._pixels)
        launch(turn_kernel, 1, [self._frame], device)
        launch(place_kernel, count, [view.pixels, self._frame, self._pixels], device)
        inputs = [view.scene, view.gbuffer, self._pixels, self._frame, vpls, self._one, self._other]
        launch(gather_kernel(connection(view.scene)), len(self._one), inputs, device)
        inputs = [view.gbuffer, *view.size, view.shading_points.stride, self._pixels, self._one, self._other]
        launch(compare_kernel, count, [*inputs, view.indirect.irradiance, self._radiance], device)

    def error(self) -> float:
        """What the probes of the last frame, which is ready, make of its MSE; noisy, and right in the mean."""
        render, one, other = self._radiance.numpy()
        self._seen.append(np.stack([render, 0.5 * (one + other)]))
        seen = np.concatenate(list(self._seen), axis=1)
        return clipped_product(render, one, other, white_of(seen[0], seen[1]))
