"""Photons where light is so dense that a gather ray which ends there would outshine all others of its centre: behind a
lamp that stands a few centimetres off a wall, say.

Few rays that are drawn by the cosine meet so small a place, so some more are drawn towards photons there, and both
count by the balance heuristic (E. Veach and L. Guibas, Optimally Combining Sampling Techniques for Monte Carlo
Rendering, 1995). How densely photons lie, by which these rays are drawn, is what tells the irradiance, too: so the
density of their directions is known of any ray.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import PI
from gpu.core.device import RAY_REGISTERS, allocate, launch
from gpu.core.parameters import parameters
from gpu.core.radix_sort import running_total
from gpu.core.search import upper_bound
from gpu.indirect.illumination import Illumination
from gpu.lights.photon_density import PhotonSites, times_mean
from gpu.lights.photon_map import Photons
from gpu.sampling.sobol import TO_UNIT, hashed

PHOTONS_A_CANDIDATE = wp.constant(4)
# The flux of a usual site; a photon of very much more counts as one of so many.
UNITS, MOST_UNITS = wp.constant(64.0), wp.constant(float(1 << 20))


@wp.struct
@dataclass
class BrightParameters:
    """rays_a_guided: one more ray of a centre is drawn towards bright photons for so many drawn by the cosine.
    least: what one of n rays that are drawn by the cosine brings where photons begin to be bright, of all that a centre
    finds, if that is as the mean of all that is lit.
    """

    rays_a_guided: int = 8
    least: float = 0.125


BRIGHT_PARAMETERS: BrightParameters = parameters(BrightParameters)


@wp.struct
class BrightPhotons:
    """Candidates are one in four `photons`. units, totals (candidate,): the flux of each that is bright, rounded by
    chance, else 0, and the running sum of that; sites: of which the mean of all light is known; rays: of a centre, by
    the cosine; guided: drawn towards bright photons besides.
    """

    chosen: BrightParameters
    photons: Photons
    sites: PhotonSites
    units: wp.array[int]
    totals: wp.array[int]
    rays: int
    guided: int


def allocate_bright(light: Illumination, rays: int, chosen: BrightParameters = BRIGHT_PARAMETERS) -> BrightPhotons:
    """Room for those of the photons of `light` that centres of so many `rays` look for."""
    photons = light.lit.tree.photons
    candidates = -(-len(photons.flux) // int(PHOTONS_A_CANDIDATE))
    bright: BrightPhotons = allocate(BrightPhotons, candidates, photons.flux.device)
    bright.chosen, bright.photons, bright.sites = chosen, photons, light.lit.sites
    bright.rays, bright.guided = rays, rays // int(chosen.rays_a_guided)
    return bright


@wp.func
def is_bright(bright: BrightPhotons, irradiance: wp.vec3) -> bool:
    """Whether a surface of this irradiance [W/m²] is."""
    return times_mean(bright.sites, irradiance) > bright.chosen.least * float(bright.rays)


@cache
def _candidate_kernel(lookup: wp.Function, data: Any) -> wp.Kernel:
    """lookup, data: as of gpu.indirect.illumination.Illumination."""

    @wp.kernel(module="unique", cuda_max_registers=RAY_REGISTERS)
    def bright_candidate_kernel(first: int, lit: data, bright: BrightPhotons) -> None:
        """One thread a candidate: its units."""
        candidate = first + wp.tid()
        bright.units[candidate] = 0
        photon = PHOTONS_A_CANDIDATE * candidate
        if photon >= bright.photons.count[0]:
            return
        estimate = lookup(lit, bright.photons.position[photon], bright.photons.normal[photon])
        if is_bright(bright, estimate.irradiance):
            units = UNITS * brightness(bright.photons.flux[photon]) / bright.sites.mean_flux[0]
            chance = float(hashed(wp.uint32(photon))) * TO_UNIT
            bright.units[candidate] = int(wp.min(units, MOST_UNITS) + chance)

    return bright_candidate_kernel


def find_bright(light: Illumination, bright: BrightPhotons) -> None:
    """Fill in those that `light` tells to be bright, of whose photons `bright` is."""
    kernel = _candidate_kernel(light.lookup, light.data)
    launch(kernel, len(bright.units), [light.lit, bright], bright.units.device)
    running_total(bright.units, bright.totals)


@wp.func
def any_bright(bright: BrightPhotons) -> int:
    """The units of all; 0 where none are bright."""
    return bright.totals[bright.totals.shape[0] - 1]


@wp.func
def draw_bright(bright: BrightPhotons, value: wp.uint32) -> int:
    """The photon that has `value` of 2³², by flux."""
    total = wp.uint64(any_bright(bright))
    unit = int((wp.uint64(value) * total) >> wp.uint64(32))
    return PHOTONS_A_CANDIDATE * upper_bound(bright.totals, bright.totals.shape[0] - 1, unit)


@wp.func
def ray_share(bright: BrightPhotons, irradiance: wp.vec3, way: wp.vec3, normal: wp.vec3, other: wp.vec3,
              ratio: float) -> float:  # fmt: skip
    """What the light of a ray counts, over how often the cosine draws it: less than 1 where it may be drawn towards
    bright photons, too.

    irradiance: where it ends [W/m²]; way: to there from a surface point of this `normal`; other: the normal there;
    ratio: of rays that are drawn towards bright photons to those drawn by the cosine.
    """
    units = any_bright(bright)
    if units == 0 or not is_bright(bright, irradiance):
        return 1.0
    flux = float(PHOTONS_A_CANDIDATE) * float(units) / UNITS * bright.sites.mean_flux[0]
    squared = wp.length_sq(way)
    # Both cosines times the squared distance.
    cosines = wp.max(wp.dot(way, normal), 0.0) * wp.max(-wp.dot(way, other), 0.0)
    by_cosine = cosines * flux
    return by_cosine / wp.max(by_cosine + ratio * PI * brightness(irradiance) * squared * squared, 1.0e-20)
