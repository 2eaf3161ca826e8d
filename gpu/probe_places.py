"""Where probes (gpu.probes) are: drawn more often where those of frames before found errors.

A picture's error is that of few pixels, which stay near where they were from one frame to the next. So the image has
tiles, and probes go to each in proportion to the root of the mean square of what probes found there, which leaves an
estimate least noise. Probes drawn evenly leave it a deviation of 7.5, 5.4 and 6.8 over the root of their number (a
Cornell box, an atrium, a conference room), in proportion to brightness 5.9, 4.2 and 6.0, so 2.7, 3.3 and 4.2.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gpu.device import launch
from gpu.sampling import TO_UNIT, hashed

# Pixels on each side of a tile.
TILE = wp.constant(16)
# Share of the mean that is added to each tile's, for errors that are new; and what is left of a frame in the next one.
FLOOR, LASTING = 0.3, 0.6

Doubles = NDArray[np.float64]


@wp.func
def pixel_of_probe(tile: int, width: int, height: int, state: wp.uint32) -> int:
    """One of a tile's pixels."""
    tiles = (width + TILE - 1) // TILE
    left = tile % tiles * TILE
    top = tile // tiles * TILE
    wide = wp.min(TILE, width - left)
    pick = int(state % wp.uint32(wide * wp.min(TILE, height - top)))
    return (top + pick // wide) * width + left + pick % wide


@wp.kernel
def place_kernel(first: int, width: int, height: int, frame: wp.array[int], until: wp.array[float],
                 pixels: wp.array[int], counts: wp.array[float]) -> None:  # fmt: skip
    """One thread a probe: draws its pixel, in even steps through `until` (tile,): shares of all probes up to its end.

    counts (probe,): how many pixels it stands for, 1 in the mean.
    """
    probe = first + wp.tid()
    state = hashed(wp.uint32(probe) ^ hashed(~wp.uint32(frame[0])))
    step = (float(probe) + float(state) * TO_UNIT) / float(pixels.shape[0])
    low = int(0)
    high = until.shape[0] - 1
    while low < high:
        middle = (low + high) // 2
        if until[middle] > step:
            high = middle
        else:
            low = middle + 1
    share = until[low]
    if low > 0:
        share -= until[low - 1]
    tiles = (width + TILE - 1) // TILE
    across = wp.min(TILE, width - low % tiles * TILE)
    down = wp.min(TILE, height - low // tiles * TILE)
    pixels[probe] = pixel_of_probe(low, width, height, hashed(state))
    counts[probe] = float(across * down) / (share * float(width * height))


def blurred(tiles: Doubles) -> Doubles:
    """The sums of tiles (row, column) with those around, by 1/4, 1/2, 1/4 on each axis."""
    for _ in range(2):
        # Along rows, then, turned over, along columns.
        padded = np.zeros((tiles.shape[0] + 2, tiles.shape[1]))
        padded[1:-1] = tiles
        tiles = (0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]).T
    return tiles


class ProbePlaces:
    """Places of `count` probes in an image of `size` (width, height); its arrays are allocated once.

    pixels (probe,); counts (probe,): how many pixels each stands for, 1 in the mean.
    """

    def __init__(self, size: tuple[int, int], count: int, device: wp.Device) -> None:
        self._size, self._device = size, device
        self.pixels = wp.zeros(count, dtype=int, device=device)
        self.counts = wp.zeros(count, dtype=float, device=device)
        across, down = (np.diff(np.append(np.arange(0, side, int(TILE)), side)) for side in size)
        self._area = np.outer(down, across) / (size[0] * size[1])
        # Of each tile: what products' squares and their pixels sum up to.
        self._squares: Doubles = np.zeros(self._area.shape)
        self._looks: Doubles = np.zeros(self._area.shape)
        self._until = wp.zeros(self._area.size, dtype=float, device=device)
        self._share(np.ones(self._area.shape))

    def _share(self, weights: Doubles) -> None:
        """Share the probes among the tiles, by `weights` of their pixels."""
        until = np.cumsum(self._area * weights)
        self._until.assign((until / until[-1]).astype(np.float32))

    def draw(self, frame: wp.array) -> None:
        """Draw `pixels`, others in each `frame` (1,)."""
        inputs = [*self._size, frame, self._until, self.pixels, self.counts]
        launch(place_kernel, len(self.pixels), inputs, self._device)

    def learn(self, products: Doubles) -> None:
        """Have the next probes go to where these (probe,) found errors: their `products` of two estimates of them.

        Those that are not finite, or all 0, tell nothing.
        """
        if not np.isfinite(products).all():
            return
        pixels, counts = self.pixels.numpy(), self.counts.numpy()
        width, (rows, columns) = self._size[0], self._area.shape
        tiles = pixels // width // int(TILE) * columns + pixels % width // int(TILE)
        for sums, values in ((self._squares, counts * np.square(products)), (self._looks, counts)):
            sums *= LASTING
            sums += np.bincount(tiles, weights=values, minlength=rows * columns).reshape(rows, columns)
        found = np.sqrt(blurred(self._squares) / np.maximum(blurred(self._looks), 1e-6))
        mean = float(np.sum(self._area * found))
        if mean > 0.0:
            self._share(found + FLOOR * mean)
