"""Finds portals (gpu.lights.portals): a few small strips through which much of the light comes into view.

Light's ways are those of random walks from the cameras (gpu.vpl.camera_walks), back from where a sample of an emitter
lights a vertex. A way comes into view at its first point that is seen from two thirds as many of the walks' first
vertices as any of its points: the sky's in a window, those out of a room next door in the gap of the door.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from gpu.core.device import launch, layout_of, struct_array
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import connected
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.lights.light_table import DIRECTIONAL, LightTable
from gpu.lights.portals import MOST_PORTALS, Portal, Portals
from gpu.sampling.sobol import hashed
from gpu.scene.types import Doubles, Floats, Ints, Mask
from gpu.vpl.camera_walks import WalkVertex, has_ended
from gpu.vpl.emitter_importance import lit_vertex_kernel


@wp.struct
@dataclass
class PortalSearch:
    """ways: that are looked at, and so many `followed` of those that begin out of view; brightest: times the mean light
    of vertices that are lit is the most that counts of one; looks: from each point of a way at vertices, and the share
    `seen` of the most that its way has, from which on it is in view; step: between points, in the median length of
    walks' first ways, which is searched again in `finer` ones; farthest: steps from the end of a line; radius: of what
    one portal is for, margin: how far it reaches beyond that, narrowly a tenth [steps]; least: ways by each portal;
    share: of all ways by all portals together.
    """

    ways: int = 2048
    followed: int = 512
    brightest: float = 4.0
    looks: int = 16
    seen: float = 0.65
    step: float = 0.1
    finer: int = 8
    farthest: int = 64
    radius: float = 3.0
    margin: float = 0.6
    least: int = 3
    share: float = 0.2


PORTAL_SEARCH: PortalSearch = parameters(PortalSearch)


@made_for("part_glass")
def in_view_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def in_view_kernel(first: int, scene: SceneData, points: wp.array[wp.vec3], vertices: wp.array2d[WalkVertex],
                       looks: int, seen: wp.array[int]) -> None:  # fmt: skip
        """One thread a point in the air: from how many of so many first vertices of walks it is seen, seen (point,).

        vertices (walk, vertex).
        """
        scene = specialise(scene)
        point = first + wp.tid()
        found = int(0)
        for look in range(looks):
            draw = int(hashed(wp.uint32(looks * point + look)) >> wp.uint32(1))
            vertex = vertices[draw % vertices.shape[0], 0]
            if not has_ended(vertex):
                in_air = wp.vec3(0.0, 0.0, 0.0)
                found += int(connected(scene, vertex.position, vertex.normal, points[point], in_air))
        seen[point] = found

    return in_view_kernel


@dataclass(frozen=True)
class Ways:
    """Ways of light, backwards: corners (way, corner, 3) from where a walk begins, of which the first `count` (way,)
    are its own.
    """

    corners: Floats
    count: Ints

    def taken(self, which: Ints) -> "Ways":
        """Some of them."""
        return Ways(self.corners[which], self.count[which])


@dataclass(frozen=True)
class WayPoints:
    """Points on ways in the order of light: place (point, 3), the direction of light there `along` (point, 3), and
    whose they are: way (point,).
    """

    place: Floats
    along: Floats
    way: Ints

    def taken(self, which: Ints) -> "WayPoints":
        """Some of them."""
        return WayPoints(self.place[which], self.along[which], self.way[which])


class PortalFinder:
    """Finds portals by walks."""

    def __init__(self, vertices: wp.array, chosen: PortalSearch = PORTAL_SEARCH) -> None:
        """`vertices` (walk, vertex): of `walk_from_cameras`."""
        self._vertices, self._chosen, self._device = vertices, chosen, vertices.device
        self._emitter, self._worth, self._point = (
            wp.zeros(vertices.shape, dtype=dtype, device=self._device) for dtype in (int, float, wp.vec3)
        )

    def find(self, scene: SceneData, table: LightTable) -> "Portals | None":
        """Portals for the light of `table`; None where little comes into view by such."""
        chosen = self._chosen
        self._worth.zero_()
        inputs = [scene, table, self._vertices, self._emitter, self._worth, self._point]
        launch(lit_vertex_kernel(part_glass_of(scene)), self._vertices.size, inputs, self._device)
        vertices = self._vertices.numpy()
        step = chosen.step * free_path(vertices[: chosen.ways])
        if step == 0.0:  # of what is seen nothing sees anything else
            return None
        ways = self._ways(vertices["position"], table)
        begins, ends = np.split(self._views(scene, ends_of(ways, step, chosen.farthest).reshape(-1, 3)), 2)
        out_of_view = np.flatnonzero(begins < chosen.seen * ends).astype(np.int32)
        followed = min(len(out_of_view), chosen.followed)
        if followed == 0:
            return None
        taken = out_of_view[np.arange(followed) * len(out_of_view) // followed]
        points = points_on(ways.taken(taken), step, chosen.farthest)
        views = self._views(scene, points.place)
        most = np.zeros(followed, np.int32)
        np.maximum.at(most, points.way, views)
        enough = np.asarray(chosen.seen * most[points.way], np.float64)
        come = first_in_view(points.way, views >= enough)
        if len(come) == 0:
            return None
        place = self._finer(scene, points.taken(come), step, enough[come])
        return self._portals(place, points.along[come], step, chosen.ways * followed / len(out_of_view))

    def _views(self, scene: SceneData, places: Floats) -> Ints:
        """From how many of `looks` vertices each of `places` (point, 3) is seen, (point,)."""
        views = wp.zeros(len(places), dtype=int, device=self._device)
        points = wp.array(places, dtype=wp.vec3, device=self._device)
        inputs = [scene, points, self._vertices, self._chosen.looks, views]
        launch(in_view_kernel(part_glass_of(scene)), len(places), inputs, self._device)
        return np.asarray(views.numpy())

    def _ways(self, vertices: Floats, table: LightTable) -> Ways:
        """As many of each light as it brings to vertices (walk, vertex, 3). Suns' own lines are left out, since their
        paths have maps.
        """
        chosen, worth = self._chosen, self._worth.numpy().astype(np.float64)
        if not worth.any():
            return Ways(np.zeros((0, 2, 3), np.float32), np.zeros(0, np.int32))
        ends = np.cumsum(np.minimum(worth, chosen.brightest * worth[worth > 0.0].mean()))
        drawn = np.searchsorted(ends, (np.arange(chosen.ways) + 0.5) / chosen.ways * ends[-1])
        walk, last = np.divmod(drawn, worth.shape[1])
        corners = np.zeros((chosen.ways, worth.shape[1] + 1, 3), np.float32)
        corners[:, :-1] = vertices[walk]
        corners[np.arange(chosen.ways), last + 1] = self._point.numpy()[walk, last]
        light = self._emitter.numpy()[walk, last] - table.triangle_count - table.sky_count
        by_sun = (light >= 0) & (table.lights.numpy()["kind"][np.maximum(light, 0)] == DIRECTIONAL)
        count = np.asarray(last + np.where(by_sun, 1, 2), np.int32)
        return Ways(corners[count > 1], count[count > 1])

    def _finer(self, scene: SceneData, points: WayPoints, step: float, enough: Doubles) -> Floats:
        """Where within the last `step` before `points`, which are seen by `enough` (point,), ways come into view."""
        finer = self._chosen.finer
        back = np.arange(finer, dtype=np.float32)[::-1] * np.float32(step / finer)
        places = points.place[:, None] - points.along[:, None] * back[:, None]
        views = self._views(scene, places.reshape(-1, 3)).reshape(-1, finer)
        return np.asarray(places[np.arange(len(places)), (views >= enough[:, None]).argmax(axis=1)])

    def _portals(self, place: Floats, along: Floats, step: float, ways: float) -> "Portals | None":
        """For those of so many ways that come into view at `place` in the direction `along`, (way, 3) each."""
        chosen, strips = self._chosen, np.zeros(MOST_PORTALS, layout_of(Portal))
        offset = (place - place.mean(axis=0)) / np.float32(chosen.radius * step)
        square = (offset**2).sum(axis=1)
        near = square[:, None] + square - 2.0 * offset @ offset.T < 1.0
        counted, left, count = near.astype(np.float32), np.ones(len(place), bool), 0
        while count < MOST_PORTALS:
            together = counted @ left.astype(np.float32)
            if together.max() < chosen.least:
                break
            own = near[int(together.argmax())] & left
            strips[count] = strip_of(place[own], along[own], chosen.margin * step)
            left, count = left & ~own, count + 1
        if np.count_nonzero(~left) < chosen.share * ways:
            return None
        strips["chance"] /= strips["chance"].sum()
        portals = Portals()
        portals.count = wp.array([count], dtype=int, device=self._device)
        portals.strips = struct_array(Portal, strips, self._device)
        return portals


def free_path(vertices: Any) -> float:
    """The median length of walks' first ways, in unit space, of WalkVertex (walk, vertex); 0 where there is none."""
    both = vertices["normal"][:, :2].any(axis=2).all(axis=1)
    ways = vertices["position"][both, 1] - vertices["position"][both, 0]
    return float(np.median(np.linalg.norm(ways, axis=1))) if len(ways) else 0.0


