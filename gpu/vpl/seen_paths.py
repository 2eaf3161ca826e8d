"""More light paths than VPLs need, of which those are kept by chance that matter to what the cameras see: of a room
next door, whose light comes in by a door that is ajar, most would light nothing that is seen, and light from a plain
outside would come in by few paths that carry hundreds of times as much as others.

What is kept by a chance carries the more, so that the light is right in the mean (I. Georgiev and P. Slusallek, Simple
and Robust Iterative Importance Sampling of Virtual Point Lights, 2010).
"""

from dataclasses import dataclass
from math import inf

import numpy as np
import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import connected
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls
from gpu.lights.light_table import LightTable
from gpu.lights.path_ends import PILOT_PATHS, PathEnds, paths_that_leave
from gpu.lights.portals import Portals
from gpu.sampling.sobol import hashed
from gpu.scene.types import Doubles
from gpu.vpl.camera_walks import WalkVertex, has_ended, walk_from_cameras
from gpu.vpl.portal_search import PortalFinder


@wp.struct
@dataclass
class SeenParameters:
    """rays: from each VPL to vertices of walks; together: so many neighbours share what these find, where a VPL's own
    find no more; enough: the share of the vertices that matters as much as all of them; least: what a VPL that lights
    none matters beside those, since other views may see what it lights; most: times as many paths as VPLs need are
    traced; wanted: the part of the VPLs that should count, where all carried alike it would be 1; even: the part of
    them that is kept whatever it carries, since what is near is told by how dense they lie.
    """

    rays: int = 2
    together: int = 32
    enough: float = 0.125
    least: float = 0.1
    most: float = 4.0
    wanted: float = 0.5
    even: float = 0.5


SEEN_PARAMETERS: SeenParameters = parameters(SeenParameters)
# Walks from the cameras and their vertices: those by which portals are found, and the first, which tell all else.
ALL_WALKS, ALL_VERTICES = 16_384, 3
WALKS, LENGTH = 8192, 2
# As for `chance`, of which none is less than 1, however rounded.
KEEPS_ALL = wp.vec2(2.0 / SEEN_PARAMETERS.least, inf)
# More paths are traced where at least so many times as many are worth it.
LEAST_MORE = 2.5
# Of paths for each VPL that is wanted, each of which takes memory.
MOST_PATHS = 16


@made_for("part_glass")
def seen_vertices_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def seen_vertices_kernel(first: int, scene: SceneData, order: wp.array[int], filled: wp.array[int], vpls: Vpls,
                             vertices: wp.array2d[WalkVertex], chosen: SeenParameters,
                             lit: wp.array[int]) -> None:  # fmt: skip
        """One thread a place in `order`: how many of `rays` vertices of walks its VPL lights, lit (place,)."""
        scene = specialise(scene)
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

    return seen_vertices_kernel


@wp.kernel
def sees_kernel(first: int, vertices: wp.array2d[WalkVertex], sees: wp.array[int]) -> None:
    """One thread a walk: sees (1,) becomes 1 where one has come anywhere, 0 before."""
    if not has_ended(vertices[first + wp.tid(), 0]):
        sees[0] = 1


