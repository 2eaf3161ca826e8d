"""A frame's shading points, listed in an order that keeps neighbours together, and the sample that is clustered."""

from copy import copy
from typing import Protocol

import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.core.radix_sort import running_total
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.sparse_shading import is_shaded, light_ended, reflect_kernel
from gpu.scene.types import Ints


def morton_order(width: int, height: int) -> Ints:
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
def shaded_kernel(first: int, gbuffer: GBuffer, width: int, height: int, stride: int, order: wp.array[int],
                  follows: wp.array[int], before: wp.array[CameraData], irradiance_edges: wp.array[wp.uint8],
                  shaded: wp.array[int], listed: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel, in Z order: 1 where the camera meets a surface that is shaded there, else 0.

    follows (1,): 1 where light `irradiance_edges` (pixel,) in the image of the camera `before` (1,) about as in this
    one; shaded: in that order; listed (pixel,): by pixel.
    """
    index = first + wp.tid()
    pixel = order[index]
    shaded[index] = 0
    if gbuffer.face[pixel] != NO_HIT:
        if is_shaded(gbuffer, pixel, width, height, stride):
            shaded[index] = 1
        elif follows[0] == 1:
            shaded[index] = int(light_ended(before, irradiance_edges, gbuffer.position[pixel], width, height))
    listed[pixel] = shaded[index]


@wp.kernel
def compact_kernel(first: int, shaded: wp.array[int], totals: wp.array[int], order: wp.array[int],
                   pixels: wp.array[int], count: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel, in Z order: lists it when it has an SP; the last one writes the list's length."""
    index = first + wp.tid()
    if shaded[index] == 1:
        pixels[totals[index] - 1] = order[index]
    if index == shaded.shape[0] - 1:
        count[0] = totals[index]


@wp.kernel
def add_kernel(first: int, pixels: wp.array[int], count: wp.array[int], term: wp.array[wp.vec3],
               bounded: bool, total: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread an SP: adds `term` (pixel,) to `total` (pixel,); bounded: not to below zero."""
    sp = first + wp.tid()
    if sp >= count[0]:
        return
    pixel = pixels[sp]
    total[pixel] += term[pixel]
    if bounded:
        total[pixel] = wp.max(total[pixel], wp.vec3(0.0, 0.0, 0.0))


class ListedPoints(Protocol):
    """All SPs of an image or some of them, at most `capacity`, in Z order.

    pixels, numbers (place,): their pixels, and which of all SPs they are; the first count[0] are valid; points: these
    three as kernels take them.
    """

    capacity: int
    points: PointList
    pixels: wp.array
    numbers: wp.array
    count: wp.array


class ShadingPoints:
    """The SPs of an image of `size` (width, height), found anew each frame without leaving the device: ListedPoints.

    pixels (sp,): their pixels in Z order, of which the first count[0] are valid; listed (pixel,): 1 for these, else 0.
    stride: of the anchors of gpu.gbuffer.sparse_shading; with 1 every pixel that meets a surface has an SP. follows
    (1,): whether the camera `before` (1,) saw much the same in the frame before, so that pixels where light ended then
    have SPs.
    """

    def __init__(self, size: tuple[int, int], stride: int, device: wp.Device) -> None:
        self.device, self.stride = device, stride
        self._size = size
        self.capacity = size[0] * size[1]
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.numbers = wp.array(np.arange(self.capacity), dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)
        self.points = PointList()
        self.points.pixels, self.points.numbers, self.points.count = self.pixels, self.numbers, self.count
        self._order = wp.array(morton_order(*size), dtype=int, device=device)
        self.listed = wp.zeros(self.capacity, dtype=int, device=device)
        self.follows = wp.zeros(1, dtype=int, device=device)
        self.before = wp.zeros(1, dtype=CameraData, device=device)
        self._irradiance_edges = wp.zeros(self.capacity, dtype=wp.uint8, device=device)
        self._shaded = wp.zeros(self.capacity, dtype=int, device=device)
        self._totals = wp.zeros(self.capacity, dtype=int, device=device)

    def for_another_viewer(self) -> "ShadingPoints":
        """One that knows where light ended in frames of its own; all lists are shared, of whoever found SPs last."""
        other = copy(self)
        other.follows, other.before = wp.zeros_like(self.follows), wp.zeros_like(self.before)
        other._irradiance_edges = wp.zeros_like(self._irradiance_edges)
        return other

    def find(self, gbuffer: GBuffer) -> None:
        """List the pixels of `gbuffer` that are shaded; those that see nothing cost nothing from here on."""
        inputs = [gbuffer, *self._size, self.stride, self._order, self.follows, self.before, self._irradiance_edges]
        launch(shaded_kernel, self.capacity, [*inputs, self._shaded, self.listed], self.device)
        running_total(self._shaded, self._totals)
        inputs = [self._shaded, self._totals, self._order, self.pixels, self.count]
        launch(compact_kernel, self.capacity, inputs, self.device)

    def add(self, term: wp.array, total: wp.array, *, bounded: bool) -> None:
        """Add `term` (pixel,) to `total` (pixel,) at the pixels that are shaded; bounded: not to below zero.

        A mean of frames needs what is below zero in some of them.
        """
        launch(add_kernel, self.capacity, [self.pixels, self.count, term, bounded, total], self.device)

    def reflect(self, gbuffer: GBuffer, irradiance: wp.array, mean: wp.array, radiance: wp.array) -> None:
        """Add to `radiance` (pixel,) what all pixels reflect of the `irradiance` (pixel,) that the shaded ones know.

        mean: (1,) brightness of the picture, about.
        """
        inputs = [gbuffer, *self._size, self.stride, self.listed, irradiance, mean, self._irradiance_edges, radiance]
        launch(reflect_kernel, self.capacity, inputs, self.device)