def ends_of(ways: Ways, step: float, farthest: int) -> Floats:
    """Points half a step behind where light begins, or no more than `farthest` steps from the end of its first line,
    and half a step before it arrives, (2, way, 3).
    """
    every, corners = np.arange(len(ways.count)), ways.corners
    begin, towards = corners[every, ways.count - 1], corners[every, ways.count - 2]
    points = []
    for near, far, back in ((towards, begin, farthest - 0.5), (corners[:, 0], corners[:, 1], 0.5)):
        length = np.linalg.norm(far - near, axis=1)
        along = np.minimum(back * step, np.maximum(length - 0.5 * step, 0.5 * length)) / np.maximum(length, 1e-12)
        points.append(near + (far - near) * along[:, None])
    return np.asarray(points, np.float32)


def points_on(ways: Ways, step: float, farthest: int) -> WayPoints:
    """Points `step` from each other, and no more than `farthest` steps from the end of each line between corners."""
    lines = (np.arange(1, ways.corners.shape[1]) < ways.count[:, None])[:, ::-1]
    begin, end = ways.corners[:, :0:-1][lines], ways.corners[:, -2::-1][lines]
    length = np.linalg.norm(end - begin, axis=1)
    along = (end - begin) / np.maximum(length, 1e-12)[:, None]
    back = (np.arange(farthest, dtype=np.float32)[::-1] + np.float32(0.5)) * np.float32(step)
    line, point = np.nonzero(back < length[:, None])
    place, way = end[line] - along[line] * back[point][:, None], np.nonzero(lines)[0][line]
    return WayPoints(place, along[line], way.astype(np.int32))


