"""The nearest of all clusters, found without a look at each: runs of them that cannot win are passed over.

Clusters start in the order of their points, which keeps neighbours together, and move little. So each run of them lies
in a small sphere with normals in a narrow cone. None of it is nearer than the sphere, nor more alike than the cone.
"""

import warp as wp

from gpu.clustering.grid import Representatives, separation
from gpu.clustering.nearest import OTHER_NORMAL
from gpu.core.constants import PI
from gpu.core.device import allocate, launch
from gpu.core.intrinsics import place_of_least

# More would lie in wider spheres, fewer leave more of these to look at; what is found does not depend on it.
PER_RUN = wp.constant(8)
# Spheres are this much wider than what they hold, against rounding.
WIDER = wp.constant(1.0001)
ROUNDING = wp.constant(1.0e-3)  # and cones, by this angle
# What a run of unlike normals is farther by, which distances that have it are rounded by.
UNLIKE = wp.constant(1.0e-4 - float(OTHER_NORMAL))


@wp.struct
class ClusterRunBounds:
    """Bounds of each PER_RUN clusters that follow each other.

    centre, radius (run,): a sphere that holds those in use, of radius −1 where none is; axis, alike (run,): none of
    them has a normal like one whose cosine with the axis is less than `alike`.
    """

    centre: wp.array[wp.vec3]
    radius: wp.array[float]
    axis: wp.array[wp.vec3]
    alike: wp.array[float]


@wp.kernel
def bound_runs_kernel(first: int, clusters: Representatives, runs: ClusterRunBounds) -> None:
    """One thread a run: its sphere and cone, about the means of its clusters."""
    run = first + wp.tid()
    begin = run * PER_RUN
    end = wp.min(begin + PER_RUN, clusters.spacing.shape[0])
    centre = wp.vec3(0.0, 0.0, 0.0)
    axis = wp.vec3(0.0, 0.0, 0.0)
    used = float(0.0)
    for cluster in range(begin, end):
        if clusters.spacing[cluster] > 0.0:
            centre += clusters.position[cluster]
            axis += clusters.normal[cluster]
            used += 1.0
    centre = centre / wp.max(used, 1.0)
    axis = wp.normalize(axis)
    radius = float(-1.0)
    spread = float(0.0)
    for cluster in range(begin, end):
        if clusters.spacing[cluster] > 0.0:
            radius = wp.max(radius, wp.length(clusters.position[cluster] - centre) * WIDER)
            spread = wp.max(spread, wp.acos(wp.clamp(wp.dot(axis, clusters.normal[cluster]), -1.0, 1.0)))
    runs.centre[run] = centre
    runs.radius[run] = radius
    runs.axis[run] = axis
    runs.alike[run] = wp.cos(wp.min(spread + wp.acos(clusters.chosen.normal_threshold) + ROUNDING, PI))


def allocate_runs(cluster_count: int, device: wp.Device) -> ClusterRunBounds:
    """ClusterRunBounds of `cluster_count` clusters."""
    runs: ClusterRunBounds = allocate(ClusterRunBounds, -(-cluster_count // int(PER_RUN)), device)
    return runs


def bound_runs(clusters: Representatives, runs: ClusterRunBounds) -> None:
    """Fill in the bounds of `runs` for where `clusters` are now."""
    launch(bound_runs_kernel, len(runs.radius), [clusters, runs], runs.radius.device)


@wp.func
def stretched(clusters: Representatives, cluster: int, position: wp.vec3, normal: wp.vec3) -> float:
    """The distance of a cluster, far more where its normal is unlike."""
    distance = separation(clusters.chosen, position, normal, clusters.position[cluster], clusters.normal[cluster])
    alike = wp.dot(clusters.normal[cluster], normal) > clusters.chosen.normal_threshold
    return wp.where(alike, distance, distance + OTHER_NORMAL)


@wp.func
def nearest_in_runs(clusters: Representatives, runs: ClusterRunBounds, position: wp.vec3, normal: wp.vec3, guess: int,
                    lane: int, lanes: int) -> int:  # fmt: skip
    """The nearest of all clusters, the first of those as near, as gpu.clustering.nearest.nearest_of_all finds it.

    guess: a cluster in use; the nearer that is, the fewer are looked at. Each of the `lanes` (gpu.core.intrinsics) of a
    point looks at runs of its own.
    """
    best = guess
    best_distance = stretched(clusters, guess, position, normal)
    for run in range(lane, runs.radius.shape[0], lanes):
        radius = best_distance + runs.radius[run]
        if wp.dot(runs.axis[run], normal) < runs.alike[run]:
            radius += UNLIKE
        if runs.radius[run] >= 0.0 and radius >= 0.0 and wp.length_sq(runs.centre[run] - position) <= radius * radius:
            for cluster in range(run * PER_RUN, wp.min((run + 1) * PER_RUN, clusters.spacing.shape[0])):
                if clusters.spacing[cluster] > 0.0:
                    distance = stretched(clusters, cluster, position, normal)
                    if distance < best_distance or (distance == best_distance and cluster < best):
                        best_distance = distance
                        best = cluster
    return place_of_least(best_distance, best, lanes)
