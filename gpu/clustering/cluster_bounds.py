"""The nearest of all clusters, found without a look at each: runs of them that cannot win are passed over.

Clusters in Morton order lie side by side, so each run of them lies in a small sphere with normals in a narrow cone.
None of it is nearer than the sphere, nor more alike than the cone; and so it is with groups of runs. In the order of
their numbers those that have started again at a random point would make spheres as wide as the scene.
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
RUNS_PER_GROUP = wp.constant(8)
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
    and the cosine of an angle with it, beyond which no normal is like one of the run's, as `widest_cosine` tells it.
    group_sphere, group_cone (group,): as those, of RUNS_PER_GROUP runs each.
    """

    place: wp.array[wp.vec4]
    normal: wp.array[wp.vec4]
    sphere: wp.array[wp.vec4]
    cone: wp.array[wp.vec4]
    group_sphere: wp.array[wp.vec4]
    group_cone: wp.array[wp.vec4]


@wp.func
def xyz(v: wp.vec4) -> wp.vec3:
    """A vector's first three."""
    return wp.vec3(v[0], v[1], v[2])


@wp.func
def widest_cosine(angle: float) -> float:
    """The cosine of an angle; below that of any two vectors, however rounded, where nothing is beyond it."""
    return wp.where(angle >= PI, -2.0, wp.cos(angle))


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
    alike = widest_cosine(spread + wp.acos(clusters.chosen.normal_threshold) + ROUNDING)
    runs.sphere[run] = wp.vec4(centre[0], centre[1], centre[2], radius)
    runs.cone[run] = wp.vec4(axis[0], axis[1], axis[2], alike)


@wp.kernel
def bound_groups_kernel(first: int, runs: ClusterRunBounds) -> None:
    """One thread a group: its sphere and cone about the means of those of its runs."""
    group = first + wp.tid()
    begin = group * RUNS_PER_GROUP
    end = wp.min(begin + RUNS_PER_GROUP, runs.sphere.shape[0])
    while end > begin and runs.sphere[end - 1][3] < 0.0:
        end -= 1
    centre = wp.vec3(0.0, 0.0, 0.0)
    axis = wp.vec3(0.0, 0.0, 0.0)
    for run in range(begin, end):
        centre += xyz(runs.sphere[run])
        axis += xyz(runs.cone[run])
    centre = centre / float(wp.max(end - begin, 1))
    axis = wp.normalize(axis)
    radius = float(-1.0)
    spread = float(0.0)
    for run in range(begin, end):
        sphere = runs.sphere[run]
        cone = runs.cone[run]
        radius = wp.max(radius, (wp.length(xyz(sphere) - centre) + sphere[3]) * WIDER)
        between = wp.acos(wp.clamp(wp.dot(axis, xyz(cone)), -1.0, 1.0))
        spread = wp.max(spread, between + wp.acos(wp.clamp(cone[3], -1.0, 1.0)))
    alike = widest_cosine(spread + ROUNDING)
    runs.group_sphere[group] = wp.vec4(centre[0], centre[1], centre[2], radius)
    runs.group_cone[group] = wp.vec4(axis[0], axis[1], axis[2], alike)


