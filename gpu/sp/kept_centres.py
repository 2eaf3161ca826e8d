"""Centres of shading clusters that a walk keeps, so that light does not flicker: 2009 paper, section 3.2, Temporal
Coherence.

A centre stays where it is as long as the view shows its surface there; new ones come where none that is kept serves.
The paper has a centre serve as far as its members lay in the frame before. Here it serves as far as seeds are apart in
this view, which adapts to a camera that comes nearer or goes away.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import ClusteringParameters, Grid, Representatives, level_of
from gpu.clustering.nearest import nearest_search
from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.core.image_size import ImageSize, image_size
from gpu.core.parameters import parameters
from gpu.core.radix_sort import running_total
from gpu.core.search import upper_bound
from gpu.device_scene.data import NO_HIT
from gpu.gbuffer.camera_rays import CameraData, pixel_of
from gpu.gbuffer.gbuffer import GBuffer, apparent_position
from gpu.gbuffer.point_list import PointList
from gpu.gbuffer.shading_points import ListedPoints
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.sp.centres import KeptCentres, ShadingClusters
from gpu.sp.reuse import is_visible_at
from gpu.sp.variation_tree import SeedingParameters, VariationTree, seeded_run

nearest_centre = nearest_search(1)
nearest_two = nearest_search(2)


@wp.struct
@dataclass
class KeepingParameters:
    """Distances are in spacings of seeds unless said otherwise.

    accepted: a centre serves points that are no farther from it, to begin with; it changes by max_change a frame at the
    most, between least_accepted and most_accepted, so that about a share `free` of all centres is left for what comes
    into view. crowded: in accepted distances, nearer than this, two centres are one too many. same_place: in spacings
    of pixels, nearer than this, a centre is seen where its pixel's SP is, whatever its normal.
    """

    accepted: float = 0.85
    least_accepted: float = 0.4
    most_accepted: float = 1.2
    crowded: float = 0.4
    free: float = 0.02
    max_change: float = 0.03
    same_place: float = 1.5


KEEPING_PARAMETERS: KeepingParameters = parameters(KeepingParameters)


def no_centres(most: int, device: wp.Device) -> KeptCentres:
    """Room for `most` centres."""
    kept: KeptCentres = allocate(KeptCentres, most, device)
    kept.accepted, kept.frames = wp.zeros(1, dtype=float, device=device), wp.zeros(1, dtype=int, device=device)
    return kept


@wp.struct
class KeepingWork:
    """What a frame only works with. unserved (sp,): 1 where no kept centre
    serves, else 0; pick (seed,): the SP at which a new centre is to be; wanted (seed,): 1 where there is one, else 0;
    free (cluster,): 1 for one that is not in use, else 0; wanted_sums, free_sums: running sums of these.
    """

    unserved: wp.array[int]
    pick: wp.array[int]
    wanted: wp.array[int]
    free: wp.array[int]
    wanted_sums: wp.array[int]
    free_sums: wp.array[int]


@wp.kernel
def keep_seen_kernel(first: int, cameras: wp.array[CameraData], image: ImageSize, gbuffer: GBuffer,
                     spacings: wp.array[float], alike: ClusteringParameters, chosen: KeepingParameters,
                     kept: KeptCentres, clusters: ShadingClusters) -> None:  # fmt: skip
    """One thread a cluster: has the kept centre, if its own pixel shows its surface, with its spacing in this view.

    spacings (pixel,): of seeds at its SP.
    """
    cluster = first + wp.tid()
    clusters.spacing[cluster] = 0.0
    if kept.used[cluster] == 0:
        return
    position = kept.position[cluster]
    normal = kept.normal[cluster]
    place = pixel_of(cameras[0], kept.apparent[cluster], image)
    if place[0] < 0 or place[1] < 0 or place[0] >= image.width or place[1] >= image.height:
        return
    pixel = place[1] * image.width + place[0]
    if gbuffer.face[pixel] == NO_HIT:
        return
    spacing = spacings[pixel]
    if is_visible_at(gbuffer, pixel, position, normal, spacing, chosen.same_place, alike):
        clusters.position[cluster] = position
        clusters.normal[cluster] = normal
        clusters.geometric_normal[cluster] = kept.geometric_normal[cluster]
        clusters.apparent[cluster] = kept.apparent[cluster]
        clusters.spacing[cluster] = spacing


@wp.kernel
def drop_crowded_kernel(first: int, chosen: KeepingParameters, kept: KeptCentres, centres: Representatives) -> None:
    """One thread a cluster: drops it where the nearest other one is too near to keep both; chance decides which."""
    cluster = first + wp.tid()
    spacing = centres.spacing[cluster]
    if spacing <= 0.0:
        return
    found = nearest_two(centres, centres.position[cluster], centres.normal[cluster], level_of(centres.chosen, spacing))
    other = found.cluster[0]
    distance = found.distance[0]
    if other == cluster:
        other = found.cluster[1]
        distance = found.distance[1]
    near = distance < chosen.crowded * kept.accepted[0] * spacing
    if other >= 0 and near and hashed(wp.uint32(other)) < hashed(wp.uint32(cluster)):
        centres.spacing[cluster] = 0.0


@wp.kernel
def find_unserved_kernel(first: int, points: Points, centres: Representatives, kept: KeptCentres,
                         unserved: wp.array[int]) -> None:  # fmt: skip
    """One thread an SP: whether no kept centre is near enough to serve it, unserved (sp,)."""
    sp = first + wp.tid()
    if sp >= points.count[0]:
        return
    spacing = points.spacing[sp]
    found = nearest_centre(centres, points.position[sp], points.normal[sp], level_of(centres.chosen, spacing))
    served = found.cluster[0] >= 0 and found.distance[0] <= kept.accepted[0] * spacing
    unserved[sp] = wp.where(served, 0, 1)


@wp.kernel
def pick_new_kernel(first: int, points: Points, chosen: SeedingParameters, tree: VariationTree, random: wp.array[int],
                    kept: KeptCentres, centres: Representatives, work: KeepingWork) -> None:  # fmt: skip
    """One thread a seed: picks an SP of its run that is not served.

    With the square of the probability that any is not, so that what is new as a whole has a centre before slivers have.
    """
    seed = first + wp.tid()
    work.wanted[seed] = 0
    work.free[seed] = wp.where(centres.spacing[seed] > 0.0, 0, 1)
    seeds = wp.min(work.pick.shape[0], points.count[0])
    if seed >= seeds:
        return
    run = seeded_run(chosen, points, tree, seeds, seed, 0, random[0])
    unserved = int(0)
    for sp in range(run.begin, run.end):
        unserved += work.unserved[sp]
    chance = hashed(wp.uint32(seed) ^ hashed(wp.uint32(random[0]) ^ hashed(wp.uint32(kept.frames[0]))))
    share = float(unserved) / float(wp.max(run.end - run.begin, 1))
    if float(chance) * TO_UNIT >= share * share:
        return
    left = int(hashed(chance) % wp.uint32(unserved))
    for sp in range(run.begin, run.end):
        if work.unserved[sp] == 1:
            if left == 0:
                work.pick[seed] = sp
            left -= 1
    work.wanted[seed] = 1


@wp.kernel
def place_new_kernel(first: int, gbuffer: GBuffer, listed: PointList, points: Points, work: KeepingWork,
                     clusters: ShadingClusters) -> None:  # fmt: skip
    """One thread a cluster: one that is not in use takes a picked SP; too many are thinned out evenly."""
    cluster = first + wp.tid()
    last = work.pick.shape[0] - 1
    picked = work.wanted_sums[last]
    if work.free[cluster] == 0 or picked == 0:
        return
    number = work.free_sums[cluster] - 1
    room = work.free_sums[last]
    if picked > room:
        number = int(wp.int64(number) * wp.int64(picked) / wp.int64(room))
    if number >= picked:
        return
    sp = work.pick[upper_bound(work.wanted_sums, last, number)]
    pixel = listed.pixels[sp]
    clusters.position[cluster] = gbuffer.position[pixel]
    clusters.normal[cluster] = gbuffer.normal[pixel]
    clusters.geometric_normal[cluster] = gbuffer.geometric_normal[pixel]
    clusters.apparent[cluster] = apparent_position(gbuffer, pixel)
    clusters.spacing[cluster] = points.spacing[sp]


@wp.kernel
def adapt_accepted_kernel(first: int, chosen: KeepingParameters, work: KeepingWork, kept: KeptCentres) -> None:
    """One thread in all: changes the accepted distance where too few or too many centres are left for others.

    A surface takes as many as it has squares of that side, so half of a change of their number is one of it.
    """
    last = work.pick.shape[0] - 1
    left = float(work.free_sums[last] - work.wanted_sums[last]) / float(last + 1)
    change = wp.clamp(0.5 * (chosen.free - left), -chosen.max_change, chosen.max_change)
    accepted = kept.accepted[0] * (1.0 + change)
    kept.accepted[0] = wp.clamp(accepted, chosen.least_accepted, chosen.most_accepted)
    kept.frames[0] += 1


@wp.kernel
def leave_centres_kernel(first: int, clusters: ShadingClusters, kept: KeptCentres) -> None:
    """One thread a cluster: leaves its centre to the next frame."""
    cluster = first + wp.tid()
    kept.position[cluster] = clusters.position[cluster]
    kept.normal[cluster] = clusters.normal[cluster]
    kept.geometric_normal[cluster] = clusters.geometric_normal[cluster]
    kept.apparent[cluster] = clusters.apparent[cluster]
    kept.used[cluster] = wp.where(clusters.spacing[cluster] > 0.0, 1, 0)


class CentreKeeping:
    """Has the centres of `clusters`, of SPs of a picture, go on from frame to frame; arrays are allocated once.

    grid: over the centres; listed, points, tree: of the SPs of a frame; pixel_spacing (pixel,): of seeds at its SP.
    """

    def __init__(
        self,
        listed: ListedPoints,
        points: Points,
        tree: VariationTree,
        seeding: SeedingParameters,
        grid: Grid,
        clusters: ShadingClusters,
        chosen: KeepingParameters = KEEPING_PARAMETERS,
    ) -> None:
        device = self.device = grid.device
        self._listed, self._points, self._tree, self._seeding = listed, points, tree, seeding
        self._grid, self._clusters, self._chosen = grid, clusters, chosen
        self._work: KeepingWork = allocate(KeepingWork, grid.capacity, device)
        self._work.unserved = wp.zeros(listed.capacity, dtype=int, device=device)
        self.pixel_spacing = wp.zeros(listed.capacity, dtype=float, device=device)

    def run(self, gbuffer: GBuffer, random: wp.array, kept: KeptCentres, camera: wp.array,
            size: tuple[int, int]) -> None:  # fmt: skip
        """Have those of the `kept` centres that `camera` (1,) sees in a picture of `size`, and new ones.

        random (1,): the frame's seed.
        """
        grid, clusters, chosen, work, device = self._grid, self._clusters, self._chosen, self._work, self.device
        data, most, points = grid.data, grid.capacity, self._points
        inputs = [camera, image_size(size), gbuffer, self.pixel_spacing, data.chosen, chosen, kept, clusters]
        launch(keep_seen_kernel, most, inputs, device)
        grid.build()
        launch(drop_crowded_kernel, most, [chosen, kept, data], device)
        grid.build()
        launch(find_unserved_kernel, self._listed.capacity, [points, data, kept, work.unserved], device)
        launch(pick_new_kernel, most, [points, self._seeding, self._tree, random, kept, data, work], device)
        running_total(work.wanted, work.wanted_sums)
        running_total(work.free, work.free_sums)
        launch(place_new_kernel, most, [gbuffer, self._listed.points, points, work, clusters], device)
        launch(adapt_accepted_kernel, 1, [chosen, work, kept], device)
        grid.build()
        self._leave(kept)

    def begin(self, kept: KeptCentres) -> None:
        """Have the next frame go on with the centres of this one, which has none from before."""
        kept.accepted.fill_(self._chosen.accepted)
        kept.frames.zero_()
        self._leave(kept)

    def _leave(self, kept: KeptCentres) -> None:
        launch(leave_centres_kernel, self._grid.capacity, [self._clusters, kept], self.device)
