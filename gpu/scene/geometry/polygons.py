"""Polygons of three and more corners as triangles: convex ones as fans, all others by clipping ears."""

from dataclasses import dataclass
from math import pi

import mapbox_earcut
import numpy as np

from gpu.scene.types import Doubles, Integers, Mask

# Polygons looked at together, so that intermediate arrays stay small.
_AT_ONCE = 1 << 17
# Twice an area, relative to twice the polygon's: below is rounding.
_ROUNDING = 1e-9
# Triangles that cover more or less than the polygon's area by this share are of one that crosses itself.
_DEVIATION = 1e-3
# Ears are looked for among all corners near them, which are all in the worst outlines: so many take up to 8 s.
MOST_CORNERS = 1 << 15
TOO_LARGE = f"polygons of more than {MOST_CORNERS} corners that are not convex were left out: split them"


@dataclass(frozen=True, eq=False)
class Triangulation:
    """triangles (triangle, 3): positions in the list of all corners; polygons (triangle,): which one each is of.

    crossing: polygons that cross themselves, of which some shape was made; too_small: those of fewer than 3 corners,
    too_large: those of more than MOST_CORNERS that are not convex, which have no triangles.
    """

    triangles: Integers
    polygons: Integers
    crossing: int
    too_small: int
    too_large: int


