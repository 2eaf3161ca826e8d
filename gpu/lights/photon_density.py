"""Irradiance from how densely photons lie on a surface (H. W. Jensen, Global Illumination using Photon Maps, 1996).

It is estimated at photons, and kept there (P. Christensen, Faster Photon Map Global Illumination, 1999): at all of
them, or at those that stand for the nodes of an illumination cut.
"""

from dataclasses import dataclass

import warp as wp

from gpu.clustering.grid import CLUSTERING_PARAMETERS, ClusteringParameters, separation
from gpu.core.color import brightness
from gpu.core.constants import GOLDEN_RATIO, PI, TWO_PI
from gpu.core.device import RAY_REGISTERS, allocate, launch
from gpu.core.intrinsics import float_least, float_sum, lanes_of, vector_sum
from gpu.core.parameters import parameters
from gpu.core.sample_mean import SAMPLES, find_sample_mean
from gpu.device_scene.data import NO_HIT, WHOLE, Hit, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import lifted
from gpu.device_scene.part_glass import mean_direction, part_at
from gpu.device_scene.rays import closest_hit, unblocked
from gpu.device_scene.sides import LEAST_SHARE, triangle_normal
from gpu.device_scene.specialisation import made_for, masks_of, specialisation
from gpu.lights.photon_tree import PhotonTree, photon_search
from gpu.sampling.sobol import TO_UNIT, hashed
from gpu.sampling.warps import orthonormal

# Photons in one estimate. The farthest only bounds the disk: the mean over a surface is unbiased with that.
NEIGHBOURS = 32
# Places of a disk where its surface is looked for: on a spiral, for small things closer to the middle.
PLACES = wp.constant(16)
# A photon's own surface is looked for no farther below it, in unit space.
BELOW = wp.constant(1.0e-4)

neighbours = photon_search(NEIGHBOURS)


@wp.struct
@dataclass
class DensityParameters:
    """What decides the quality of estimates.

    most_radius: of a disk, unit space: where photons are so few, the estimate is over this, with those there are.
    own_share: what a site's own photon counts: were photons scattered at random, it would tell nothing, since wherever
    there is a site there is one; were they a lattice, all of it would count, and half of the farthest one. They are in
    between. least_covered: share of a disk; less that is surface is not believed.
    """

    most_radius: float = 0.1
    own_share: float = 0.5
    least_covered: float = 0.12


DENSITY_PARAMETERS: DensityParameters = parameters(DensityParameters)


@wp.struct
class PhotonSites:
    """Photons at which the irradiance is known.

    alike: which surface points are alike; photon (site,): which ones they are; count (1,): how many; radius (site,): of
    the estimate's disk, unit space; free (site,): so far around, at most that, there is nothing but their surface, 0
    where too little of it is to be believed; irradiance (site,) [W/m²]; earlier (site,): what of that photons bring
    that are not of the last bounce; flux (site,): what photons that it stands for bring, by brightness [W];
    sampled_flux, sampled_area (SAMPLES,): of some, and the surface that it lights; mean_flux, mean_area (1,): of these.
    """

    alike: ClusteringParameters
    photon: wp.array[int]
    count: wp.array[int]
    radius: wp.array[float]
    free: wp.array[float]
    irradiance: wp.array[wp.vec3]
    earlier: wp.array[wp.vec3]
    flux: wp.array[float]
    sampled_flux: wp.array[float]
    sampled_area: wp.array[float]
    mean_flux: wp.array[float]
    mean_area: wp.array[float]


def allocate_sites(capacity: int, device: wp.Device) -> PhotonSites:
    """Room for so many sites."""
    sites: PhotonSites = allocate(PhotonSites, capacity, device)
    sites.count = wp.zeros(1, dtype=int, device=device)
    sites.alike = CLUSTERING_PARAMETERS
    sites.sampled_flux, sites.sampled_area = (wp.zeros(SAMPLES, dtype=float, device=device) for _ in range(2))
    sites.mean_flux, sites.mean_area = (wp.zeros(1, dtype=float, device=device) for _ in range(2))
    return sites


