"""Photons for tests, and what NumPy says of them."""

import numpy as np
import warp as wp
from scenes import column

from gpu.lights.photon_map import Photons
from gpu.scene.types import Floats

STRETCH = 8.0  # how much more distances along the normal count
COS_30 = 0.8660254


def photons_of(positions: Floats, normals: Floats, fluxes: Floats) -> Photons:
    """Photons on the CPU, in the order given."""
    photons = Photons()
    photons.position, photons.normal = column(positions, wp.vec3), column(normals, wp.vec3)
    photons.flux, photons.count = column(fluxes, wp.vec3), column([len(positions)], wp.int32)
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
