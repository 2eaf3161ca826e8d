"""What a final-gather ray reads of the full photon map: the irradiance at the nearest of the photons where it is known.

2009 paper, section 3.3, without its illumination cut. It is known at every fourth photon (P. Christensen, Faster Photon
Map Global Illumination, 1999): those are in Morton order, so every fourth lies among the others all over a surface. A
grid of disks tells which ones are near.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import separation
from gpu.core.color import brightness
from gpu.core.constants import FAR_AWAY
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.indirect.illumination import IrradianceEstimate
from gpu.lights.disk_grid import CORNERS, LEVELS, DiskGrid, DiskGridBuilder, bucket_at, reaches
from gpu.lights.photon_density import DENSITY_PARAMETERS, PhotonSites, allocate_sites, estimate_irradiance, times_mean
from gpu.lights.photon_tree import PhotonTree

PHOTONS_A_SITE = wp.constant(4)


@wp.struct
@dataclass
class LookupParameters:
    """reach: a photon answers for points within so many radii of its estimate, as far as nothing but its surface is
    around.

    What light then spreads beyond its edges is about what estimates across them lack within. Of points among photons
    one in a hundred is farther from all that answer; with 0.45, one in twelve. Where light is `bright` times the mean
    of all, it reaches farther, so that all that a ray may meet there is known.
    """

    reach: float = 0.7
    bright: float = 8.0
    bright_reach: float = 1.0


LOOKUP_PARAMETERS: LookupParameters = parameters(LookupParameters)


@wp.struct
class FullMap:
    """Photons with the irradiance at each, and what is read of them first. position, normal, reach (site,): of the disk
    that one answers for; grid: of these disks.
    """

    chosen: LookupParameters
    tree: PhotonTree
    sites: PhotonSites
    grid: DiskGrid
    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    reach: wp.array[float]


@wp.kernel
def choose_sites_kernel(first: int, tree: PhotonTree, sites: PhotonSites) -> None:
    """One thread a site: the photon that it is, one in every four, or fewer where there is no room for so many."""
    site = first + wp.tid()
    photons = tree.photons.count[0]
    count = wp.min((photons + PHOTONS_A_SITE - 1) // PHOTONS_A_SITE, sites.photon.shape[0])
    if site == 0:
        sites.count[0] = count
    if site < count:
        photon = int((wp.int64(2 * site + 1) * wp.int64(photons)) // wp.int64(2 * count))
        sites.photon[site] = photon
        sites.flux[site] = brightness(tree.photons.flux[photon])


def choose_sites(tree: PhotonTree, sites: PhotonSites) -> None:
    """Choose `sites` among the photons of `tree`, evenly in their order."""
    launch(choose_sites_kernel, len(sites.photon), [tree, sites], sites.photon.device)


@wp.kernel
def site_disk_kernel(first: int, lit: FullMap) -> None:
    """One thread a site: the disk that it answers for."""
    site = first + wp.tid()
    if site >= lit.sites.count[0]:
        return
    photon = lit.sites.photon[site]
    lit.position[site] = lit.tree.photons.position[photon]
    lit.normal[site] = lit.tree.photons.normal[photon]
    bright = times_mean(lit.sites, lit.sites.irradiance[site]) > lit.chosen.bright
    reach = wp.where(bright, lit.chosen.bright_reach, lit.chosen.reach)
    lit.reach[site] = wp.min(wp.min(reach * lit.sites.radius[site], lit.grid.reach), lit.sites.free[site])


@wp.func
def nearest_site(lit: FullMap, position: wp.vec3, normal: wp.vec3) -> int:
    """The site that answers for a surface point, −1 if none does."""
    nearest = float(FAR_AWAY)
    found = int(-1)
    for level in range(LEVELS):
        bucket = bucket_at(lit.grid, position, level, 1.0)
        for place in range(lit.grid.starts[bucket], lit.grid.starts[bucket + 1]):
            if reaches(lit.grid, place, position):
                site = lit.grid.entries[place] // CORNERS
                other = lit.normal[site]
                away = separation(lit.sites.alike, position, normal, lit.position[site], other)
                alike = wp.dot(normal, other) > lit.sites.alike.normal_threshold
                if alike and away < wp.min(lit.reach[site], nearest):
                    nearest = away
                    found = site
    return found


@wp.func
def irradiance_in_full_map(lit: FullMap, position: wp.vec3, normal: wp.vec3) -> IrradianceEstimate:
    """What is known of the irradiance of a surface point."""
    estimate = IrradianceEstimate()
    site = nearest_site(lit, position, normal)
    if site >= 0:
        estimate.irradiance = lit.sites.irradiance[site]
        estimate.earlier = lit.sites.earlier[site]
        estimate.known = True
    return estimate


class FullMapLight:
    """What rays read of all photons of `tree`: `lookup` of `lit`, of struct `data`, after `estimate`.

    usual: how many photons there mostly are, where that is less than there may be.
    """

    data, lookup = FullMap, irradiance_in_full_map

    def __init__(
        self, tree: PhotonTree, usual: int | None = None, chosen: LookupParameters = LOOKUP_PARAMETERS
    ) -> None:
        device, most = tree.flow.device, len(tree.photons.flux)
        room = -(-min(usual or most, most) // int(PHOTONS_A_SITE))
        self._tree, self._sites = tree, allocate_sites(room, device)
        reach, flatness = float(chosen.reach * DENSITY_PARAMETERS.most_radius), float(self._sites.alike.plane_weight)
        self._disks = DiskGridBuilder(room, reach, flatness, device)
        self._whole = wp.ones(1, dtype=float, device=device)
        self.lit = FullMap()
        self.lit.chosen, self.lit.tree, self.lit.sites, self.lit.grid = chosen, tree, self._sites, self._disks.grid
        self.lit.position, self.lit.normal = (wp.zeros(room, dtype=wp.vec3, device=device) for _ in range(2))
        self.lit.reach = wp.zeros(room, dtype=float, device=device)

    def estimate(self, scene: SceneData) -> None:
        """Tell the irradiance at some of the photons that there are now."""
        choose_sites(self._tree, self._sites)
        estimate_irradiance(scene, self._tree, self._sites)
        self.sort()

    def sort(self) -> None:
        """Have the sites found, of which radii are known."""
        lit = self.lit
        launch(site_disk_kernel, len(lit.reach), [lit], lit.reach.device)
        self._disks.build(lit.position, lit.normal, lit.reach, self._whole, lit.sites.count)
