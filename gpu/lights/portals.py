"""Portals: where light comes into view on its way, by a window or by a door that is ajar, and light paths drawn to go
there (B. Bitterli et al., Portal-Masked Environment Map Sampling, 2015).

Half of the paths that leave a point or the sky behind portals are drawn through one, and all count by both densities
together (Veach 1997, 9.2.4), so that light is right in the mean whatever portals there are.
"""

import warp as wp

from gpu.core.constants import PI
from gpu.core.device import allocate
from gpu.lights.emission import FROM_AFAR, GIVEN, Particle
from gpu.lights.light_table import FAR
from gpu.sampling.sobol import sobol_pair

MOST_PORTALS = 32
# Of paths that could go through portals.
THROUGH = wp.constant(0.5)
# The square of the sine between a portal's half and the way to it, below which it is seen from its end.
LEAST_ASIDE = wp.constant(1.0e-4)
# Two pairs of samples for the emitter and for each surface.
PORTAL_PAIR = wp.constant(768)


@wp.struct
class Portal:
    """A strip that light crosses about along unit `axis`: from `centre` it reaches as far as `half` both ways, and
    `width` to each side, turned to whom light comes from; in unit space. Half of all that is drawn through it is within
    `narrow` to each side. chance: that with which it is drawn among all.
    """

    centre: wp.vec3
    axis: wp.vec3
    half: wp.vec3
    narrow: float
    width: float
    chance: float


@wp.struct
class Portals:
    """The first `count` (1,) of `strips` (portal,)."""

    count: wp.array[int]
    strips: wp.array[Portal]


@wp.struct
class Aim:
    """How portals alone draw rays: one at all with `chance`, and a given one with `density`, by solid angle [1/sr], or
    from afar by area across it.
    """

    chance: float
    density: float


@wp.struct
class WayThrough:
    """Where a ray begins, its unit direction, and the `weight` of what it carries by how often it is drawn so."""

    origin: wp.vec3
    direction: wp.vec3
    weight: float


@wp.func
def side_of(portal: Portal, origin: wp.vec3, direction: wp.vec3, spread: int) -> wp.vec3:
    """The unit vector to the side of a portal that is turned to `origin`, or to the sky along `direction`; 0 where
    light from there does not cross it by its axis.
    """
    towards = direction
    if spread != FROM_AFAR:
        towards = wp.normalize(portal.centre - origin)
    side = wp.cross(wp.normalize(portal.half), towards)
    if wp.dot(towards, portal.axis) <= 0.0 or wp.length_sq(side) < LEAST_ASIDE:
        return wp.vec3(0.0, 0.0, 0.0)
    return wp.normalize(side)


@wp.func
def strip_density(portal: Portal, side: wp.vec3, origin: wp.vec3, direction: wp.vec3, spread: int) -> float:
    """As Aim.density, of rays through one portal, of which `side_of` is not 0."""
    length = wp.length(portal.half)
    along = portal.half / length
    normal = wp.cross(along, side)
    cosine = wp.dot(direction, normal)
    to_centre = portal.centre - origin
    height = wp.dot(to_centre, normal)
    if cosine * height <= 0.0:
        return 0.0
    distance = height / cosine
    met = direction * distance - to_centre
    aside = wp.abs(wp.dot(met, side))
    if wp.abs(wp.dot(met, along)) > length or aside > portal.width:
        return 0.0
    across = 0.5 / portal.width
    if aside <= portal.narrow:
        across += 0.5 / portal.narrow
    density = across / (4.0 * length * wp.abs(cosine))
    return wp.where(spread == FROM_AFAR, density, density * distance * distance)


@wp.func
def aim_of(portals: Portals, origin: wp.vec3, direction: wp.vec3, spread: int) -> Aim:
    """How portals draw the ray from `origin` along unit `direction`."""
    aim = Aim()
    for number in range(portals.count[0]):
        portal = portals.strips[number]
        side = side_of(portal, origin, direction, spread)
        if wp.length_sq(side) > 0.0:
            aim.chance += portal.chance
            aim.density += portal.chance * strip_density(portal, side, origin, direction, spread)
    return aim


@wp.func
def chosen_portal(portals: Portals, value: float) -> int:
    """The portal that a value of [0, 1) falls to."""
    number = int(0)
    left = value - portals.strips[0].chance
    while left >= 0.0 and number < portals.count[0] - 1:
        number += 1
        left -= portals.strips[number].chance
    return number


@wp.func
def point_of(portal: Portal, side: wp.vec3, x: float, y: float) -> wp.vec3:
    """The point of a portal that x and y, uniform in [0, 1), are mapped to."""
    across = portal.narrow * (4.0 * y - 1.0)
    if y >= 0.5:
        across = portal.width * (4.0 * y - 3.0)
    return portal.centre + portal.half * (2.0 * x - 1.0) + side * across


@wp.func
def way_through(portals: Portals, usual: Particle, radius: float, path: int, step: int, seed: int) -> WayThrough:
    """The way of light that would be drawn as usual, or is drawn through a portal instead.

    radius: of the disk that light from afar begins on, in unit space; path, step, seed: for samples.
    """
    way = WayThrough()
    way.origin = usual.origin
    way.direction = usual.direction
    way.weight = 1.0
    if portals.count[0] == 0 or usual.spread == GIVEN:
        return way
    pick = sobol_pair(path, PORTAL_PAIR + 2 * step, seed).x
    if pick < THROUGH:
        portal = portals.strips[chosen_portal(portals, pick / THROUGH)]
        side = side_of(portal, usual.origin, usual.direction, usual.spread)
        if wp.length_sq(side) > 0.0:
            place = sobol_pair(path, PORTAL_PAIR + 2 * step + 1, seed)
            point = point_of(portal, side, place.x, place.y)
            if usual.spread == FROM_AFAR:
                way.origin = point - usual.direction * (wp.dot(point, usual.direction) + FAR)
            else:
                way.direction = wp.normalize(point - usual.origin)
    density = wp.max(wp.dot(usual.normal, way.direction), 0.0) / PI
    if usual.spread == FROM_AFAR:
        density = 1.0 / (PI * radius * radius)
    aim = aim_of(portals, way.origin, way.direction, usual.spread)
    both = (1.0 - THROUGH * aim.chance) * density + THROUGH * aim.density
    way.weight = 0.0
    if both > 0.0:
        way.weight = density / both
    return way


def no_portals(device: wp.Device) -> Portals:
    """None, with room for MOST_PORTALS."""
    portals: Portals = allocate(Portals, MOST_PORTALS, device)
    portals.count = wp.zeros(1, dtype=int, device=device)
    return portals
