"""A frame's shading points, listed in Morton order, which keeps neighbours together."""

from copy import copy
from typing import Protocol

import numpy as np
import warp as wp

from gpu.core.device import duplicate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.morton import morton_order
from gpu.core.parameters import parameters
from gpu.core.radix_sort import running_total
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData
from gpu.gbuffer.gbuffer import GBuffer, apparent_position
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.sparse_shading import (
    PreviousEdges,
    SparseShadingParameters,
    is_at_edge,
    is_shaded,
    reflect_irradiance_kernel,
)


@wp.kernel
def mark_shaded_kernel(first: int, gbuffer: GBuffer, image: ImageSize, sparse: SparseShadingParameters,
                       order: wp.array[int], before: PreviousEdges, shaded: wp.array[int],
                       listed: wp.array[int]) -> None:  # fmt: skip
    """One thread a pixel, in Morton order: 1 where the pixel has an SP, else 0.

    shaded: in that order; listed (pixel,): by pixel.
    """
    index = first + wp.tid()
    pixel = order[index]
    shaded[index] = 0
    if gbuffer.face[pixel] != NO_HIT:
        if is_shaded(gbuffer, pixel, image, sparse):
            shaded[index] = 1
        elif before.follows[0] == 1:
            shaded[index] = int(is_at_edge(before, apparent_position(gbuffer, pixel), image))
    listed[pixel] = shaded[index]


@wp.kernel
def list_shaded_kernel(first: int, shaded: wp.array[int], totals: wp.array[int], order: wp.array[int],
                       points: PointList) -> None:  # fmt: skip
    """One thread a pixel, in Morton `order` (place,): lists it when it has an SP; the last writes the list's length.

    shaded, totals (place,): 1 for those, and the running sum of that.
    """
    index = first + wp.tid()
    if shaded[index] == 1:
        points.pixels[totals[index] - 1] = order[index]
    if index == shaded.shape[0] - 1:
        points.count[0] = totals[index]


@wp.kernel
def add_at_points_kernel(first: int, points: PointList, term: wp.array[wp.vec3], total: wp.array[wp.vec3]) -> None:
    """One thread an SP: adds `term` (pixel,) to `total` (pixel,)."""
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    pixel = points.pixels[sp]
    total[pixel] += term[pixel]


class ListedPoints(Protocol):
    """All SPs of an image or some of them, at most `capacity`, in Morton order.

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

    pixels (sp,): their pixels in Morton order, of which the first count[0] are valid; listed (pixel,): 1 for these,
    else 0. image: its size, as kernels take it; stride: of the anchors of gpu.gbuffer.sparse_shading; with 1 every
    pixel that meets a surface has an SP. before: edges of light in the frame before; thresholds: of
    SparseShadingParameters.
    """

    def __init__(self, size: tuple[int, int], stride: int, device: wp.Device, **thresholds: float) -> None:
        self.device, self.stride = device, stride
        self.sparse: SparseShadingParameters = parameters(SparseShadingParameters, stride=stride, **thresholds)
        self.image = image_size(size)
        self.capacity = size[0] * size[1]
        self.pixels = wp.zeros(self.capacity, dtype=int, device=device)
        self.numbers = wp.array(np.arange(self.capacity), dtype=int, device=device)
        self.count = wp.zeros(1, dtype=int, device=device)
        self.points = PointList()
        self.points.pixels, self.points.numbers, self.points.count = self.pixels, self.numbers, self.count
        self._order = morton_order(size, device)
        self.listed = wp.zeros(self.capacity, dtype=int, device=device)
        self.before = self._edges_of_no_frame()
        self._shaded = wp.zeros(self.capacity, dtype=int, device=device)
        self._totals = wp.zeros(self.capacity, dtype=int, device=device)

    def _edges_of_no_frame(self) -> PreviousEdges:
        edges = PreviousEdges()
        edges.follows = wp.zeros(1, dtype=int, device=self.device)
        edges.camera = wp.zeros(1, dtype=CameraData, device=self.device)
        edges.edges = wp.zeros(self.capacity, dtype=wp.uint8, device=self.device)
        return edges

    def for_another_viewer(self) -> "ShadingPoints":
        """One with edges of light of its own frames; all lists are shared and are of whoever found SPs last."""
        other = copy(self)
        other.before = other._edges_of_no_frame()
        return other

    def find(self, gbuffer: GBuffer, *, every: bool = False) -> None:
        """List the pixels of `gbuffer` that are shaded; those that see nothing cost nothing from here on.

        every: all others are shaded, whatever their anchors know.
        """
        sparse = self.sparse
        if every:
            sparse = duplicate(SparseShadingParameters, sparse)
            sparse.stride = 1
        inputs = [gbuffer, self.image, sparse, self._order, self.before, self._shaded, self.listed]
        launch(mark_shaded_kernel, self.capacity, inputs, self.device)
        running_total(self._shaded, self._totals)
        inputs = [self._shaded, self._totals, self._order, self.points]
        launch(list_shaded_kernel, self.capacity, inputs, self.device)

    def add(self, term: wp.array, total: wp.array) -> None:
        """Add `term` (pixel,) to `total` (pixel,) at the pixels that are shaded."""
        launch(add_at_points_kernel, self.capacity, [self.points, term, total], self.device)

    def reflect(self, gbuffer: GBuffer, irradiance: wp.array, mean: wp.array, radiance: wp.array) -> None:
        """Add to `radiance` (pixel,) what all pixels reflect of the `irradiance` (pixel,) that the shaded ones know.

        mean: (1,) brightness of the picture, about.
        """
        inputs = [gbuffer, self.image, self.sparse, self.listed, irradiance, mean, self.before.edges, radiance]
        launch(reflect_irradiance_kernel, self.capacity, inputs, self.device)
