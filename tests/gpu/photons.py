"""Photons for tests, and what NumPy says of them."""

import numpy as np
import warp as wp
from scenes import column

from gpu.core.device import allocate
from gpu.device_scene.data import NO_HIT
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.final_gather import FinalGather
from gpu.indirect.illumination import Illumination
from gpu.lights.build import build_light_table
from gpu.lights.photon_map import Photons
from gpu.lights.photon_tree import PhotonTree, allocate_tree, build_tree
from gpu.scene.types import Floats
from gpu.sp.centres import ShadingClusters

STRETCH = 8.0  # how much more distances along the normal count
COS_30 = 0.8660254


def photons_of(positions: Floats, normals: Floats, fluxes: Floats) -> Photons:
    """Photons on the CPU, in the order given."""
    photons = Photons()
    photons.position, photons.normal = column(positions, wp.vec3), column(normals, wp.vec3)
    photons.flux, photons.count = column(fluxes, wp.vec3), column([len(positions)], wp.int32)
    photons.bounce, photons.bounces = column(np.zeros(len(positions)), wp.int32), 2
    return photons


def two_sided_square(count: int, seed: int = 0) -> tuple[Floats, Floats]:
    """Positions and normals of photons on both sides of a unit square, in the order of a coarse grid."""
    rng = np.random.default_rng(seed)
    x, z = rng.uniform(-0.5, 0.5, (2, count))
    up = rng.integers(0, 2, count)
    order = np.lexsort((x, np.floor(8 * z), np.floor(8 * x), up))
    normals = np.outer(2.0 * up - 1.0, (0.0, 1.0, 0.0))
    return np.stack([x, np.zeros(count), z], axis=1)[order].astype(np.float32), normals[order].astype(np.float32)


def separations(p: Floats, p_normal: Floats, q: Floats, q_normal: Floats) -> Floats:
    """Stretched distances from one point to all of (point, 3); infinite where normals are unlike."""
    way = q - p
    plane = np.maximum(np.abs(way @ p_normal), np.abs((way * q_normal).sum(axis=1)))
    distance = np.sqrt((way**2).sum(axis=1) + (STRETCH**2 - 1.0) * plane**2)
    return np.where(q_normal @ p_normal > COS_30, distance, np.inf)


def tree_of(positions: Floats, fluxes: Floats) -> PhotonTree:
    """A tree of photons that face up, at positions (photon, 3) of one height, of grey flux (photon,) [W]."""
    cell = ((positions[:, [0, 2]] + 0.5) * 1024.0).astype(int)
    order = np.argsort(sum((cell[:, axis] >> bit & 1) << (2 * bit + axis) for axis in range(2) for bit in range(10)))
    up = np.tile((0.0, 1.0, 0.0), (len(positions), 1))
    tree = allocate_tree(photons_of(positions[order], up, np.repeat(fluxes[order, None], 3, axis=1)))
    build_tree(tree)
    return tree


def read_at(places: Floats, surface: DeviceScene, albedo: float, light: Illumination) -> tuple[Floats, Floats]:
    """Irradiance that a gather ray reads close to each of the places (place, 3) of a surface that faces up, for those
    whose ray goes down steeply, 0 where nothing is known, and these places.
    """
    count, device = len(places), wp.get_device("cpu")
    clusters: ShadingClusters = allocate(ShadingClusters, count, device)
    clusters.position = column(places + np.float32([0.0, 1e-3, 0.0]), wp.vec3)
    clusters.normal = clusters.geometric_normal = column(np.tile((0.0, -1.0, 0.0), (count, 1)), wp.vec3)
    clusters.spacing.fill_(1.0)
    gather = FinalGather(clusters, 1, light, build_light_table(surface), bounces=0)
    features = surface.features(lambertian=True)
    seen = surface.view(lambertian=True), wp.zeros(1, dtype=int, device=device), features
    gather.trace(*seen)
    gather.read(*seen)
    hits = gather.ends.hits.numpy()
    near = (hits["face"] != NO_HIT) & (hits["t"] < 0.004)
    return gather.gathered.radiance.numpy()[near] * np.pi / albedo, places[near]


def lattice(side: int) -> Floats:
    """Places all over the unit square on y = 0, (side · side, 3)."""
    along = (np.arange(side) + 0.5) / side - 0.5
    x, z = np.meshgrid(along, along)
    return np.stack([x.ravel(), np.zeros(side * side), z.ravel()], axis=1)
