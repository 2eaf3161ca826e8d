"""Algorithm 2 of the 2022 paper: each SP belongs to its F nearest clusters.

Where no representative is near and of like orientation (thin, curved or small parts), the search widens, then relaxes
the normal. What is then still unserved takes the nearest cluster of all. How badly an SP is served, its deficit, tells
where new clusters are to come (gpu.sp.seeding).
"""

from dataclasses import dataclass
from functools import cache

import warp as wp

from gpu.clustering.grid import Representatives, level_of
from gpu.clustering.nearest import nearest_of_some, nearest_search
from gpu.core.parameters import parameters
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.sp.budget import WHOLE_DEFICIT, ClusterBudget, SpClusterParameters, cluster_spacing
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT, UNSERVED_DEFICIT, SpClusters

# Of a thread, which waits for memory most of the time: so that many wait at once.
REGISTERS = 112


@wp.struct
@dataclass
class DeficitParameters:
    """The deficit of an SP that is `d` spacings from its nearest representative: steps · (d − accepted), 0 to `most`.

    accepted_distance: 0 for that of the walk's budget; unlike: at least, where none near has a like normal; unserved:
    where there is none near at all.
    """

    steps: float = 16.0
    accepted_distance: float = 1.0
    most: int = 255
    unlike: int = 0
    unserved: int = int(UNSERVED_DEFICIT)


# How badly the SPs of a frame are served.
DEFICIT_IN_FRAME: DeficitParameters = parameters(DeficitParameters)
# How much of its share of a cluster an SP lacks. Where few are free, they are for SPs that are far from all, and most
# for those that none serves.
DEFICIT_TO_FILL: DeficitParameters = parameters(
    DeficitParameters,
    steps=64.0,
    accepted_distance=0.0,
    most=2 * int(WHOLE_DEFICIT),
    unlike=2 * int(WHOLE_DEFICIT),
    unserved=8 * int(WHOLE_DEFICIT),
)


@wp.func
def deficit_of(scale: DeficitParameters, budget: ClusterBudget, distance: float, alike: bool) -> int:
    """The deficit of an SP whose nearest representative is so many spacings away; alike: their normals are."""
    accepted = scale.accepted_distance
    if accepted == 0.0:
        accepted = budget.accepted_distance[0]
    return wp.max(wp.clamp(int(scale.steps * (distance - accepted)), 0, scale.most), wp.where(alike, 0, scale.unlike))


@cache
def fuzzy_assignment_kernel(fuzziness: int, by_distance: bool) -> wp.Kernel:
    """The kernel of Algorithm 2 for F = `fuzziness`; its weights are 1/distance (Eq. 10) or equal (Eq. 8)."""
    search = nearest_search(fuzziness, widens=True)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=REGISTERS)
    def fuzzy_assignment_kernel(first: int, gbuffer: GBuffer, points: PointList, representatives: Representatives,
                                budget: ClusterBudget, chosen: SpClusterParameters, scale: DeficitParameters,
                                least_deficit: int, out: SpClusters) -> None:  # fmt: skip
        """One thread an SP: its F nearest clusters, their weights, and its deficit on the `scale`.

        least_deficit: SPs with less keep what they have; 0: none does, and those far from all clusters get none yet.
        The nearest cluster serves, whoever writes that.
        """
        sp = first + wp.tid()
        if sp >= points.count[0]:
            out.deficit[sp] = 0
            return
        if out.deficit[sp] < least_deficit:
            return
        pixel = points.pixels[sp]
        position = gbuffer.position[pixel]
        normal = gbuffer.normal[pixel]
        spacing = cluster_spacing(gbuffer, pixel, points, budget)
        nearest = search(representatives, position, normal, level_of(representatives.chosen, spacing))
        out.deficit[sp] = scale.unserved
        if nearest.cluster[0] < 0 and least_deficit > 0:
            # Few SPs come here; any cluster is better than none, and they are the first to be refined. One that looked
            # at all clusters would keep the others waiting.
            extent = budget.extent[0]
            nearest.cluster[0] = nearest_of_some(representatives, extent, position, normal, chosen.sparse_search)
            nearest.distance[0] = spacing
            if nearest.cluster[0] < 0:
                out.deficit[sp] = UNASSIGNED_DEFICIT
        elif nearest.cluster[0] >= 0:
            out.deficit[sp] = deficit_of(scale, budget, nearest.distance[0] / spacing, nearest.alike)
        if nearest.cluster[0] >= 0:
            out.serving[nearest.cluster[0]] = 1
        total = float(0.0)
        for f in range(wp.static(fuzziness)):
            weight = float(0.0)
            if nearest.cluster[f] >= 0:
                weight = 1.0
                if wp.static(by_distance):
                    weight = spacing / wp.max(nearest.distance[f], chosen.exact_match * spacing)
            nearest.distance[f] = weight
            total += weight
        for f in range(wp.static(fuzziness)):
            out.cluster[f, sp] = wp.max(nearest.cluster[f], 0)
            out.weight[f, sp] = nearest.distance[f] / wp.max(total, 1.0e-20)

    return fuzzy_assignment_kernel