def first_in_view(way: Ints, seen: Mask) -> Ints:
    """Which points come into view, of those in the order of `way` (point,): the first of each way that is `seen`,
    unless that begins there.
    """
    begins = np.append(True, way[1:] != way[:-1])[: len(way)]
    before: Ints = (np.cumsum(seen) - seen).astype(np.int32)
    at_begin: Ints = before[np.maximum.accumulate(np.where(begins, np.arange(len(way)), 0))]
    return np.flatnonzero(seen & ~begins & (before == at_begin)).astype(np.int32)


def strip_of(place: Floats, along: Floats, margin: float) -> tuple[Any, ...]:
    """A row of Portal for ways that come into view at `place` in the direction `along`, (way, 3) each; its chance is
    how many they are.
    """
    centre, axis = place.mean(axis=0), along.mean(axis=0)
    axis = axis / max(float(np.linalg.norm(axis)), 1e-6)
    offset = place - centre
    half = np.linalg.eigh(offset.T @ offset)[1][:, 2]
    across = np.cross(axis, half)
    across = across / max(float(np.linalg.norm(across)), 1e-6)
    # Of what lies evenly on a rectangle.
    length, width = (float(np.sqrt(3.0 * np.mean((offset @ way) ** 2))) for way in (half, across))
    return centre, axis, half * (length + margin), width + 0.1 * margin, width + margin, len(place)
