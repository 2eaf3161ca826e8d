"""Light from a lamp, and from the sky, that portals send where they are told to, which a formula knows."""

from collections.abc import Sequence
from math import pi

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, quad, rectangle_over, resident_of, results, trace_light_paths

from gpu.core.device import layout_of, struct_array
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.emission import FROM_AFAR, GIVEN, MATT, Particle
from gpu.lights.light_table import FAR
from gpu.lights.path_ends import PathEnds
from gpu.lights.portals import MOST_PORTALS, Portal, Portals, no_portals, way_through
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction, on_disk
from gpu.scene.types import Doubles

PATHS, RADIUS = 1 << 16, 0.9
# Half sides and height above the lamp of a window.
WINDOW = 0.1, 0.2, 0.5
UP = (0.0, 1.0, 0.0)


def portals_of(*strips: tuple[Sequence[float], Sequence[float], Sequence[float], float, float]) -> Portals:
    """Of centre, axis, half, narrow and width each, drawn alike."""
    rows, portals = np.zeros(MOST_PORTALS, layout_of(Portal)), no_portals(wp.get_device("cpu"))
    for row, strip in zip(rows, strips, strict=False):
        for name, value in zip(("centre", "axis", "half", "narrow", "width"), strip, strict=True):
            row[name] = value
        row["chance"] = 1.0 / len(strips)
    portals.count.fill_(len(strips))
    portals.strips = struct_array(Portal, rows, wp.get_device("cpu"))
    return portals


IN_WINDOW = (0.0, 0.5, 0.0), UP, (0.0, 0.0, 0.2), 0.05, 0.1
PLACED = {
    "none": (),
    "the window": (IN_WINDOW,),
    "two beside each other": (IN_WINDOW, ((0.08, 0.5, 0.1), UP, (0.06, 0.0, 0.1), 0.01, 0.07)),
    "before it, wider": (((0.02, 0.3, 0.0), (0.6, 0.8, 0.0), (0.0, 0.05, 0.3), 0.1, 0.2),),
    "another place": (((0.4, 0.3, 0.1), UP, (0.0, 0.0, 0.2), 0.02, 0.1),),
    "seen from behind": (((0.0, 0.5, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 0.2), 0.05, 0.1),),
    "seen from its end": (((0.0, 0.5, 0.0), UP, (0.0, 0.2, 0.0), 0.05, 0.1),),
}


@wp.kernel(module="unique")
def through_window_kernel(first: int, portals: Portals, spread: int, out: wp.array[float]) -> None:
    """One thread a path of a lamp at the origin that faces up, or of the sky straight below: what of it comes through
    WINDOW.
    """
    path = first + wp.tid()
    place = sobol_pair(path, 1, 0)
    up = wp.vec3(0.0, 1.0, 0.0)
    usual = Particle()
    usual.normal = up
    usual.spread = spread
    usual.direction = cosine_direction(up, place.x, place.y)
    if spread == FROM_AFAR:
        disk = on_disk(place.x, place.y) * wp.static(RADIUS)
        usual.direction = up
        usual.origin = wp.vec3(disk[0], -wp.static(FAR), disk[1])
    way = way_through(portals, usual, wp.static(RADIUS), path, 0, 0)
    met = way.origin + way.direction * ((wp.static(WINDOW[2]) - way.origin[1]) / wp.max(way.direction[1], 1.0e-6))
    if wp.abs(met[0]) <= wp.static(WINDOW[0]) and wp.abs(met[2]) <= wp.static(WINDOW[1]):
        out[path] = way.weight


def through_window(placed: str, spread: int) -> Doubles:
    return results(through_window_kernel, PATHS, [portals_of(*PLACED[placed]), spread], float)


@pytest.mark.parametrize("placed", PLACED)
def test_through_whatever_portals_as_much_light_comes_as_without(placed: str) -> None:
    from_lamp, from_sky = (through_window(placed, spread).mean() for spread in (MATT, FROM_AFAR))
    assert from_lamp == pytest.approx(rectangle_over(*WINDOW), rel=0.02)
    assert from_sky == pytest.approx(4.0 * WINDOW[0] * WINDOW[1] / (pi * RADIUS**2), rel=0.02)


@pytest.mark.parametrize("spread", [MATT, FROM_AFAR])
def test_a_portal_where_light_comes_through_brings_it_by_more_paths_alike(spread: int) -> None:
    plain, drawn = (through_window(placed, spread) for placed in ("none", "the window"))
    assert np.count_nonzero(drawn) > 0.5 * PATHS > 4 * np.count_nonzero(plain)
    assert drawn.max() < 0.5 * plain.max()


def test_what_a_light_alone_says_no_portal_changes() -> None:
    assert np.array_equal(through_window("none", GIVEN), through_window("the window", GIVEN))


def next_door() -> DeviceScene:
    """A lamp behind a wall at x = 0.1 with a slit at its end."""
    wall = quad((0.1, -0.5, -0.5), (0.0, 0.0, 0.96), (0.0, 1.0, 0.0))
    lamp = quad((0.3, 0.49, -0.1), (0.2, 0.0, 0.0), (0.0, 0.0, 0.2), 1)
    return resident_of([*box(), wall, lamp], [grey(0.7), grey(0.0, 5.0)])


def test_light_paths_through_a_slit_bring_the_same_light_by_many() -> None:
    device_scene = next_door()
    slit = portals_of(((0.1, 0.0, 0.48), (-1.0, 0.0, 0.0), (0.0, 0.5, 0.0), 0.02, 0.04))
    table, features = build_light_table(device_scene), device_scene.generalised().features(lambertian=False)
    many = trace_light_paths(device_scene, device_scene.data, table, 400_000, 4, 3)
    dark = many.position.numpy()[:, 0] < 0.09
    flux, count = many.flux.numpy()[dark].sum(), np.count_nonzero(dark) / 400_000
    ends = PathEnds(40_000, 4, wp.get_device("cpu"), arriving=False)
    ends.go_through(slit)
    ends.trace(device_scene.data, table, ends.no_seed, features)
    kept = ends.order.numpy()[: ends.count()]
    there = ends.raw.position.numpy()[kept, 0] < 0.09
    assert ends.raw.flux.numpy()[kept][there].sum() == pytest.approx(flux, rel=0.03)
    assert np.count_nonzero(there) / 40_000 > 5 * count
    ends.go_through(None)
    ends.trace(device_scene.data, table, ends.no_seed, features)
    kept = ends.order.numpy()[: ends.count()]
    assert np.count_nonzero(ends.raw.position.numpy()[kept, 0] < 0.09) / 40_000 < 2 * count
