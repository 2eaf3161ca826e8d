"""The caustic photon map: light that mirrors, glass and narrow lobes send on from emitters to other surfaces
(H. W. Jensen, Global Illumination using Photon Maps, 1996; 2009 paper, section 3.1).

It has all of the paths from emitters that end so, and the global map none of them. It is made on the device, and needs
to be made anew only where the light has changed or a frame wants photons of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, sqrt

import warp as wp

from gpu.core.device import RAY_REGISTERS, allocate, launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.disk_coverage import crossed
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.specialisation import made_for, masks_of, specialisation
from gpu.lights.caustic_casters import CausticCasters
from gpu.lights.caustic_paths import trace_caustic_paths
from gpu.lights.disk_grid import LEVELS, DiskGrid, DiskGridBuilder
from gpu.lights.light_table import LightTable
from gpu.lights.path_ends import PathEnds
from gpu.lights.photon_density import (
    DENSITY_PARAMETERS,
    NEIGHBOURS,
    DensityParameters,
    PhotonSites,
    allocate_sites,
    covered_disk,
    disk_places,
    neighbours,
)
from gpu.lights.photon_map import Photons, gather_photons_kernel
from gpu.lights.photon_tree import PhotonTree, allocate_tree, build_tree


@dataclass(frozen=True)
class CausticParameters:
    """How wide estimates may be.

    spread: area [unit area] that all photons would fill, were they as far apart as those of the widest estimate. Wider
    ones would carry light far beyond the edge of a caustic; narrower ones leave what is spread widely to few photons.
    wider: how many times as far as the photons nearest to a photon its disk reaches, if that is no wider than that.
    """

    spread: float = 4.0
    wider: float = 1.15


CAUSTIC_PARAMETERS = CausticParameters()


def widest_radius(paths: int) -> float:
    """Of estimates with so many light paths, unit space."""
    spread = CAUSTIC_PARAMETERS.spread
    return min(sqrt(NEIGHBOURS * spread / (pi * paths)), float(DENSITY_PARAMETERS.most_radius))


@made_for("masks", "alpha", "cutouts", "part_glass")
def photon_disk_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", cuda_max_registers=RAY_REGISTERS)
    def photon_disk_kernel(first: int, scene: SceneData, tree: PhotonTree, chosen: DensityParameters, wider: float,
                           sites: PhotonSites) -> None:  # fmt: skip
        """One thread a photon, of which there are enough for a GPU: the disk over which its light is spread, somewhat
        `wider` than that of the photons nearest to it. Its flux grows by what of that is no surface, where light is
        lost.
        """
        photon = first + wp.tid()
        scene = specialise(scene)
        sites.photon[photon] = photon
        if photon >= sites.count[0]:
            return
        photons = tree.photons
        position = photons.position[photon]
        normal = photons.normal[photon]
        found = neighbours(tree, sites.alike, photon, chosen.most_radius, 0, 1)
        radius = wider * found.radius
        radius = wp.clamp(radius, chosen.most_radius / float(1 << LEVELS), chosen.most_radius)
        disk = covered_disk(scene, sites.alike, position, normal, radius, disk_places(photon, tree.leaves), 0, 1)
        whole = disk.share == 1.0
        if whole:  # as far as places of the disk tell, between which thin walls stand
            whole = not crossed(scene, position, normal, radius, radius / sites.alike.plane_weight, 0, 1)
        sites.radius[photon] = radius
        sites.free[photon] = wp.where(whole, radius, 0.0)
        photons.flux[photon] = photons.flux[photon] / wp.max(disk.share, chosen.least_covered)

    return photon_disk_kernel


@wp.struct
class CausticLight:
    """What shading points read of a caustic map. sites: all photons, without irradiance; grid: of their disks; share
    (1,): of a disk's radius that counts.
    """

    tree: PhotonTree
    sites: PhotonSites
    grid: DiskGrid
    share: wp.array[float]


class CausticMap:
    """The caustic photons of `paths` light paths over at most `bounces` casters; `light` after `trace`. All
    is allocated once.
    """

    def __init__(self, paths: int, bounces: int, device: wp.Device) -> None:
        self._ends, self._bounces = PathEnds(paths, 1, device, arriving=True), bounces
        photons: Photons = allocate(Photons, paths, device)
        photons.count = self._ends.filled
        reach = widest_radius(paths)
        self._density: DensityParameters = parameters(DensityParameters, most_radius=reach)
        self.light = CausticLight()
        self.light.tree, self.light.sites = allocate_tree(photons), allocate_sites(paths, device)
        self.light.sites.count = photons.count
        self._disks = DiskGridBuilder(paths, reach, float(self.light.sites.alike.plane_weight), device)
        self.light.grid = self._disks.grid
        self.light.share = wp.ones(1, dtype=float, device=device)

    @property
    def count(self) -> wp.array:
        """How many photons there are, (1,)."""
        return self._ends.filled

    def trace(self, scene: SceneData, table: LightTable, casters: Sequence[CausticCasters], seed: wp.array,
              features: SceneFeatures) -> None:  # fmt: skip
        """Trace, sort and weigh new photons by `seed` (1,), of disks as narrow as the light's `share` says; there must
        be light and casters.
        """
        ends, light = self._ends, self.light
        trace_caustic_paths(scene, table, casters, self._bounces, seed, features, ends.raw)
        ends.put_in_order()
        launch(gather_photons_kernel, ends.room, [ends.order, ends.raw, light.tree.photons], ends.device)
        build_tree(light.tree)
        inputs = [scene, light.tree, self._density, CAUSTIC_PARAMETERS.wider, light.sites]
        launch(photon_disk_kernel(masks_of(scene)), ends.room, inputs, ends.device)
        self._sort_disks()

    def _sort_disks(self) -> None:
        photons, light = self.light.tree.photons, self.light
        self._disks.build(photons.position, photons.normal, light.sites.radius, light.share, photons.count)

    def clear(self) -> None:
        """Have no photons."""
        self._ends.filled.zero_()
        self._sort_disks()