@wp.func
def times_mean(sites: PhotonSites, irradiance: wp.vec3) -> float:
    """How many times as bright as the mean of what is lit a surface of this irradiance is; 0 where nothing is known."""
    return brightness(irradiance) * sites.mean_area[0] / wp.max(sites.mean_flux[0], 1.0e-30)


@wp.func
def answers(scene: SceneData, tree: PhotonTree, sites: PhotonSites, site: int, position: wp.vec3,
            normal: wp.vec3) -> bool:  # fmt: skip
    """Whether no wall stands between a site and a surface point near it: where it is not known, a ray tells."""
    photon = sites.photon[site]
    if wp.length(position - tree.photons.position[photon]) <= sites.free[site]:
        return True
    return unblocked(scene, tree.photons.position[photon], tree.photons.normal[photon], position, normal)


@wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
def photon_density_kernel(first: int, lanes: int, tree: PhotonTree, chosen: DensityParameters,
                          sites: PhotonSites) -> None:  # fmt: skip
    """`lanes` threads a site: flux per area of the disk that the photons nearest to it fill."""
    index = first + wp.tid()
    site = index // lanes
    lane = index % lanes
    if site >= sites.count[0]:
        return
    own = sites.photon[site]
    photons = tree.photons
    found = neighbours(tree, sites.alike, own, chosen.most_radius, lane, lanes)
    total = wp.vec3(0.0, 0.0, 0.0)
    last = wp.vec3(0.0, 0.0, 0.0)
    if lane == 0:
        total = photons.flux[own] * chosen.own_share
        last = wp.where(photons.bounce[own] + 1 >= photons.bounces, total, last)
    for place in range(wp.static(NEIGHBOURS)):
        other = found.photon[place]
        if other >= 0 and found.distance[place] < found.radius:
            total += photons.flux[other]
            if photons.bounce[other] + 1 >= photons.bounces:
                last += photons.flux[other]
    total = vector_sum(total, lanes)
    last = vector_sum(last, lanes)
    area = wp.max(PI * found.radius * found.radius, 1.0e-20)
    if lane == 0:
        sites.radius[site] = found.radius
        sites.irradiance[site] = total / area
        sites.earlier[site] = (total - last) / area


@wp.struct
class Covered:
    """The share of a disk that is surface, and how far it is all around, in unit space: its radius at most."""

    share: float
    free: float


@wp.func
def disk_places(number: int, salt: int) -> wp.vec2:
    """How the places are turned and shifted, 0 to 1 each, where a numbered disk is looked at."""
    turn = float(hashed(wp.uint32(number))) * TO_UNIT
    return wp.vec2(turn, float(hashed(wp.uint32(number) ^ wp.uint32(salt))) * TO_UNIT)


@wp.func
def covered_disk(scene: SceneData, alike: ClusteringParameters, position: wp.vec3, normal: wp.vec3, radius: float,
                 places: wp.vec2, lane: int, lanes: int) -> Covered:  # fmt: skip
    """How much of a disk about a surface point is surface. places: where it is looked for, as of disk_places.
    Each of the `lanes` (gpu.core.intrinsics) of a point looks at places of its own.

    The surface ends at its edge, and where something stands on it, which is looked for as far as the disk reaches:
    thin walls stand between places.
    """
    height = radius / alike.plane_weight
    frame = orthonormal(normal)
    above = position + normal * height
    covered = float(0.0)
    whole = float(0.0)
    free = float(radius)
    for place in range(lane, PLACES, lanes):
        angle = TWO_PI * (places[0] + GOLDEN_RATIO * float(place))
        out = (float(place) + places[1]) / float(PLACES)
        direction = frame * wp.vec3(wp.cos(angle), wp.sin(angle), 0.0)
        standing = closest_hit(scene, above, direction, radius)
        hit = Hit()
        hit.face = NO_HIT
        if standing.face != NO_HIT:
            free = wp.min(free, standing.t)
        if standing.face == NO_HIT or radius * out < standing.t:
            hit = closest_hit(scene, above + direction * (radius * out), -normal, 2.0 * height)
        share = float(0.0)
        if hit.face != NO_HIT:
            # As near as a photon there would count.
            beside = triangle_normal(scene, hit.face)
            beside = wp.where(wp.dot(beside, normal) < 0.0, -beside, beside)
            corner = scene.triangles[hit.face]
            there = (
                scene.vertices[corner[0]] * hit.u
                + scene.vertices[corner[1]] * hit.v
                + scene.vertices[corner[2]] * (1.0 - hit.u - hit.v)
            )
            if wp.dot(beside, normal) > alike.normal_threshold:
                share = wp.where(separation(alike, position, normal, there, beside) < radius, out, 0.0)
        if share == 0.0:
            free = wp.min(free, radius * out)
        covered += share
        whole += out
    disk = Covered()
    disk.share = float_sum(covered, lanes) / float_sum(whole, lanes)
    disk.free = float_least(free, lanes)
    return disk


