"""The nearest of all clusters, found without a look at each: runs of them that cannot win are passed over.

Clusters in Morton order lie side by side, so each run of them lies in a small sphere with normals in a narrow cone.
None of it is nearer than the sphere, nor more alike than the cone. In the order of their numbers those that have
started again at a random point would make spheres as wide as the scene.
"""

import warp as wp

from gpu.clustering.grid import ClusteringParameters, Representatives, separation
from gpu.clustering.nearest import OTHER_NORMAL
from gpu.core.bucket_sort import Buckets
from gpu.core.constants import PI
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import bits_of_all, float_least, four_at, lowest_bit, place_of_least
from gpu.core.morton import AXIS_BITS, EMPTY_KEY, morton_key

# More would lie in wider spheres, fewer leave more of these to look at; what is found does not depend on it.
PER_RUN = wp.constant(8)
# Clusters are sorted in buckets of Morton keys that are alike but for so many bits: 16³ cells for each direction.
CELL_BITS = 15
# Spheres are this much wider than what they hold, against rounding.
WIDER = wp.constant(1.0001)
ROUNDING = wp.constant(1.0e-3)  # and cones, by this angle
# What a run of unlike normals is farther by, which distances that have it are rounded by.
UNLIKE = wp.constant(1.0e-4 - float(OTHER_NORMAL))


@wp.struct
class ClusterRunBounds:
    """Clusters in use in Morton order, and bounds of each PER_RUN of them that follow each other, as a search reads
    them.

    place (place,): a position, and whose, as a float; −1 behind the last. normal (place,): the normal there. sphere
    (run,): centre and radius of one that holds the run, a radius of −1 for one behind the last; cone (run,): an axis
    and the cosine of an angle with it, beyond which no normal is like one of the run's.
    """

    place: wp.array[wp.vec4]
    normal: wp.array[wp.vec4]
    sphere: wp.array[wp.vec4]
    cone: wp.array[wp.vec4]


@wp.kernel
def cluster_key_kernel(first: int, clusters: Representatives, keys: wp.array[int]) -> None:
    """One thread a cluster: its place on the Morton curve, EMPTY_KEY where it is not in use."""
    cluster = first + wp.tid()
    keys[cluster] = EMPTY_KEY
    if clusters.spacing[cluster] > 0.0:
        keys[cluster] = morton_key(clusters.position[cluster], clusters.normal[cluster])


@wp.kernel
def bound_runs_kernel(first: int, clusters: Representatives, items: wp.array[int], starts: wp.array[int],
                      runs: ClusterRunBounds) -> None:  # fmt: skip
    """One thread a run: its clusters, and their sphere and cone about their means.

    items, starts: of the clusters' Buckets.
    """
    run = first + wp.tid()
    begin = run * PER_RUN
    end = wp.min(begin + PER_RUN, starts[starts.shape[0] - 1])
    centre = wp.vec3(0.0, 0.0, 0.0)
    axis = wp.vec3(0.0, 0.0, 0.0)
    for place in range(begin, begin + PER_RUN):
        whose = float(-1.0)
        p = wp.vec3(0.0, 0.0, 0.0)
        n = wp.vec3(0.0, 0.0, 0.0)
        if place < end:
            whose = float(items[place])
            p = clusters.position[items[place]]
            n = clusters.normal[items[place]]
        centre += p
        axis += n
        runs.place[place] = wp.vec4(p[0], p[1], p[2], whose)
        runs.normal[place] = wp.vec4(n[0], n[1], n[2], 0.0)
    centre = centre / float(wp.max(end - begin, 1))
    axis = wp.normalize(axis)
    radius = float(-1.0)
    spread = float(0.0)
    for place in range(begin, end):
        p = clusters.position[items[place]]
        n = clusters.normal[items[place]]
        radius = wp.max(radius, wp.length(p - centre) * WIDER)
        spread = wp.max(spread, wp.acos(wp.clamp(wp.dot(axis, n), -1.0, 1.0)))
    alike = wp.cos(wp.min(spread + wp.acos(clusters.chosen.normal_threshold) + ROUNDING, PI))
    runs.sphere[run] = wp.vec4(centre[0], centre[1], centre[2], radius)
    runs.cone[run] = wp.vec4(axis[0], axis[1], axis[2], alike)


