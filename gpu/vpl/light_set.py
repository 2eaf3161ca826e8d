"""A light set: VPL clusters and the radiosity around them, made anew in their arrays when the scene's light changes.

Steps 1 and 2 of the 2022 paper, section 3.1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import warp as wp

from gpu.core.device import launch
from gpu.core.stages import new_number
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.lights.light_paths import allocate_vpls
from gpu.lights.path_ends import gather_vpls_kernel
from gpu.vpl.build import no_clusters
from gpu.vpl.clustering import VplClustering
from gpu.vpl.group_lights import GroupLights
from gpu.vpl.radiosity_estimate import RadiosityBuilder
from gpu.vpl.seen_paths import SeenPathEnds
from gpu.vpl.vpl_clusters import VplClusters

# Runs a part of the making by name; the part launches the same each time that the set's `number` is the same.
RunPart = Callable[[str, Callable[[], None]], None]
# Arrays have room for this much more than is wanted, so that light that moves does not need others each time.
ROOM = 1.25


@dataclass(frozen=True)
class LightSetChoice:
    """What a light set depends on besides the scene."""

    vpls: int
    vpl_clusters: int
    bounces: int
    seed: int
    lambertian: bool


class VplMaker:
    """Finds VPLs and clusters them, with room for so many `vpls`; for sets that differ by their seeds.

    number: of its arrays, for captured graphs.
    """

    def __init__(self, choice: LightSetChoice, ends: SeenPathEnds, vpls: int) -> None:
        """ends: what traces the paths."""
        device = ends.device
        self.number, self.room, self.device, self.ends = new_number(), vpls, device, ends
        self.vpls = allocate_vpls(min(vpls, self.ends.capacity), device)
        self.clustering = VplClustering(self.vpls, self.ends.filled, choice.vpl_clusters, device)

    def cluster(self, lights: GroupLights, seed: int) -> None:
        """Make the lights of clusters of the VPLs that `ends` has found."""
        launch(gather_vpls_kernel, self.vpls.count, [self.ends.order, self.ends.raw, self.vpls], self.device)
        self.clustering.run(lights, seed)


class LightSet:
    """The VPL clusters of a `choice`. version: that of the scene's light, path_version: of its paths, −1 for none yet;
    count: of VPLs.
    """

    def __init__(self, choice: LightSetChoice, device: wp.Device, shares: wp.array) -> None:
        """`shares` (light,): as for GroupLights."""
        self.choice, self.device, self._shares = choice, device, shares
        self.version, self.path_version, self.count = -1, -1, 0
        self.seed = wp.full(1, choice.seed, dtype=int, device=device)
        self._filled = wp.zeros(1, dtype=int, device=device)
        self._maker: VplMaker | None = None
        self._lights: GroupLights | None = None
        self._radiosity: RadiosityBuilder | None = None
        self._none, self._number = no_clusters(), new_number()

    @property
    def clusters(self) -> VplClusters:
        """Them; none at all where nothing is lit."""
        return self._lights.vpls if self._lights and self.count else self._none

    @property
    def numbers(self) -> tuple[int, int]:
        """Of the arrays that it is made in, and that its making works with, for captured graphs."""
        return self._number, self._maker.number if self._maker else -1

    def trace_by(self, maker: VplMaker) -> None:
        """Have its light paths traced by `maker` next."""
        self._maker = maker

    def take(self, maker: VplMaker, count: int) -> None:
        """Have room for what `maker`, which has found `count` VPLs, makes next."""
        self.count = count
        if self._lights is None or len(self._lights.vpls.member_area) < maker.vpls.count:
            self._lights = GroupLights(maker.vpls.count, self.choice.vpl_clusters, self.device, shares=self._shares)
            self._radiosity, self._number = None, new_number()
        self._lights.vpls.members.count = count

    def make(self) -> None:
        """Fill the arrays of clusters with what the maker has found, without leaving the device."""
        if self._maker and self._lights:
            wp.copy(self._filled, self._maker.ends.filled)
            self._maker.cluster(self._lights, self.choice.seed)

    def find_radiosity(self, scene: SceneData) -> None:
        """Find the radiosity around the VPLs that `make` has clustered, if it was asked for."""
        if self._radiosity:
            self._radiosity.run(scene)

    def relight(self) -> None:
        """Have the flux follow the lights' shares, where the paths are as they were."""
        if self._lights:
            self._lights.relight()
        if self._radiosity:
            self._radiosity.relight()

    @property
    def cache(self) -> Any:
        """The radiosity around the VPLs (RadiosityCache), None where it was not asked for."""
        return None if self._radiosity is None else self._radiosity.cache

    def add_radiosity(self, scene: SceneData, lobes: SceneFeatures | None = None) -> None:
        """Find the radiosity around the VPLs, of which there must be one, too, now and whenever they are made.

        lobes: as for RadiosityBuilder.
        """
        self._radiosity = RadiosityBuilder(
            self.clusters, self.device, number=self._filled, usual=self.choice.vpls, lobes=lobes
        )
        self._number = new_number()
        self._radiosity.run(scene)
