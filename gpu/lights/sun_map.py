"""Where on the disk through which a directional light reaches the scene its light paths begin.

Most of a sun's light meets roofs and ground, and little of it goes through windows. Paths begin there more often, and
carry less each, where what they light matters (gpu.vpl.sun_importance).
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.constants import PI
from gpu.core.parameters import parameters
from gpu.core.search import upper_bound
from gpu.sampling.sobol import Pair
from gpu.sampling.warps import on_disk
from gpu.scene.types import Ints


@wp.struct
@dataclass
class SunMapParameters:
    """How light paths are spread over a disk.

    side: cells of a map along each side of the square around it; uniform_share: of paths that begin anywhere alike, for
    what no map knows of: there may be fewer VPLs by this factor there.
    """

    side: int = 256
    uniform_share: float = 0.3


SUN_MAP_PARAMETERS: SunMapParameters = parameters(SunMapParameters)


@wp.struct
class SunMaps:
    """cumulative (light, cell): the chance that a path of a punctual light begins in this cell of side², row by row, or
    in one before it. Light paths of lights that have no row, or one of zeros, begin anywhere on their disk alike.
    """

    chosen: SunMapParameters
    cumulative: wp.array2d[float]


@wp.struct
class SunPlace:
    """A point of the disk, in disk radii, and how many times as often as anywhere alike paths begin there."""

    point: wp.vec2
    density: float


@wp.func
def cell_of(point: wp.vec2, side: int) -> int:
    """The cell of a map that holds a point of the disk."""
    column = wp.clamp(int(0.5 * (point[0] + 1.0) * float(side)), 0, side - 1)
    row = wp.clamp(int(0.5 * (point[1] + 1.0) * float(side)), 0, side - 1)
    return row * side + column


@wp.func
def map_density(maps: SunMaps, light: int, point: wp.vec2) -> float:
    """How many times as often as anywhere on the disk alike its map alone would have a path begin at a point."""
    cell = cell_of(point, maps.chosen.side)
    before = float(0.0)
    if cell > 0:
        before = maps.cumulative[light, cell - 1]
    # The square around the disk has 4 / π of its area.
    return (maps.cumulative[light, cell] - before) * float(maps.cumulative.shape[1]) * (PI / 4.0)


@wp.func
def sun_place(maps: SunMaps, light: int, pick: Pair, within: Pair) -> SunPlace:
    """Where a path of a directional light begins: by its map, or anywhere; it counts by both densities together
    (Veach 1997, 9.2.4).
    """
    place = SunPlace()
    place.density = 1.0
    place.point = on_disk(within.x, within.y)
    side = maps.chosen.side
    cells = maps.cumulative.shape[1]
    # Two questions: `or` would read beyond the rows.
    if light >= maps.cumulative.shape[0]:
        return place
    if maps.cumulative[light, cells - 1] <= 0.0:
        return place
    share = maps.chosen.uniform_share
    if pick.x >= share:
        cell = wp.min(upper_bound(maps.cumulative[light], cells, pick.y), cells - 1)
        column = float(cell % side) + within.x
        row = float(cell // side) + within.y
        place.point = wp.vec2(2.0 * column / float(side) - 1.0, 2.0 * row / float(side) - 1.0)
    anywhere = wp.where(wp.length_sq(place.point) <= 1.0, share, 0.0)
    place.density = anywhere + (1.0 - share) * map_density(maps, light, place.point)
    return place


@wp.func
def mapped_share(maps: SunMaps, light: int, cells: int) -> float:
    """The chance that a ray of `image_place` lies in one of the first `cells` cells, row by row."""
    share = maps.chosen.uniform_share
    seen = float(0.0)
    if cells > 0:
        seen = maps.cumulative[light, cells - 1]
    return share * float(cells) / float(maps.cumulative.shape[1]) + (1.0 - share) * seen


@wp.func
def image_place(maps: SunMaps, light: int, within: Pair) -> SunPlace:
    """As `sun_place` for a pixel of an image: neighbours stay neighbours, row by row and then along each row.

    Rays that are to begin anywhere do so all over the square around the disk, beyond which there is no light to lose.
    """
    place = SunPlace()
    place.density = 1.0
    place.point = on_disk(within.x, within.y)
    side = maps.chosen.side
    # Two questions: `or` would read beyond the rows.
    if light >= maps.cumulative.shape[0]:
        return place
    if maps.cumulative[light, maps.cumulative.shape[1] - 1] <= 0.0:
        return place
    row = int(0)
    beyond = int(side)
    while beyond - row > 1:
        middle = (row + beyond) // 2
        if mapped_share(maps, light, middle * side) > within.y:
            beyond = middle
        else:
            row = middle
    first = row * side
    begin = mapped_share(maps, light, first)
    in_row = mapped_share(maps, light, first + side) - begin
    value = begin + within.x * in_row
    column = int(0)
    beyond = int(side)
    while beyond - column > 1:
        middle = (column + beyond) // 2
        if mapped_share(maps, light, first + middle) > value:
            beyond = middle
        else:
            column = middle
    before = mapped_share(maps, light, first + column)
    in_cell = mapped_share(maps, light, first + column + 1) - before
    x = (float(column) + wp.clamp((value - before) / in_cell, 0.0, 1.0)) / float(side)
    y = (float(row) + wp.clamp((within.y - begin) / in_row, 0.0, 1.0)) / float(side)
    place.point = wp.vec2(2.0 * x - 1.0, 2.0 * y - 1.0)
    place.density = in_cell * float(maps.cumulative.shape[1]) * (PI / 4.0)
    return place


def sun_maps(seen: Ints, device: wp.Device, chosen: SunMapParameters = SUN_MAP_PARAMETERS) -> SunMaps:
    """Maps in proportion to what was `seen`, (light, row, column), each side `chosen.side`, and next to it."""
    side = chosen.side
    wide = np.pad(seen.astype(np.float64), ((0, 0), (1, 1), (1, 1)))
    near = sum(wide[:, row : row + side, column : column + side] for row in range(3) for column in range(3))
    cumulative = np.cumsum(np.asarray(near).reshape(len(seen), -1), axis=1)
    total = cumulative[:, -1:]
    maps = SunMaps()
    maps.chosen = chosen
    maps.cumulative = wp.array(cumulative / np.where(total > 0.0, total, 1.0), dtype=float, device=device)
    return maps


def no_sun_maps(device: wp.Device) -> SunMaps:
    """Of no light: all light paths begin anywhere on their disks alike."""
    maps = SunMaps()
    maps.chosen = SUN_MAP_PARAMETERS
    maps.cumulative = wp.zeros((0, 1), dtype=float, device=device)
    return maps