@wp.func
def share_there(scene: SceneData, position: wp.vec3, normal: wp.vec3) -> float:
    """The share of a surface that photons meet, where one is with this `normal`."""
    scene.coverage = WHOLE
    hit = closest_hit(scene, lifted(position, normal), -normal, BELOW)
    if hit.face == NO_HIT:
        return 1.0
    return wp.max(part_at(scene, hit, mean_direction(normal)).there, LEAST_SHARE)


@made_for("masks", "alpha", "cutouts", "part_glass")
def covered_density_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique", module_options={"fast_math": True}, cuda_max_registers=RAY_REGISTERS)
    def covered_density_kernel(first: int, lanes: int, scene: SceneData, tree: PhotonTree, chosen: DensityParameters,
                               sites: PhotonSites) -> None:  # fmt: skip
        """`lanes` threads a site: its irradiance becomes that of the part of its disk that is surface, and of that the
        share that is there.
        """
        index = first + wp.tid()
        site = index // lanes
        lane = index % lanes
        if site >= sites.count[0]:
            return
        position = tree.photons.position[sites.photon[site]]
        normal = tree.photons.normal[sites.photon[site]]
        places = disk_places(site, tree.leaves)
        scene = specialise(scene)
        scene.coverage = WHOLE
        disk = covered_disk(scene, sites.alike, position, normal, sites.radius[site], places, lane, lanes)
        if lane == 0:
            share = wp.max(disk.share, chosen.least_covered)
            if scene.blended:
                share *= share_there(scene, position, normal)
            sites.irradiance[site] = sites.irradiance[site] / share
            sites.earlier[site] = sites.earlier[site] / share
            sites.free[site] = wp.where(disk.share < chosen.least_covered, 0.0, disk.free)

    return covered_density_kernel


@wp.kernel
def site_sample_kernel(first: int, sites: PhotonSites) -> None:
    """One thread a sample: flux and area of a site; those of all are spread evenly."""
    sample = first + wp.tid()
    sites.sampled_flux[sample] = 0.0
    sites.sampled_area[sample] = 0.0
    count = sites.count[0]
    if count > 0:
        site = int(wp.int64(2 * sample + 1) * wp.int64(count) / wp.int64(2 * SAMPLES))
        light = brightness(sites.irradiance[site])
        if light > 0.0:
            sites.sampled_flux[sample] = sites.flux[site]
            sites.sampled_area[sample] = sites.flux[site] / light


def estimate_density(tree: PhotonTree, sites: PhotonSites, chosen: DensityParameters = DENSITY_PARAMETERS) -> None:
    """Fill in radius and irradiance of the `sites`, as if their disks were surface all over."""
    device = sites.photon.device
    lanes = lanes_of(device, few=True)
    launch(photon_density_kernel, lanes * len(sites.photon), [lanes, tree, chosen, sites], device)


def estimate_irradiance(scene: SceneData, tree: PhotonTree, sites: PhotonSites,
                        chosen: DensityParameters = DENSITY_PARAMETERS) -> None:  # fmt: skip
    """Fill in radius, irradiance, its means, and how far around is free of the `sites`, on the surfaces of `scene`."""
    estimate_density(tree, sites, chosen)
    device = sites.photon.device
    lanes = lanes_of(device, few=True)
    inputs = [lanes, scene, tree, chosen, sites]
    launch(covered_density_kernel(masks_of(scene)), lanes * len(sites.photon), inputs, device)
    launch(site_sample_kernel, SAMPLES, [sites], device)
    find_sample_mean(sites.sampled_flux, sites.mean_flux)
    find_sample_mean(sites.sampled_area, sites.mean_area)
