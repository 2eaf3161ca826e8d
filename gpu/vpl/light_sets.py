"""The light of a scene that no camera changes: its emitters, VPLs and VPL clusters. Shared by renderers, made anew when
an edit changes it.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from weakref import WeakValueDictionary

import warp as wp

from gpu.core.device import alike, duplicate, overwrite
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import Emitters, emitters_after, emitters_of
from gpu.lights.light_table import LightTable, PowerCdf
from gpu.lights.path_light import PathLight, by_reach, same_surfaces
from gpu.vpl.light_reach import light_reach
from gpu.vpl.light_set import ROOM, LightSet, LightSetChoice, RunPart, VplMaker
from gpu.vpl.seen_paths import PathPlan, SeenPathEnds, SeenPilot, walked
from gpu.vpl.sun_importance import sun_maps_of, suns_of
from gpu.vpl.vpl_clusters import VplClusters

Progress = Callable[[str, float], None]
# VPLs kept per scene, in whole sets: enough for the sets of a still view's frames, few enough to bound memory: 0.8 GB.
KEPT_VPLS = 1 << 23
# And plans of light paths, of sets that differ by more than their seeds, as clients may ask for any number of them.
KEPT_PLANS = 64


def _run(name: str, part: Callable[[], None]) -> None:
    """Run a part of the making of a light set."""
    part()


class LightSets:
    """A scene's light sets by choice, and the table of its emitters. version: of its light, which edits change;
    surface_version: of what is lit, which edits of lights leave as it is.
    """

    def __init__(self, device_scene: DeviceScene) -> None:
        self._device_scene = device_scene
        self._sets: dict[LightSetChoice, LightSet] = {}
        # How many light paths there are, and what traces them as long as it has traced a set, of sets that differ by
        # their seed.
        self._paths: dict[LightSetChoice, PathPlan] = {}
        self._views: dict[bool, SceneData] = {}  # by whether they are Lambertian
        self._pilots: dict[int, SeenPilot] = {}  # by bounces
        self._makers: WeakValueDictionary[LightSetChoice, VplMaker] = WeakValueDictionary()
        self._made = wp.Event(device_scene.device) if device_scene.device.is_cuda else None
        self._open: LightSet | None = None
        self.version = self.surface_version = self._path_version = 0
        self._emitters: Emitters = emitters_of(device_scene)
        self._emitters.table.suns = sun_maps_of(device_scene, self._emitters.table)
        self._path_light = PathLight(device_scene, self._emitters.table.suns, light_reach)
        self.table: LightTable = by_reach(self._emitters.table, self._path_light.reach)
        self._walked = walked(device_scene)

    def follow(self, edited: DeviceScene) -> bool:
        """Have the scene become what `edited` (DeviceScene.edited) is, in the arrays that renderers read: whoever has
        made something of its light before finds another `version`.

        False, and nothing is changed, where `edited` needs arrays of other sizes or other kernels.
        """
        scene = self._device_scene
        emitters = emitters_after(self._emitters, scene, edited)
        table = emitters.table
        edited.settle()
        suns, moved = suns_of(edited.scene), edited.scene.vertices is not scene.scene.vertices
        same_suns = suns == suns_of(scene.scene) and not (moved and any(suns[0]))
        if not same_suns:
            table = duplicate(LightTable, table)
            table.suns = sun_maps_of(edited, table)
        else:
            table.suns = self.table.suns
        by_power, sampled = table.all_emitters, table.sampled
        drawn = self._path_light.of(edited, table, same_suns=same_suns)
        table = by_reach(table, self._path_light.reach if drawn is None else drawn.reach)
        if not (scene.can_become(edited) and alike(LightTable, self.table, table)):
            return False
        if not same_surfaces(scene.scene, edited.scene):
            self.surface_version += 1
            wp.copy(self._walked, walked(edited))
        self._path_light.become(edited.scene, drawn)
        scene.become(edited)
        overwrite(LightTable, self.table, table)
        resident = duplicate(LightTable, self.table)
        resident.all_emitters, resident.sampled = by_power, sampled
        self._emitters = Emitters(resident, emitters.powers)
        self.version += 1
        if drawn is not None:
            self._path_version = self.version
            self._paths.clear()
        return True

    @property
    def by_power(self) -> PowerCdf:
        """The choice among all emitters of `table` by their power alone."""
        return self._emitters.table.all_emitters

    def at(self, choice: LightSetChoice) -> LightSet:
        """The set of `choice`, which may have to be made (anew) by `renew`; the longest unused ones make room."""
        found = self._sets.pop(choice, None)
        if found is None:
            found = LightSet(choice, self._device_scene.device, self._path_light.shares)
            while self._sets and sum(kept.vpls for kept in self._sets) + choice.vpls > KEPT_VPLS:
                del self._sets[next(iter(self._sets))]
        self._sets[choice] = found
        return found

    def is_current(self, light_set: LightSet) -> bool:
        """Whether a set is of the scene's light as it is."""
        return light_set.version == self.version

    def renew(self, light_set: LightSet, progress: Progress, run: RunPart = _run) -> None:
        """Make a set of the scene's light as it is, mostly into the arrays that it has.

        run: runs the parts `pilot`, where nobody knows how many paths there are, `portals`, where that finds that light
        comes by such, `light`, which traces, `vpl-clusters` and `radiosity`, which what is found near field needs; or
        `relight`, where the paths are as they were.
        """
        was_current = self.is_current(light_set)
        with self._making():
            if not was_current and self.is_current(light_set):
                return  # it was made in the turn of another
            if was_current or light_set.path_version != self._path_version:
                self._make(light_set, progress, run)
            else:
                run("relight", light_set.relight)
                light_set.version = self.version

    def _make(self, light_set: LightSet, progress: Progress, run: RunPart) -> None:
        choice, scene = light_set.choice, self._view(light_set.choice)
        light_set.version = light_set.path_version = -1
        progress("tracing virtual point lights", 0.0)
        plan = self._plan(choice, scene, run)
        if plan.paths == 0:
            light_set.count = 0
        else:
            maker, count = self._trace(light_set, scene, plan, run)
            progress("clustering virtual point lights", 0.5)
            light_set.take(maker, count)
            run("vpl-clusters", light_set.make)
            run("radiosity", lambda: light_set.find_radiosity(scene))
        light_set.version, light_set.path_version = self.version, self._path_version
        progress("clustering virtual point lights", 1.0)

    def _view(self, choice: LightSetChoice) -> SceneData:
        """The scene as a set of `choice` sees it, in the arrays that stay when it becomes another."""
        if choice.lambertian not in self._views:
            view = self._device_scene.view(lambertian=choice.lambertian)
            self._views[choice.lambertian] = self._path_light.seen_by_paths(view)
        return self._views[choice.lambertian]

    def _plan(self, choice: LightSetChoice, scene: SceneData, run: RunPart) -> PathPlan:
        same, table = replace(choice, seed=0), self._path_light.table
        if table.count == 0:
            return PathPlan(0)
        if same not in self._paths:
            features = self._device_scene.features(lambertian=choice.lambertian)
            if choice.bounces not in self._pilots:
                self._pilots[choice.bounces] = SeenPilot(choice.bounces, self._walked)
            pilot = self._pilots[choice.bounces]
            pilot.go_through(None)
            run("pilot", lambda: pilot.trace(scene, table, features))
            plan = pilot.plan(choice.vpls)
            portals = pilot.find_portals(plan, scene, table)
            if portals is not None:
                pilot.go_through(portals)
                run("portals", lambda: pilot.trace(scene, table, features))
                plan = replace(pilot.plan(choice.vpls), portals=portals)
            self._paths[same] = plan
            if len(self._paths) > KEPT_PLANS:
                del self._paths[next(iter(self._paths))]
        return self._paths[same]

    def _trace(self, light_set: LightSet, scene: SceneData, plan: PathPlan, run: RunPart) -> tuple[VplMaker, int]:
        """What has traced the light paths of a set, and how many VPLs they left."""
        choice, same = light_set.choice, replace(light_set.choice, seed=0)
        features = self._device_scene.features(lambertian=choice.lambertian)
        maker = self._makers.get(same)
        if maker is None or maker.ends.room < plan.paths or (maker.ends.whole and not plan.keeps_all):
            maker = self._makers[same] = self._maker(choice, plan, choice.vpls)
        ends = maker.ends
        light_set.trace_by(maker)
        ends.follow(plan)
        table = self._path_light.table
        run("light", lambda: ends.trace(scene, table, light_set.seed, features))
        count = ends.count()
        if count > maker.room:
            maker = self._makers[same] = self._maker(choice, plan, count)
            light_set.trace_by(maker)
            maker.ends.follow(plan)
            maker.ends.trace(scene, table, light_set.seed, features)
        return maker, count

    def _maker(self, choice: LightSetChoice, plan: PathPlan, vpls: int) -> VplMaker:
        room = int(ROOM * plan.paths) + 1
        ends = SeenPathEnds(room, choice.bounces, self._walked, whole=plan.keeps_all)
        return VplMaker(choice, ends, int(ROOM * vpls) + 1)

    def clusters(self, choice: LightSetChoice, progress: Progress) -> VplClusters:
        """The clusters of `choice`, traced and clustered when they are not kept from before."""
        return self.made(choice, progress).clusters

    def made(self, choice: LightSetChoice, progress: Progress) -> LightSet:
        """The set of `choice`, made when it is not kept from before."""
        light_set = self.at(choice)
        if not self.is_current(light_set):
            self.renew(light_set, progress)
        return light_set

    def radiosity(self, light_set: LightSet) -> Any:
        """The radiosity (RadiosityCache) around the VPLs of a set, which has one."""
        if light_set.cache is None:
            choice, device_scene = light_set.choice, self._device_scene
            features = device_scene.features(lambertian=choice.lambertian)
            with self._making():
                lobes = features if features.reads_light else None
                light_set.add_radiosity(self._view(choice), lobes)
        return light_set.cache

    def leave_open(self, light_set: LightSet) -> None:
        """Have `settle` end what `renew` began: a part of it is launched later, before anybody else has the host. A set
        for which `settle` never comes is made anew.
        """
        self._open = light_set

    def settle(self) -> None:
        """All of the set that was left open is launched, if there is one."""
        if self._open is not None:
            self._open = None
            self._note_made()

    def wait_for_made(self) -> None:
        """Have what is launched from now on, maybe in another lane (gpu.core.lane), come after all that was made."""
        if self._open is not None:
            self._open.version = self._open.path_version = -1
            self._open = None
        if self._made is not None:
            wp.get_stream(self._device_scene.device).wait_event(self._made)

    def _note_made(self) -> None:
        if self._made is not None:
            wp.get_stream(self._device_scene.device).record_event(self._made)

    @contextmanager
    def _making(self) -> Iterator[None]:
        """Sets share what their making works with, so one is made after the other, in whatever lanes and turns."""
        # On a CPU others may have turns within a launch.
        with DEVICE_SHARING.keep() if self._made else DEVICE_SHARING.holding(self):
            self.wait_for_made()
            yield
            self._note_made()