def triangulate(positions: Doubles, corners: Integers, counts: Integers) -> Triangulation:
    """Triangles that cover polygons, in their order and with their orientation.

    positions (vertex, 3), finite; corners (corner,): the polygons' vertices one after another; counts (polygon,): how
    many corners each has. A polygon may be concave and not quite flat; one without an area becomes triangles without.
    """
    starts = np.cumsum(counts) - counts
    triangles, polygons = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)]
    crossing = too_large = 0
    for count in 3 + np.flatnonzero(np.bincount(counts[counts >= 3] - 3)):
        same = np.flatnonzero(counts == count)
        for some in np.array_split(same, -(-len(same) * int(count) // _AT_ONCE)):
            places = starts[some, None] + np.arange(count)
            if count > 3:
                made, owner, crossed, skipped = _cut(positions[corners[places]], places)
                crossing, too_large = crossing + crossed, too_large + skipped
                triangles.append(made)
                polygons.append(some[owner])
            else:
                triangles.append(places)
                polygons.append(some)
    owners = np.concatenate(polygons)
    order = np.argsort(owners, kind="stable")
    too_small = int(np.sum(counts < 3))
    return Triangulation(np.concatenate(triangles)[order], owners[order], crossing, too_small, too_large)


def _cut(outlines: Doubles, places: Integers) -> tuple[Integers, Integers, int, int]:
    """Triangles of `places` (polygon, corner) with these positions, their polygons, and how many of these cross
    themselves and are too large.
    """
    number, count = places.shape
    outlines = outlines - outlines[:, :1]
    size = np.abs(outlines).max(axis=(1, 2))
    outlines /= np.where(size > 0.0, size, 1.0)[:, None, None]
    if count == 4:
        halves, crosses = _halves(outlines)
        made = np.take_along_axis(places[:, None], halves, axis=2).reshape(-1, 3)
        return made, np.repeat(np.arange(number), 2), int(crosses.sum()), 0
    normals = np.cross(outlines, np.roll(outlines, -1, axis=1)).sum(axis=1)  # Newell: length is twice the area
    convex = _convex(outlines, normals)
    fans = places[convex][:, _fan(count)].reshape(-1, 3)
    others = np.flatnonzero(~convex)
    too_large = len(others) if count > MOST_CORNERS else 0
    others = others[too_large:]
    ears, owners, crossing = _clip_ears(outlines[others], normals[others])
    clipped = np.take_along_axis(places[others][owners], ears, axis=1)
    return (
        np.concatenate([fans, clipped]),
        np.concatenate([np.repeat(np.flatnonzero(convex), count - 2), others[owners]]),
        crossing,
        too_large,
    )


def _fan(count: int) -> Integers:
    """Triangles (count - 2, 3) from the first corner to each edge that does not touch it."""
    middle = np.arange(1, count - 1)
    return np.stack([np.zeros_like(middle), middle, middle + 1], axis=1)


def _halves(outlines: Doubles) -> tuple[Integers, Mask]:
    """The triangles (polygon, 2, 3) of four corners (polygon, 4, 3) of size 1, and which outlines cross themselves.

    They are halved where both halves look to one side, which one of both diagonals does unless the outline crosses.
    """
    halves = np.array([[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]])
    scores = []
    for pair in halves:
        one, other = (np.cross(outlines[:, b] - outlines[:, a], outlines[:, c] - outlines[:, a]) for a, b, c in pair)
        both = one + other
        scores.append(np.minimum((one * both).sum(axis=1), (other * both).sum(axis=1)))
    second = (scores[0] < 0.0) & (scores[1] > scores[0])
    cancelling = (np.abs(both).max(axis=1) < _ROUNDING) & (np.abs(one).max(axis=1) > _ROUNDING)
    return halves[second.astype(int)], (np.maximum(*scores) < -_ROUNDING) | cancelling


def _convex(outlines: Doubles, normals: Doubles) -> Mask:
    """Which outlines (polygon, corner, 3) turn to the left everywhere, seen along their normals, and once around."""
    edges = np.roll(outlines, -1, axis=1) - outlines
    before = np.roll(edges, 1, axis=1)
    area = np.linalg.norm(normals, axis=1)
    unit = normals / np.where(area > 0.0, area, 1.0)[:, None]
    turns = np.einsum("pkc,pc->pk", np.cross(before, edges), unit)
    turning = np.arctan2(turns, np.einsum("pkc,pkc->pk", before, edges)).sum(axis=1)  # a star's goes around twice
    left = (turns >= -_ROUNDING * area[:, None]).all(axis=1)
    return np.asarray((area > 0.0) & left & (np.abs(turning - 2.0 * pi) < 0.1))


def _clip_ears(outlines: Doubles, normals: Doubles) -> tuple[Integers, Integers, int]:
    """Triangles (triangle, 3) of corners of outlines (polygon, corner, 3) of size 1, their polygons, how many cross.

    normals (polygon, 3): Newell's, of length twice the area.
    """
    number, count = outlines.shape[:2]
    area = np.linalg.norm(normals, axis=1)
    up = normals.copy()
    up[area <= _ROUNDING] = _thinnest(outlines[area <= _ROUNDING])
    up /= np.linalg.norm(up, axis=1)[:, None]
    sideways = np.cross(up, np.eye(3)[np.abs(up).argmin(axis=1)])
    sideways /= np.linalg.norm(sideways, axis=1)[:, None]
    plane = np.stack([np.einsum("pkc,pc->pk", outlines, axis) for axis in (sideways, np.cross(up, sideways))], axis=2)
    end = np.array([count], np.uint32)
    found = [mapbox_earcut.triangulate_float64(outline, end).reshape(-1, 3).astype(np.int64) for outline in plane]
    found = [triangles if len(triangles) else _fan(count) for triangles in found]
    ears = np.concatenate([np.empty((0, 3), np.int64), *found])
    owners = np.repeat(np.arange(number), [len(triangles) for triangles in found])
    a, b, c = (plane[owners, ears[:, corner]] for corner in range(3))
    twice = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    covered = np.bincount(owners, twice, number)
    crosses = np.abs(covered - area) > np.maximum(_DEVIATION * np.maximum(covered, area), _ROUNDING)
    return ears, owners, int(crosses.sum())


def _thinnest(outlines: Doubles) -> Doubles:
    """The directions (polygon, 3) in which the corners of outlines (polygon, corner, 3) vary least."""
    return np.asarray(np.linalg.svd(outlines - outlines.mean(axis=1, keepdims=True), full_matrices=False)[2][:, 2])
