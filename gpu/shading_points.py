"""A frame's shading points, listed in an order that keeps neighbours together, and the sample that is clustered."""

import numpy as np
import warp as wp

from gpu.device import allocate, launch
from gpu.gbuffer import GBuffer
from gpu.grouping import running_total
from gpu.kmeans import Points
from gpu.resident import NO_HIT
from gpu.sampling import hashed
from gpu.scene.types import Ints


def z_order(width: int, height: int) -> Ints:
    """Pixel indices of an image along the Z-order curve, shape (pixel,)."""

    def spread(values: np.ndarray) -> np.ndarray:
        bits = values.astype(np.uint64)
        for shift, mask in ((16, 0x0000FFFF0000FFFF), (8, 0x00FF00FF00FF00FF), (4, 0x0F0F0F0F0F0F0F0F)):
            bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
        for shift, mask in ((2, 0x3333333333333333), (1, 0x5555555555555555)):
            bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
        return bits

    codes = spread(np.arange(width))[None, :] | (spread(np.arange(height))[:, None] << np.uint64(1))
    return np.argsort(codes.ravel(), kind="stable").astype(np.int32)


@wp.kernel
def valid_kernel(first: int, face: wp.array[int], order: wp.array[int], valid: wp.array[int]) -> None:
    """One thread a pixel, in Z order: 1 where the camera meets a surface, else 0."""
    index = first + wp.tid()
    valid[index] = wp.where(face[order[index]] == NO_HIT, 0, 1)


@wp.kernel
def compact_kernel(first: int, valid: wp.array[int], totals: wp.array[int], order: wp.array[int],
                   pixels: wp.array[int], count: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel, in Z order: lists it when it has an SP; the last one writes the list's length."""
    index = first + wp.tid()
    if valid[index] == 1:
        pixels[totals[index] - 1] = order[index]
    if index == valid.shape[0] - 1:
        count[0] = totals[index]


@wp.kernel
def sample_kernel(first: int, gbuffer: GBuffer, pixels: wp.array[int], total: wp.array[int], wanted: int,
                  clusters: int, seed: int, sampled: wp.array[int], out: Points) -> None:  # fmt: skip
    """One thread a sample: one SP of each of `wanted` equal runs of the list, or every SP when they are fewer."""
    index = first + wp.tid()
    sp_count = total[0]
    count = wp.min(wanted, sp_count)
    if index == 0:
        out.count[0] = count
    if index >= count:
        return
    begin = int(wp.int64(index) * wp.int64(sp_count) / wp.int64(count))
    end = int(wp.int64(index + 1) * wp.int64(sp_count) / wp.int64(count))
    pick = hashed(wp.uint32(index) ^ hashed(wp.uint32(seed)))
    pixel = pixels[begin + int(pick % wp.uint32(wp.max(end - begin, 1)))]
    sampled[index] = pixel
    out.position[index] = gbuffer.position[pixel]
    out.normal[index] = gbuffer.normal[pixel]
    out.weight[index] = 1.0
    out.spacing[index] = gbuffer.spacing[pixel] * wp.sqrt(float(sp_count) / float(clusters))


class ShadingPoints:
    """The SPs of an image of `size` (width, height), found anew each frame without leaving the device.

    pixels (sp,): their pixels in Z order, of which the first count[0] are valid.
    """

    def __init__(self, size: tuple[int, int], device: wp.Device) -> None:
        self.device = device
        self.capacity = size[0] * size[1]
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)
        self._order = wp.array(z_order(*size), dtype=int, device=device)
        self._valid = wp.zeros(self.capacity, dtype=int, device=device)
        self._totals = wp.zeros(self.capacity, dtype=int, device=device)

    def find(self, gbuffer: GBuffer) -> None:
        """List the pixels of `gbuffer` that have an SP; those that see nothing cost nothing from here on."""
        launch(valid_kernel, self.capacity, [gbuffer.face, self._order, self._valid], self.device)
        running_total(self._valid, self._totals)
        inputs = [self._valid, self._totals, self._order, self.pixels, self.count]
        launch(compact_kernel, self.capacity, inputs, self.device)


class SampledPoints:
    """The paper's downsampling by γ (Alg. 1, line 1): `points` holds at most `capacity` SPs, `pixels` their pixels."""

    def __init__(self, capacity: int, device: wp.Device) -> None:
        self.capacity, self.device = capacity, device
        self.pixels = wp.zeros(capacity, dtype=int, device=device)
        self.points: Points = allocate(Points, capacity, device)
        self.points.count = wp.zeros(1, dtype=int, device=device)

    def draw(self, sps: ShadingPoints, gbuffer: GBuffer, clusters: int, seed: int) -> None:
        """Sample `sps` evenly; spacings are those of `clusters` clusters."""
        inputs = [gbuffer, sps.pixels, sps.count, self.capacity, clusters, seed, self.pixels, self.points]
        launch(sample_kernel, self.capacity, inputs, self.device)
