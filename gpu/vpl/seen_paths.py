"""Light paths of whose VPLs fewer are kept where little of what the cameras see is lit by them, so that more are where
it is: of a room next door, whose light comes in by a door that is ajar, most would light nothing that is seen.

By chance, and what is kept carries more, so that the light is right in the mean (I. Georgiev and P. Slusallek, Simple
and Robust Iterative Importance Sampling of Virtual Point Lights, 2010).
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import connected
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import PILOT_PATHS, PathEnds, Vpls, paths_that_leave
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import hashed
from gpu.vpl.camera_walks import WalkVertex, has_ended, walk_from_cameras


@wp.struct
@dataclass
class SeenParameters:
    """rays: from each VPL to vertices of walks; together: so many neighbours share what these find, where a VPL's own
    find no more; enough: who lights this share of the vertices is always kept; least: of VPLs that light none, this
    share is kept, since other views may see what they light.
    """

    rays: int = 2
    together: int = 32
    enough: float = 0.125
    least: float = 0.1


SEEN_PARAMETERS: SeenParameters = parameters(SeenParameters)
WALKS, LENGTH = 8192, 2
# VPLs are thinned out where no more than this share of them would be left.
MOST_LEFT = 0.5


@wp.kernel
def seen_vertices_kernel(first: int, scene: SceneData, order: wp.array[int], filled: wp.array[int], vpls: Vpls,
                         vertices: wp.array2d[WalkVertex], chosen: SeenParameters,
                         lit: wp.array[int]) -> None:  # fmt: skip
    """One thread a place in `order`: how many of `rays` vertices of walks its VPL lights, lit (place,)."""
    place = first + wp.tid()
    if place >= filled[0]:
        return
    vpl = order[place]
    found = int(0)
    for ray in range(chosen.rays):
        draw = int(hashed(wp.uint32(chosen.rays * place + ray)) >> wp.uint32(1))
        vertex = vertices[draw % vertices.shape[0], (draw // vertices.shape[0]) % vertices.shape[1]]
        if not has_ended(vertex):
            reached = connected(scene, vertex.position, vertex.normal, vpls.position[vpl], vpls.normal[vpl])
            found += int(reached)
    lit[place] = found


@wp.kernel
def thin_out_kernel(first: int, order: wp.array[int], filled: wp.array[int], chosen: SeenParameters, lit: wp.array[int],
                    seeds: wp.array[int], vpls: Vpls) -> None:  # fmt: skip
    """One thread a place in `order`: takes the flux of VPLs that are left out, and gives more to those kept.

    lit (place,): of `seen_vertices_kernel`; seeds (1,).
    """
    place = first + wp.tid()
    count = filled[0]
    if place >= count:
        return
    begin = place // chosen.together * chosen.together
    end = wp.min(begin + chosen.together, count)
    total = int(0)
    for other in range(begin, end):
        total += lit[other]
    share = float(wp.max(total, lit[place] * (end - begin))) / float(chosen.rays * (end - begin))
    kept = wp.clamp(wp.sqrt(share / chosen.enough), chosen.least, 1.0)
    if kept < 1.0:
        start = float(hashed(wp.uint32(begin) ^ hashed(wp.uint32(seeds[0]))) >> wp.uint32(8)) * wp.static(1.0 / 2.0**24)
        along = start + kept * float(place - begin)
        vpl = order[place]
        if wp.floor(along + kept) > wp.floor(along):
            vpls.flux[vpl] = vpls.flux[vpl] / kept
        else:
            vpls.flux[vpl] = wp.vec3(0.0, 0.0, 0.0)


class SeenPathEnds(PathEnds):
    """Path ends that may be thinned out where they light little of what walks from the cameras visit; thins: whether
    `trace` does so.
    """

    def __init__(self, room: int, bounces: int, vertices: wp.array, *, thins: bool) -> None:
        """As PathEnds; `vertices` (walk, vertex): of `walked`."""
        super().__init__(room, bounces, vertices.device, arriving=False)
        self.thins, self._vertices = thins, vertices
        self._lit = wp.zeros(self.capacity if thins else 0, dtype=int, device=self.device)

    def trace(self, scene: SceneData, table: LightTable, seed: wp.array, features: SceneFeatures) -> None:
        """Trace new paths by `seed` (1,), and thin out what they leave."""
        super().trace(scene, table, seed, features)
        if self.thins:
            self.thin_out(scene, seed)

    def thin_out(self, scene: SceneData, seed: wp.array) -> None:
        """Thin out what was traced by `seed` (1,)."""
        chosen = SEEN_PARAMETERS
        inputs = [scene, self.order, self.filled, self.raw, self._vertices, chosen, self._lit]
        launch(seen_vertices_kernel, self.capacity, inputs, self.device)
        inputs = [self.order, self.filled, chosen, self._lit, seed, self.raw]
        launch(thin_out_kernel, self.capacity, inputs, self.device)
        self.put_in_order()


class SeenPilot:
    """Runs of a few light paths; thins: whether paths should be thinned out, as the last one has told."""

    def __init__(self, bounces: int, vertices: wp.array) -> None:
        """vertices: of `walked`."""
        self.thins, self._seen = False, vertices.size > 0
        self._ends = SeenPathEnds(PILOT_PATHS, bounces, vertices, thins=self._seen)

    def paths_for(self, wanted: int, scene: SceneData, table: LightTable, features: SceneFeatures) -> int:
        """How many light paths leave about `wanted` VPLs, thinned out where `thins` tells; none without light."""
        self.thins = False
        if table.count == 0:
            return 0
        ends = self._ends
        PathEnds.trace(ends, scene, table, ends.no_seed, features)
        whole = left = ends.count()
        if self._seen:
            ends.thin_out(scene, ends.no_seed)
            left = ends.count()
        self.thins = left <= MOST_LEFT * whole
        return paths_that_leave(wanted, (left if self.thins else whole) / ends.room)


def walked(device_scene: DeviceScene) -> wp.array:
    """Where walks from the cameras of `device_scene` come, (walk, vertex) of WalkVertex; empty without a camera."""
    if not device_scene.scene.cameras:
        return wp.zeros((0, LENGTH), dtype=WalkVertex, device=device_scene.device)
    return walk_from_cameras(device_scene, device_scene.data, WALKS, LENGTH)