class ClusterRuns:
    """Runs of up to `most` clusters; `bounds` is what kernels take."""

    def __init__(self, most: int, device: wp.Device) -> None:
        count = -(-most // int(PER_RUN))
        self._order = Buckets(most, 6 << (3 * int(AXIS_BITS) - CELL_BITS), device, shift=CELL_BITS)
        self.bounds: ClusterRunBounds = allocate(ClusterRunBounds, count, device)
        for name in ("place", "normal"):
            setattr(self.bounds, name, wp.zeros(int(PER_RUN) * count, dtype=wp.vec4, device=device))

    def bound(self, clusters: Representatives) -> None:
        """Bound the runs of the first `most` of `clusters` as they are now."""
        order = self._order
        launch(cluster_key_kernel, order.capacity, [clusters, order.keys], order.device)
        order.sort()
        inputs = [clusters, order.items, order.starts, self.bounds]
        launch(bound_runs_kernel, len(self.bounds.sphere), inputs, order.device)


@wp.func
def stretched(chosen: ClusteringParameters, position: wp.vec3, normal: wp.vec3, other_position: wp.vec3,
              other_normal: wp.vec3) -> float:  # fmt: skip
    """The distance of a cluster, far more where its normal is unlike."""
    distance = separation(chosen, position, normal, other_position, other_normal)
    alike = wp.dot(other_normal, normal) > chosen.normal_threshold
    return wp.where(alike, distance, distance + OTHER_NORMAL)


@wp.func
def may_win(runs: ClusterRunBounds, run: int, position: wp.vec3, normal: wp.vec3, distance: float) -> bool:
    """Whether a cluster of a run may be as near to a point as `distance`, as `stretched` tells it."""
    sphere = four_at(runs.sphere, run)
    cone = four_at(runs.cone, run)
    radius = distance + sphere[3]
    if wp.dot(wp.vec3(cone[0], cone[1], cone[2]), normal) < cone[3]:
        radius += UNLIKE
    away = wp.vec3(sphere[0], sphere[1], sphere[2]) - position
    return sphere[3] >= 0.0 and radius >= 0.0 and wp.length_sq(away) <= radius * radius


@wp.func
def nearest_in_runs(clusters: Representatives, runs: ClusterRunBounds, position: wp.vec3, normal: wp.vec3, guess: int,
                    lane: int, lanes: int) -> int:  # fmt: skip
    """The nearest of all clusters, the first of those as near, as gpu.clustering.nearest.nearest_of_all finds it.

    guess: a cluster in use; the nearer that is, the fewer are looked at. The `lanes` (gpu.core.intrinsics) of a point
    look at the bounds of a run each, then together at each run that may win: one that did so alone would keep all
    others of its warp waiting.
    """
    chosen = clusters.chosen
    best = guess
    best_distance = stretched(chosen, position, normal, clusters.position[guess], clusters.normal[guess])
    nearest = best_distance
    count = runs.sphere.shape[0]
    for begin in range(0, count, lanes):
        bit = int(0)
        if begin + lane < count:
            bit = wp.where(may_win(runs, begin + lane, position, normal, nearest), 1 << lane, 0)
        bits = bits_of_all(bit, lanes)
        if bits != 0:
            while bits != 0:
                run = begin + lowest_bit(wp.uint32(bits))
                bits &= bits - 1
                for place in range(run * PER_RUN + lane, (run + 1) * PER_RUN, lanes):
                    p = four_at(runs.place, place)
                    n = four_at(runs.normal, place)
                    cluster = int(p[3])
                    distance = stretched(chosen, position, normal, wp.vec3(p[0], p[1], p[2]), wp.vec3(n[0], n[1], n[2]))
                    nearer = distance < best_distance or (distance == best_distance and cluster < best)
                    if cluster >= 0 and nearer:
                        best_distance = distance
                        best = cluster
            nearest = float_least(best_distance, lanes)
    return place_of_least(best_distance, best, lanes)
