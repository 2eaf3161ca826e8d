"""What a final-gather ray reads of the full photon map: the irradiance at the photon nearest to where it ends.

2009 paper, section 3.3, without its illumination cut.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.lights.photon_density import (
    DENSITY_PARAMETERS,
    PhotonSites,
    allocate_sites,
    answers,
    estimate_irradiance,
)
from gpu.lights.photon_tree import PhotonTree, photon_search

nearest_photon = photon_search(1)


@wp.struct
@dataclass
class LookupParameters:
    """reach: a photon answers for points within so many radii of its estimate; farther ones are in the dark.

    What light then spreads beyond its edges is about what estimates across them lack within.
    """

    reach: float = 0.45


LOOKUP_PARAMETERS: LookupParameters = parameters(LookupParameters)


@wp.kernel
def every_photon_kernel(first: int, tree: PhotonTree, sites: PhotonSites) -> None:
    """One thread a photon: makes it the site of its own number."""
    photon = first + wp.tid()
    sites.photon[photon] = photon
    if photon == 0:
        sites.count[0] = tree.photons.count[0]


def choose_every_photon(tree: PhotonTree, sites: PhotonSites) -> None:
    """Make all photons of `tree` sites."""
    launch(every_photon_kernel, len(sites.photon), [tree, sites], sites.photon.device)


@wp.struct
class FullMap:
    """All photons and the irradiance at each; most_radius: of their estimates."""

    tree: PhotonTree
    sites: PhotonSites
    chosen: LookupParameters
    most_radius: float


def full_map(tree: PhotonTree, sites: PhotonSites, chosen: LookupParameters = LOOKUP_PARAMETERS) -> FullMap:
    """The map of `sites`, which are all photons of `tree`."""
    lit = FullMap()
    lit.tree, lit.sites, lit.chosen, lit.most_radius = tree, sites, chosen, float(DENSITY_PARAMETERS.most_radius)
    return lit


@wp.func
def irradiance_in_full_map(scene: SceneData, lit: FullMap, position: wp.vec3, normal: wp.vec3) -> wp.vec3:
    """Irradiance of a surface point [W/m²]."""
    found = nearest_photon(lit.tree, lit.sites.alike, position, normal, lit.chosen.reach * lit.most_radius, -1)
    photon = found.photon[0]
    if photon < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    if found.distance[0] > lit.chosen.reach * lit.sites.radius[photon]:
        return wp.vec3(0.0, 0.0, 0.0)
    if not answers(scene, lit.tree, lit.sites, photon, position, normal):
        return wp.vec3(0.0, 0.0, 0.0)
    return lit.sites.irradiance[photon]


class FullMapLight:
    """What rays read of all photons of `tree`: `lookup` of `lit`, of struct `data`, after `estimate`."""

    data, lookup = FullMap, irradiance_in_full_map

    def __init__(self, tree: PhotonTree) -> None:
        self._tree = tree
        self._sites = allocate_sites(len(tree.photons.flux), tree.flow.device)
        self.lit = full_map(tree, self._sites)

    def estimate(self, scene: SceneData) -> None:
        """Tell the irradiance at the photons that there are now."""
        choose_every_photon(self._tree, self._sites)
        estimate_irradiance(scene, self._tree, self._sites)
