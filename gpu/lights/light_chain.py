"""Light on its way from an emitter through clear glass and by perfect mirrors, to the first surface that is neither."""

import warp as wp

from gpu.device_scene.bsdf import BsdfSample, largest
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.glass import attenuated
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.panes import meet, met_surface
from gpu.device_scene.scattering import choose_part, is_perfect, part_of, sample_scattering
from gpu.device_scene.sides import ray_coverage
from gpu.device_scene.surface import Surface
from gpu.sampling.sobol import sobol_pair


@wp.struct
class Flight:
    """Light of `flux` [W] on its way from `origin` along unit `direction`, in a body that takes `absorption` of it
    [1/unit length].
    """

    origin: wp.vec3
    direction: wp.vec3
    flux: wp.vec3
    absorption: wp.vec3


@wp.struct
class Arrival:
    """Where light arrives with `flux` [W]: the triangle `face`, NO_HIT where there is none, and its surface; panes that
    it crossed on the way are not met.
    """

    face: int
    surface: Surface
    flux: wp.vec3


@wp.func
def arrived(scene: SceneData, flight: Flight, coverage: wp.uint32) -> Arrival:
    """The end of a flight; coverage: as SceneData.coverage, the flight's own. There are no clear coats to it."""
    scene.coverage = coverage
    met = meet(scene, flight.origin, flight.direction, False)
    arrival = Arrival()
    arrival.face = met.hit.face
    if met.hit.face != NO_HIT:
        arrival.surface = met_surface(scene, met.hit, flight.direction)
        arrival.surface.coat = 0.0
        arrival.flux = wp.cw_mul(wp.cw_mul(flight.flux, met.tint), attenuated(flight.absorption, met.hit.t))
    return arrival


@wp.func
def sent_on(part: Surface, to_light: wp.vec3, flux: wp.vec3, absorption: wp.vec3, choice: float, x: float,
            y: float) -> Flight:  # fmt: skip
    """How light of `flux` from unit `to_light` goes on from a perfect part of a surface, or from glass, without flux if
    it does not.

    absorption: of where it comes from; choice: of the side of glass; x, y: of the facet of frosted
    glass; all uniform in [0, 1).
    """
    # One place for both, else kernels take long to compile.
    sample = BsdfSample()
    attempt = int(0)
    while attempt < 2 and largest(sample.weight) <= 0.0:
        if attempt == 1:
            # Where a bent normal sends light through the surface that reflects it, or back, the true one does not.
            part.normal = part.geometric_normal
        sample = sample_scattering(part, to_light, choice, x, y)
        attempt += 1
    flight = Flight()
    flight.direction = sample.direction
    flight.origin = offset_origin(part.position, part.geometric_normal, sample.direction)
    flight.flux = wp.cw_mul(flux, sample.weight)
    flight.absorption = absorption
    if wp.dot(sample.direction, part.geometric_normal) < 0.0 and not part.thin:
        # Radiance grows with the square of the index where light enters a denser body; flux does not.
        flight.flux = flight.flux * (part.eta * part.eta)
        flight.absorption = part.absorption
    return flight


@wp.struct
class Unscattered:
    """Light that only mirrors and clear glass have met, on its last way: to the surface number `bounce` that it meets,
    which is another; without flux where there is none. Its flux is what arrives there.
    """

    flight: Flight
    bounce: int


@wp.func
def unscattered(scene: SceneData, begin: Flight, path: int, first_pair: int, bounces: int, seed: int) -> Unscattered:
    """How light that begins so comes to a surface that scatters it, one of the first `bounces`.

    path: its number, for the second values of the pairs first_pair, first_pair + 2, … of `seed`.
    """
    nowhere = Unscattered()
    chain = Unscattered()
    chain.flight = begin
    for bounce in range(bounces):
        arrival = arrived(scene, chain.flight, ray_coverage(path, bounce, seed))
        if arrival.face == NO_HIT or largest(arrival.flux) <= 0.0:
            return nowhere
        to_light = -chain.flight.direction
        chosen = choose_part(arrival.surface, to_light, sobol_pair(path, first_pair + 2 * bounce, seed).y)
        part = part_of(arrival.surface, chosen)
        if not is_perfect(part):
            chain.flight.flux = arrival.flux
            chain.bounce = bounce
            return chain
        chain.flight = sent_on(part, to_light, arrival.flux, chain.flight.absorption, chosen.rest, 0.5, 0.5)
    return nowhere
