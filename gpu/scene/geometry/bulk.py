"""What makes up a scene, whatever small things lie far away from it: survey points, origin markers, forgotten parts."""

from dataclasses import dataclass

import numpy as np

from gpu.scene.geometry.boxes import box, largest, lengths, middles
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.types import Doubles, Integers, Mask

# So much of all area belongs to the bulk, and what lies beyond does up to a gap wider than what lies within.
CORE, GAP = 0.9, 4.0
# Extents of the bulk. What is small and lies farther away is seen under less than a degree, and takes precision away.
FARTHEST = 100.0


@dataclass(frozen=True, eq=False)
class Bulk:
    """The box (3,) around the triangles that make up a scene, and which triangles those are (triangle,).

    distances (triangle,): of the corner of each triangle that is farthest from the box's middle, along one axis.
    """

    member: Mask
    low: Doubles
    high: Doubles
    distances: Doubles

    @property
    def too_far(self) -> Mask:
        """Which triangles (triangle,) lie too far away to be of use."""
        return ~self.member & (self.distances > FARTHEST * float((self.high - self.low).max()))


def bulk_of(positions: Doubles, triangles: Integers, counts: Mask | None = None) -> Bulk:
    """The bulk of triangles (triangle, 3), indices of positions (vertex, 3): without what is small and beyond a gap.

    A ground plane is large: it belongs to the bulk. counts (triangle,): which may belong to it, if not all.
    """
    counts = np.ones(len(triangles), bool) if counts is None else counts
    size = max(float(np.abs(positions).max()), np.finfo(float).tiny)
    area = lengths(area_vectors(positions / size, triangles))
    area = np.where(counts, area if area[counts].any() else 1.0, 0.0)
    middle = np.array([_weighted_median(column, area) for column in middles(positions, triangles).T])
    reach = _distances(positions, triangles, middle)
    member = counts & (reach <= _radius(reach[counts], area[counts]))
    low, high = box(positions, triangles[member])
    return Bulk(member, low, high, _distances(positions, triangles, low + (high - low) / 2.0))


def _distances(positions: Doubles, triangles: Integers, middle: Doubles) -> Doubles:
    return largest(largest(positions - middle)[triangles])


def _radius(reach: Doubles, area: Doubles) -> float:
    """Up to which distance from the middle triangles, whose farthest corners are at `reach`, belong to the bulk."""
    order = np.argsort(reach)
    near = reach[order]
    core = int(np.searchsorted(np.cumsum(area[order]), CORE * area.sum()).clip(0, len(near) - 1))
    gaps = np.flatnonzero(near[core + 1 :] > GAP * near[core:-1])
    return float(near[core + gaps[0]] if len(gaps) else near[-1])


def _weighted_median(values: Doubles, weights: Doubles) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[int(np.searchsorted(total, total[-1] / 2.0))]])
