"""Where probes (gpu.adaptive.error_probes) are: drawn more often where those of frames before found errors.

A picture's error is that of few pixels, which stay near where they were from one frame to the next. So the image has
tiles, and probes go to each in proportion to the root of the mean square of what probes found there, which leaves an
estimate least noise. Probes drawn evenly leave it a deviation of 7.5, 5.4 and 6.8 over the root of their number (a
Cornell box, an atrium, a conference room), in proportion to brightness 5.9, 4.2 and 6.0, so 2.7, 3.3 and 4.2.
"""

import numpy as np
import warp as wp

from gpu.core.device import launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.search import upper_bound
from gpu.gbuffer.point_list import PointList
from gpu.sampling.sobol import TO_UNIT, hashed

# Pixels on each side of a tile.
TILE = wp.constant(16)
# Share of the mean that is added to each tile's, for errors that are new; and what is left of a frame in the next one.
FLOOR, LASTING = wp.constant(0.3), wp.constant(0.6)


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
def area_of(tile: int, image: ImageSize) -> float:
    """A tile's share of the image."""
    tiles = (image.width + TILE - 1) // TILE
    across = wp.min(TILE, image.width - tile % tiles * TILE)
    down = wp.min(TILE, image.height - tile // tiles * TILE)
    return float(across * down) / (float(image.width) * float(image.height))


@wp.kernel
def probe_pixel_kernel(first: int, image: ImageSize, frame: wp.array[int], until: wp.array[float],
                 tiles: wp.array[int], pixels: wp.array[int], counts: wp.array[float]) -> None:  # fmt: skip
    """One thread a probe: draws its pixel, in even steps through `until` (tile,): shares of all probes up to its end.

    tiles (probe,): where it is, in ascending order; counts (probe,): how many pixels it stands for, 1 in the mean.
    """
    probe = first + wp.tid()
    state = hashed(wp.uint32(probe) ^ hashed(~wp.uint32(frame[0])))
    step = (float(probe) + float(state) * TO_UNIT) / float(pixels.shape[0])
    tile = upper_bound(until, until.shape[0] - 1, step)
    share = until[tile]
    if tile > 0:
        share -= until[tile - 1]
    tiles[probe] = tile
    pixels[probe] = pixel_of_probe(tile, image, hashed(state))
    counts[probe] = area_of(tile, image) / share


@wp.func
def first_of(tiles: wp.array[int], tile: int) -> int:
    """The first probe of a tile, or, where it has none, of those that follow."""
    return upper_bound(tiles, tiles.shape[0], tile - 1)


@wp.kernel
def tile_error_kernel(first: int, tiles: wp.array[int], counts: wp.array[float], products: wp.array[float],
                 squares: wp.array2d[float], looks: wp.array2d[float]) -> None:  # fmt: skip
    """One thread a tile: takes in what its probes found, their `products` (probe,) of two estimates of an error.

    squares, looks (row, column): what products' squares, and the pixels that these stand for, sum up to.
    """
    tile = first + wp.tid()
    found = float(0.0)
    looked = float(0.0)
    for probe in range(first_of(tiles, tile), first_of(tiles, tile + 1)):
        if wp.isfinite(products[probe]):
            found += counts[probe] * products[probe] * products[probe]
            looked += counts[probe]
    row = tile // looks.shape[1]
    column = tile % looks.shape[1]
    squares[row, column] = LASTING * squares[row, column] + found
    looks[row, column] = LASTING * looks[row, column] + looked


@wp.func
def blurred(tiles: wp.array2d[float], row: int, column: int) -> float:
    """The sum of a tile (row, column) with those around, by 1/4, 1/2, 1/4 on each axis."""
    total = float(0.0)
    for near in range(9):
        down = near // 3 - 1
        across = near % 3 - 1
        y = row + down
        x = column + across
        if y >= 0 and y < tiles.shape[0] and x >= 0 and x < tiles.shape[1]:
            total += tiles[y, x] * (0.5 - 0.25 * float(wp.abs(down))) * (0.5 - 0.25 * float(wp.abs(across)))
    return total


@wp.kernel
def tile_weight_kernel(first: int, image: ImageSize, squares: wp.array2d[float], looks: wp.array2d[float],
                     deviations: wp.array2d[float]) -> None:  # fmt: skip
    """One thread a tile: how much products deviate there, times the tile's area."""
    tile = first + wp.tid()
    row = tile // looks.shape[1]
    column = tile % looks.shape[1]
    found = wp.sqrt(blurred(squares, row, column) / wp.max(blurred(looks, row, column), 1.0e-6))
    deviations[row, column] = found * area_of(tile, image)


@wp.kernel
def tile_row_kernel(first: int, deviations: wp.array2d[float]) -> None:
    """One thread a row of tiles: running totals of them."""
    row = first + wp.tid()
    total = float(0.0)
    for column in range(deviations.shape[1]):
        total += deviations[row, column]
        deviations[row, column] = total


@wp.kernel
def tile_cdf_kernel(first: int, evenly: wp.array[float], totals: wp.array2d[float], until: wp.array[float]) -> None:
    """One thread a tile: the share of all probes up to its end, by running `totals` of each row.

    evenly (tile,): that share if they were drawn evenly. Where all totals are 0 it stays.
    """
    tile = first + wp.tid()
    last = totals.shape[1] - 1
    own = totals[tile // totals.shape[1], tile % totals.shape[1]]
    whole = float(0.0)
    for row in range(totals.shape[0]):
        if row == tile // totals.shape[1]:
            own += whole
        whole += totals[row, last]
    if whole > 0.0:
        until[tile] = (own / whole + FLOOR * evenly[tile]) / (1.0 + FLOOR)


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
        self._until = wp.clone(self._evenly)
        self._squares, self._looks, self._deviations = (
            wp.zeros(area.shape, dtype=float, device=device) for _ in range(3)
        )

    def draw(self, frame: wp.array) -> None:
        """Draw `points`, others in each `frame` (1,)."""
        inputs = [self._image, frame, self._until, self._tiles, self.points.pixels, self.counts]
        launch(probe_pixel_kernel, len(self.points.pixels), inputs, self._device)

    def learn(self, products: wp.array) -> None:
        """Have the next probes go to where these (probe,) found errors: their `products` of two estimates of them.

        Those that are not finite, or all 0, tell nothing.
        """
        device, deviations, sums = self._device, self._deviations, [self._squares, self._looks]
        launch(tile_error_kernel, len(self._until), [self._tiles, self.counts, products, *sums], device)
        launch(tile_weight_kernel, len(self._until), [self._image, *sums, deviations], device)
        launch(tile_row_kernel, deviations.shape[0], [deviations], device)
        launch(tile_cdf_kernel, len(self._until), [self._evenly, deviations, self._until], device)
