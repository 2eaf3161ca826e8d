"""Where probes (gpu.adaptive.error_probes) are: drawn more often where those of frames before found errors.

A picture's error is that of few pixels, which stay near where they were from one frame to the next. So the image has
tiles, and probes go to each in proportion to the root of the mean square of what probes found there, which leaves an
estimate least noise. Probes drawn evenly leave it a deviation of 7.5, 5.4 and 6.8 over the root of their number (a
Cornell box, an atrium, a conference room), in proportion to brightness 5.9, 4.2 and 6.0, so 2.7, 3.3 and 4.2.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp
from warp.utils import array_scan

from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.search import upper_bound
from gpu.gbuffer.point_list import PointList
from gpu.sampling.sobol import TO_UNIT, hashed

# Pixels on each side of a tile.
TILE = wp.constant(16)


@dataclass(frozen=True)
class ProbePlacementParameters:
    """even_share: as many probes as this of those drawn by errors are drawn evenly, for errors that are new.

    lasting: what is left of a frame in the next one.
    """

    even_share: float = 0.3
    lasting: float = 0.6


PROBE_PLACEMENT_PARAMETERS = ProbePlacementParameters()


@wp.func
def pixel_of_probe(tile: int, image: ImageSize, state: wp.uint32) -> int:
    """One of a tile's pixels."""
    tiles = (image.width + TILE - 1) // TILE
    left = tile % tiles * TILE
    top = tile // tiles * TILE
    wide = wp.min(TILE, image.width - left)
    pick = int(state % wp.uint32(wide * wp.min(TILE, image.height - top)))
    return (top + pick // wide) * image.width + left + pick % wide


@wp.func
def share_of(cdf: wp.array[float], tile: int) -> float:
    """A tile's own share; cdf (tile,)."""
    if tile == 0:
        return cdf[0]
    return cdf[tile] - cdf[tile - 1]


@wp.kernel
def probe_pixel_kernel(first: int, image: ImageSize, frame: wp.array[int], evenly: wp.array[float],
                       cdf: wp.array[float], tiles: wp.array[int], points: PointList,
                       counts: wp.array[float]) -> None:  # fmt: skip
    """One thread a probe: draws its pixel, in even steps through the `cdf` (tile,) of all probes.

    evenly (tile,): the CDF of pixels; tiles (probe,): where each is, in ascending order; counts (probe,): how many
    pixels it stands for, 1 in the mean.
    """
    probe = first + wp.tid()
    state = hashed(wp.uint32(probe) ^ hashed(~wp.uint32(frame[0])))
    step = (float(probe) + float(state) * TO_UNIT) / float(tiles.shape[0])
    tile = upper_bound(cdf, cdf.shape[0] - 1, step)
    tiles[probe] = tile
    points.pixels[probe] = pixel_of_probe(tile, image, hashed(state))
    counts[probe] = share_of(evenly, tile) / share_of(cdf, tile)


@wp.func
def first_of(tiles: wp.array[int], tile: int) -> int:
    """The first probe of a tile, or, where it has none, of those that follow; tiles (probe,): ascending."""
    return upper_bound(tiles, tiles.shape[0], tile - 1)


@wp.kernel
def tile_error_kernel(first: int, lasting: float, tiles: wp.array[int], counts: wp.array[float],
                      products: wp.array[float], evenly: wp.array[float], found: wp.array[wp.vec2],
                      weights: wp.array[float]) -> None:  # fmt: skip
    """One thread a tile: takes in what its probes found, their `products` (probe,) of two estimates of an error.

    found (tile,): sums of products' squares, and of the pixels that these stand for; weights (tile,): how much products
    deviate there, times the tile's area.
    """
    tile = first + wp.tid()
    total = lasting * found[tile]
    for probe in range(first_of(tiles, tile), first_of(tiles, tile + 1)):
        if wp.isfinite(products[probe]):
            total += counts[probe] * wp.vec2(products[probe] * products[probe], 1.0)
    found[tile] = total
    weights[tile] = wp.sqrt(total[0] / wp.max(total[1], 1.0e-6)) * share_of(evenly, tile)


@wp.kernel
def tile_cdf_kernel(first: int, even_share: float, evenly: wp.array[float], totals: wp.array[float],
                    cdf: wp.array[float]) -> None:  # fmt: skip
    """One thread a tile: the share of probes up to its end, by running `totals` (tile,); where all are 0 it stays."""
    tile = first + wp.tid()
    whole = totals[totals.shape[0] - 1]
    if whole > 0.0:
        cdf[tile] = (totals[tile] / whole + even_share * evenly[tile]) / (1.0 + even_share)


class ProbePlaces:
    """Places of `count` probes in an image of `size` (width, height); its arrays are allocated once.

    points: the probes; counts (probe,): how many pixels each stands for, 1 in the mean.
    """

    def __init__(self, size: tuple[int, int], count: int, device: wp.Device) -> None:
        self._image, self._device = image_size(size), device
        self._tiles = wp.zeros(count, dtype=int, device=device)
        self.points = PointList()
        self.points.pixels = wp.zeros(count, dtype=int, device=device)
        self.points.count = wp.full(1, count, dtype=int, device=device)
        self.counts = wp.zeros(count, dtype=float, device=device)
        across, down = (np.diff(np.append(np.arange(0, side, int(TILE)), side)) for side in size)
        area = np.outer(down, across)
        self._evenly = wp.array(np.cumsum(area) / area.sum(), dtype=float, device=device)
        self._cdf = wp.clone(self._evenly)
        self._found = wp.zeros(area.size, dtype=wp.vec2, device=device)
        self._weights = wp.zeros(area.size, dtype=float, device=device)

    def draw(self, frame: wp.array) -> None:
        """Draw `points`, others in each `frame` (1,)."""
        inputs = [self._image, frame, self._evenly, self._cdf, self._tiles, self.points, self.counts]
        launch(probe_pixel_kernel, len(self.counts), inputs, self._device)

    def learn(self, products: wp.array) -> None:
        """Have the next probes go to where these (probe,) found errors: their `products` of two estimates of them.

        Those that are not finite, or all 0, tell nothing.
        """
        own, device, tiles, weights = PROBE_PLACEMENT_PARAMETERS, self._device, len(self._cdf), self._weights
        inputs = [own.lasting, self._tiles, self.counts, products, self._evenly, self._found, weights]
        launch(tile_error_kernel, tiles, inputs, device)
        array_scan(weights, weights, inclusive=True)
        launch(tile_cdf_kernel, tiles, [own.even_share, self._evenly, weights, self._cdf], device)