class ClusterRuns:
    """Runs of up to `most` clusters; `bounds` is what kernels take."""

    def __init__(self, most: int, device: wp.Device) -> None:
        count = -(-most // int(PER_RUN))
        groups = -(-count // int(RUNS_PER_GROUP))
        self._order = Buckets(most, 6 << (3 * int(AXIS_BITS) - CELL_BITS), device, shift=CELL_BITS)
        self.bounds: ClusterRunBounds = allocate(ClusterRunBounds, count, device)
        for name in ("place", "normal"):
            setattr(self.bounds, name, wp.zeros(int(PER_RUN) * count, dtype=wp.vec4, device=device))
        for name in ("group_sphere", "group_cone"):
            setattr(self.bounds, name, wp.zeros(groups, dtype=wp.vec4, device=device))

    def bound(self, clusters: Representatives) -> None:
        """Bound the runs of the first `most` of `clusters` as they are now."""
        order = self._order
        launch(cluster_key_kernel, order.capacity, [clusters, order.keys], order.device)
        order.sort()
        inputs = [clusters, order.items, order.starts, self.bounds]
        launch(bound_runs_kernel, len(self.bounds.sphere), inputs, order.device)
        launch(bound_groups_kernel, len(self.bounds.group_sphere), [self.bounds], order.device)


@wp.func
def stretched(chosen: ClusteringParameters, position: wp.vec3, normal: wp.vec3, other_position: wp.vec3,
              other_normal: wp.vec3) -> float:  # fmt: skip
    """The distance of a cluster, far more where its normal is unlike."""
    distance = separation(chosen, position, normal, other_position, other_normal)
    alike = wp.dot(other_normal, normal) > chosen.normal_threshold
    return wp.where(alike, distance, distance + OTHER_NORMAL)


@wp.func
def may_win(spheres: wp.array[wp.vec4], cones: wp.array[wp.vec4], run: int, end: int, position: wp.vec3,
            normal: wp.vec3, distance: float) -> int:  # fmt: skip
    """Whether a run or group, one before `end`, may have a cluster as near to a point as `distance`, as `stretched`
    tells it: 1, else 0.
    """
    if run >= end:
        return 0
    sphere = four_at(spheres, run)
    cone = four_at(cones, run)
    radius = distance + sphere[3]
    if wp.dot(xyz(cone), normal) < cone[3]:
        radius += UNLIKE
    away = xyz(sphere) - position
    return int(sphere[3] >= 0.0 and radius >= 0.0 and wp.length_sq(away) <= radius * radius)


@wp.func
def nearest_in_runs(clusters: Representatives, runs: ClusterRunBounds, position: wp.vec3, normal: wp.vec3, guess: int,
                    lane: int, lanes: int) -> int:  # fmt: skip
    """The nearest of all clusters, the first of those as near, as gpu.clustering.nearest.nearest_of_all finds it.

    guess: a cluster in use; the nearer that is, the fewer are looked at. The `lanes` (gpu.core.intrinsics) of a point
    look at the bounds of a group each, then together at the runs of each group that may win, and then at each run that
    may: one that did so alone would keep all others of its warp waiting.
    """
    chosen = clusters.chosen
    best = guess
    best_distance = stretched(chosen, position, normal, clusters.position[guess], clusters.normal[guess])
    nearest = best_distance
    count = runs.sphere.shape[0]
    groups = runs.group_sphere.shape[0]
    for begin_group in range(0, groups, lanes):
        may = may_win(runs.group_sphere, runs.group_cone, begin_group + lane, groups, position, normal, nearest)
        group_bits = bits_of_all(may << lane, lanes)
        while group_bits != 0:
            first_run = (begin_group + lowest_bit(wp.uint32(group_bits))) * RUNS_PER_GROUP
            group_bits &= group_bits - 1
            end_run = wp.min(first_run + RUNS_PER_GROUP, count)
            for begin in range(first_run, end_run, lanes):
                may = may_win(runs.sphere, runs.cone, begin + lane, end_run, position, normal, nearest)
                bits = bits_of_all(may << lane, lanes)
                while bits != 0:
                    run = begin + lowest_bit(wp.uint32(bits))
                    bits &= bits - 1
                    for place in range(run * PER_RUN + lane, (run + 1) * PER_RUN, lanes):
                        p = four_at(runs.place, place)
                        n = four_at(runs.normal, place)
                        cluster = int(p[3])
                        distance = stretched(chosen, position, normal, xyz(p), xyz(n))
                        nearer = distance < best_distance or (distance == best_distance and cluster < best)
                        if cluster >= 0 and nearer:
                            best_distance = distance
                            best = cluster
                nearest = float_least(best_distance, lanes)
    return place_of_least(best_distance, best, lanes)