@wp.kernel
def worth_kernel(first: int, order: wp.array[int], filled: wp.array[int], vpls: Vpls, chosen: SeenParameters,
                 lit: wp.array[int], carried: wp.array[float], worth: wp.array[float]) -> None:  # fmt: skip
    """One thread a place in `order`: what its VPL carries [W], and that less where it matters little, (place,) each.

    Light of many VPLs has the least variance where each is kept by the root of its squared light's mean.
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
    matters = wp.clamp(wp.sqrt(share / chosen.enough), chosen.least, 1.0)
    carried[place] = brightness(vpls.flux[order[place]])
    worth[place] = carried[place] * matters


@wp.func
def chance(kept: wp.vec2, carried: float, worth: float) -> float:
    """That with which a VPL is kept that carries so much and is worth so much [W]; kept: as PathPlan.even and worth."""
    return wp.min(kept[0] * worth / carried + worth / kept[1], 1.0)


@wp.kernel
def thin_out_kernel(first: int, order: wp.array[int], filled: wp.array[int], together: int, carried: wp.array[float],
                    worth: wp.array[float], kept: wp.array[wp.vec2], seeds: wp.array[int],
                    vpls: Vpls) -> None:  # fmt: skip
    """One thread a place in `order`: takes the flux of VPLs that are left out, and gives more to those kept.

    carried, worth (place,): of `worth_kernel`; kept (1,): as for `chance`; seeds (1,).
    """
    place = first + wp.tid()
    if place >= filled[0]:
        return
    by = chance(kept[0], carried[place], worth[place])
    if by < 1.0:
        # Chances of neighbours add up to whole numbers of VPLs as evenly as they can.
        begin = place // together * together
        along = float(hashed(wp.uint32(begin) ^ hashed(wp.uint32(seeds[0]))) >> wp.uint32(8)) * wp.static(0.5**24)
        for other in range(begin, place):
            along += chance(kept[0], carried[other], worth[other])
        vpl = order[place]
        if wp.floor(along + by) > wp.floor(along):
            vpls.flux[vpl] = vpls.flux[vpl] / by
        else:
            vpls.flux[vpl] = wp.vec3(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class PathPlan:
    """How many light paths there are, and with which chance their VPLs are kept: `even` for each that matters, and
    besides what its worth is of `worth` [W]. portals: that paths are drawn through.
    """

    paths: int
    even: float = 1.0
    worth: float = inf
    portals: "Portals | None" = None

    @property
    def keeps_all(self) -> bool:
        """Whether VPLs are kept without a look at them."""
        return self.worth == inf


class SeenPathEnds(PathEnds):
    """Path ends that are thinned out by what they are worth, unless they are to be `whole`.

    carried, worth (place,): of `worth_kernel`.
    """

    def __init__(self, room: int, bounces: int, vertices: wp.array, *, whole: bool) -> None:
        """As PathEnds; `vertices` (walk, vertex): of `walked`."""
        super().__init__(room, bounces, vertices.device, arriving=False)
        self.whole, self._vertices = whole, vertices[:WALKS, :LENGTH] if vertices.size else vertices
        capacity = 0 if whole else self.capacity
        self._lit = wp.zeros(capacity, dtype=int, device=self.device)
        self.carried, self.worth = (wp.zeros(capacity, dtype=float, device=self.device) for _ in range(2))
        self._kept = wp.full(1, KEEPS_ALL, dtype=wp.vec2, device=self.device)

    def follow(self, plan: PathPlan) -> None:
        """Have so many paths, and keep so many of their VPLs, from now on; all are kept before. Those that are `whole`
        follow no plan by which some are left out.
        """
        self.set_paths(plan.paths)
        self.go_through(plan.portals)
        if not self.whole:
            self._kept.fill_(KEEPS_ALL if plan.keeps_all else wp.vec2(plan.even, plan.worth))

    def trace(self, scene: SceneData, table: LightTable, seed: wp.array, features: SceneFeatures) -> None:
        """Trace new paths by `seed` (1,), and thin out what they leave."""
        super().trace(scene, table, seed, features)
        if not self.whole:
            self.find_worth(scene)
            inputs = [self.order, self.filled, SEEN_PARAMETERS.together, self.carried, self.worth, self._kept, seed]
            launch(thin_out_kernel, self.capacity, [*inputs, self.raw], self.device)
            self.put_in_order()

    def find_worth(self, scene: SceneData) -> None:
        """Find what is worth what of what was traced."""
        places, chosen = [self.order, self.filled, self.raw], SEEN_PARAMETERS
        inputs = [scene, *places, self._vertices, chosen, self._lit]
        launch(seen_vertices_kernel(part_glass_of(scene)), self.capacity, inputs, self.device)
        launch(worth_kernel, self.capacity, [*places, chosen, self._lit, self.carried, self.worth], self.device)


def walked(device_scene: DeviceScene) -> wp.array:
    """Where walks from the cameras of `device_scene` come, (walk, vertex) of WalkVertex; empty without a camera."""
    if not device_scene.scene.cameras:
        return wp.zeros((0, ALL_VERTICES), dtype=WalkVertex, device=device_scene.device)
    return walk_from_cameras(device_scene, device_scene.view(lambertian=False), ALL_WALKS, ALL_VERTICES)


class SeenPilot:
    """Runs of a few light paths, which tell how many there should be, and what they are to go through."""

    def __init__(self, bounces: int, vertices: wp.array) -> None:
        """vertices: of `walked`."""
        self._vertices, self._finder = vertices, PortalFinder(vertices)
        self._ends = SeenPathEnds(PILOT_PATHS, bounces, vertices, whole=vertices.size == 0)
        self._carried, self._worth = StagingBuffer(self._ends.carried), StagingBuffer(self._ends.worth)
        # Whether walks from the cameras come anywhere, so that they can tell what is worth more.
        self._sees = StagingBuffer(wp.zeros(1, dtype=int, device=vertices.device))

    def trace(self, scene: SceneData, table: LightTable, features: SceneFeatures) -> None:
        """Trace them, and have what they leave on its way to the host."""
        ends = self._ends
        PathEnds.trace(ends, scene, table, ends.no_seed, features)
        if not ends.whole:  # kernels are to be noted where nothing is run, and so nothing seen
            ends.find_worth(scene)
            self._sees.array.zero_()
            launch(sees_kernel, len(self._vertices), [self._vertices, self._sees.array], ends.device)
            for found in (self._carried, self._worth, self._sees):
                found.download()

    def go_through(self, portals: "Portals | None") -> None:
        """Have paths drawn through these from now on."""
        self._ends.go_through(portals)

    def find_portals(self, plan: PathPlan, scene: SceneData, table: LightTable) -> "Portals | None":
        """Portals for what comes into view by few of a plan's paths; None where there are none, or most matter."""
        # Kernels are to be noted where nothing is run, and so nothing seen.
        if self._ends.whole or (plan.keeps_all and self._sees.host[0]):
            return None
        return self._finder.find(scene, table)

    def plan(self, wanted: int) -> PathPlan:
        """What leaves about `wanted` VPLs by what `trace` has found. The host waits for the device's current stream."""
        ends, count = self._ends, self._ends.count()
        paths = paths_that_leave(wanted, count / ends.room, MOST_PATHS)
        if not self._sees.host[0]:
            return PathPlan(paths)
        carried, worth = (each.host[:count].astype(np.float64) for each in (self._carried, self._worth))
        more = min(paths_worth_tracing(carried, worth), MOST_PATHS * wanted / paths)
        if more < LEAST_MORE:
            return PathPlan(paths)
        made = round(more * paths)
        # Each path carries less than one of the pilot, and there are more of each kind.
        as_many, even = made / ends.room, SEEN_PARAMETERS.even / more
        return PathPlan(made, even, worth_kept(carried / as_many, worth / as_many, even, wanted / as_many))


def paths_worth_tracing(carried: Doubles, worth: Doubles) -> float:
    """How many times as many paths should be traced as are needed for VPLs that carry and are worth so much, (vpl,)
    each [W]: the more, the fewer have most of the worth, and the less of what they carry matters.
    """
    whole, chosen = float(worth.sum()), SEEN_PARAMETERS
    if whole == 0.0:
        return 1.0
    counting = whole**2 / (len(worth) * float((worth**2).sum()))
    return min(max(chosen.wanted / counting, float(carried.sum()) / whole), chosen.most)


def worth_kept(carried: Doubles, worth: Doubles, even: float, wanted: float) -> float:
    """The `worth` of a PathPlan, beside its `even`, by which about `wanted` are left of VPLs that carry and are worth
    so much, (vpl,) each [W].
    """
    least, most = float(worth.min()) * 1e-3, float(worth.max()) * 1e3
    for _ in range(48):
        middle = (least * most) ** 0.5
        left = np.minimum(even * worth / carried + worth / middle, 1.0).sum()
        least, most = (middle, most) if left > wanted else (least, middle)
    return middle
