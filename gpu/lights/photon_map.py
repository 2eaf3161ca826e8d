"""The global photon map: where light paths from the emitters meet surfaces (H. W. Jensen, Global Illumination using
Photon Maps, 1996; 2009 paper, section 3.1).

It is traced and sorted anew in each frame, without leaving the device.
"""

from functools import cache

import warp as wp
from warp.utils import radix_sort_pairs

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import allocate, launch
from gpu.core.radix_sort import iota_kernel
from gpu.device_scene.bsdf import even_reflectance, largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import closest_hit, offset_origin
from gpu.device_scene.surface import surface_at
from gpu.lights.emission import emit
from gpu.lights.light_paths import count_filled_kernel, surface_key_kernel
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction


@wp.struct
class Photons:
    """Photons in Morton order, those of one side of a surface together.

    position, normal (photon,): where one arrives in unit space, the geometric normal on the side that it arrives from;
    flux (photon,): what it brings, before anything is reflected [W]; count (1,): how many there are; places beyond hold
    nothing.
    """

    position: wp.array[wp.vec3]
    normal: wp.array[wp.vec3]
    flux: wp.array[wp.vec3]
    count: wp.array[int]


def allocate_photons(capacity: int, device: wp.Device) -> Photons:
    """Room for so many photons, none yet."""
    photons: Photons = allocate(Photons, capacity, device)
    photons.count = wp.zeros(1, dtype=int, device=device)
    return photons


@cache
def photon_kernel(texels: bool, environment: bool) -> wp.Kernel:
    """The kernel for scenes whose surfaces show `texels`, or neither textures nor masks, with an environment or not."""

    @wp.kernel(module="unique")
    def photon_kernel(
        first: int, scene: SceneData, table: LightTable, paths: int, bounces: int, seeds: wp.array[int], out: Photons
    ) -> None:
        """One thread a light path: a photon at each of its `bounces` first hits, at path · bounces + hit; flux 0 where
        there is none. seeds: one element.

        Russian roulette on the albedo's largest channel keeps the flux of surviving photons about equal.
        """
        path = first + wp.tid()
        if wp.static(not texels):
            scene.ignore_alpha = True
            scene.textured = False
        if wp.static(not environment):
            scene.has_environment = False
        for bounce in range(bounces):
            out.flux[path * bounces + bounce] = wp.vec3(0.0, 0.0, 0.0)
        seed = seeds[0]
        pick = sobol_pair(path, 0, seed)
        particle = emit(scene, table, pick.a, sobol_pair(path, 1, seed), sobol_pair(path, 2, seed))
        flux = particle.flux / float(paths)
        origin = offset_origin(particle.origin, particle.normal, particle.direction)
        direction = particle.direction
        for bounce in range(bounces):
            hit = closest_hit(scene, origin, direction, RAY_LENGTH)
            if hit.face == NO_HIT:
                return
            surface = surface_at(scene, hit, direction)
            slot = path * bounces + bounce
            out.position[slot] = surface.position
            out.normal[slot] = surface.geometric_normal
            out.flux[slot] = flux
            reflectance = even_reflectance(surface, -direction)
            survival = largest(reflectance)
            if sobol_pair(path, 4 + 2 * bounce, seed).x >= survival:
                return
            flux = wp.cw_mul(flux, reflectance) / survival
            place = sobol_pair(path, 3 + 2 * bounce, seed)
            direction = cosine_direction(surface.geometric_normal, place.x, place.y)
            origin = offset_origin(surface.position, surface.geometric_normal, direction)

    return photon_kernel


@wp.kernel
def gather_photons_kernel(first: int, order: wp.array[int], photons: Photons, out: Photons) -> None:
    """One thread a photon: copies the one that comes there in `order`."""
    index = first + wp.tid()
    if index >= out.count[0]:
        return
    source = order[index]
    out.position[index] = photons.position[source]
    out.normal[index] = photons.normal[source]
    out.flux[index] = photons.flux[source]


class PhotonMap:
    """The photons of `paths` light paths of at most `bounces` hits; `photons` after `trace`. All is allocated once."""

    def __init__(self, paths: int, bounces: int, device: wp.Device) -> None:
        self._paths, self._bounces, self.device = paths, bounces, device
        self.capacity = paths * bounces
        self.photons, self._raw = (allocate_photons(self.capacity, device) for _ in range(2))
        self._keys = wp.zeros(2 * self.capacity, dtype=int, device=device)
        self._order = wp.zeros(2 * self.capacity, dtype=int, device=device)

    def trace(self, scene: SceneData, table: LightTable, seed: wp.array, features: SceneFeatures) -> None:
        """Trace and sort new photons by `seed` (1,)."""
        raw, photons, capacity = self._raw, self.photons, self.capacity
        inputs = [scene, table, self._paths, self._bounces, seed, raw]
        launch(photon_kernel(features.texels, features.environment), self._paths, inputs, self.device)
        launch(surface_key_kernel, capacity, [raw.position, raw.normal, raw.flux, self._keys], self.device)
        launch(iota_kernel, capacity, [self._order], self.device)
        radix_sort_pairs(self._keys, self._order, capacity)
        photons.count.fill_(capacity)
        launch(count_filled_kernel, capacity, [self._keys, photons.count], self.device)
        launch(gather_photons_kernel, capacity, [self._order, raw, photons], self.device)
