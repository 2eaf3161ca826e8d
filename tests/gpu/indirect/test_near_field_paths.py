"""Paths from where near-field rays end: on slats in a room, of which VPLs tell little, and where there are none."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls, radiosity_cache
from scenes import box, column, grey, quad, resident_of, square_of_vpls

from gpu.core.device import launch
from gpu.device_scene.rays import blocking
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.near_field_paths import NearPaths, near_field_path_kernel
from gpu.scene.types import Doubles, Floats, Light, LightKind
from gpu.vpl.light_set import LightSetChoice
from gpu.vpl.light_sets import LightSets
from gpu.vpl.radiosity_cache import RadiosityCache, lacking_area, vpl_around

CPU = wp.get_device("cpu")
CHOICE = LightSetChoice(vpls=3000, vpl_clusters=60, bounces=16, seed=0, lambertian=True)
WIDTH = 0.01  # of slats, where VPLs are about 0.05 apart
SLATS = [quad((x, 0.05 * x, -0.4), (0.0, 0.0, 0.8), (WIDTH, 0.0, 0.0)) for x in np.linspace(-0.4, 0.4, 9)]
LAMP = Light("lamp", LightKind.POINT, (2.0, 2.0, 2.0), position=(0.0, 0.4, 0.0))


def silent(what: str, fraction: float) -> None:
    pass


def places_on_slats(count: int) -> Doubles:
    """As many on each, side by side."""
    along = np.random.default_rng(0).uniform(-0.4, 0.4, (len(SLATS), count))
    return np.array([[x + 0.5 * WIDTH, 0.05 * x, z] for x, row in zip(np.linspace(-0.4, 0.4, 9), along, strict=True)
                     for z in row])  # fmt: skip


def found(room: DeviceScene, places: Doubles, bounces: int = 16, shares: float = 1.0) -> Floats:
    """What paths from places of surfaces that face up bring, of which points lack `shares`."""
    light_sets, count = LightSets(room), len(places)
    light_set = light_sets.made(replace(CHOICE, bounces=bounces), silent)
    paths = NearPaths()
    paths.bounces, paths.usual_share, paths.radius_share, paths.clearance = bounces, 0.1, 0.06, 0.1
    paths.position, paths.normal = column(places, wp.vec3), column(np.tile([0.0, 1.0, 0.0], (count, 1)), wp.vec3)
    paths.share = column(np.full(count, shares), float)
    light, met = wp.zeros(count, dtype=wp.vec3, device=CPU), wp.zeros(count, dtype=int, device=CPU)
    pixels, scene = column(np.arange(count), wp.int32), room.view(lambertian=True)
    seen = scene, light_sets.table, light_sets.radiosity(light_set)
    inputs = [*seen, pixels, column([7], wp.int32), paths, light, met]
    features = room.features(lambertian=True)
    launch(near_field_path_kernel(features, blocking(scene)), count, inputs, CPU)
    assert met.numpy().mean() == pytest.approx(min(10.0 * shares, 1.0), abs=0.05)
    return np.asarray(light.numpy()[:, 0])


def test_slats_in_an_evenly_lit_room_have_the_radiosity_of_its_walls() -> None:
    """Walls that emit M/π and reflect ρ, and slats that reflect as much, have M·ρ/(1 − ρ), but for what slats hide."""
    room = resident_of([*box(1), *SLATS], [grey(0.5), grey(0.5, emission=1.0 / np.pi)])
    assert found(room, places_on_slats(200)).mean() == pytest.approx(1.0, rel=0.05)
    # A third of these are traced.
    assert found(room, places_on_slats(500), shares=0.033).mean() == pytest.approx(0.033, rel=0.1)
    assert not found(room, places_on_slats(10), shares=0.0).any()


def test_no_path_finds_more_than_twice_what_a_hemisphere_of_emitters_sends() -> None:
    """One of twelve triangles is drawn, and may fill most of what a slat sees: it would count for twelve of them."""
    room = resident_of([*box(1), *SLATS], [grey(0.5), grey(0.5, emission=1.0 / np.pi)])
    light = found(room, places_on_slats(200), bounces=1)
    assert light.mean() == pytest.approx(0.5, rel=0.05)
    assert light.max() <= 1.0 + 1e-4


@pytest.mark.parametrize("covered", [False, True])
def test_slats_have_the_light_of_a_lamp_where_they_are_lit_and_none_in_the_shade(covered: bool) -> None:
    """One of intensity I sends I·cos³θ/h² to what lies h below and θ aside. VPLs lie where it is light alone."""
    shade = [quad((-0.5, 0.3, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 0.5))] if covered else []
    room = resident_of([*box(0), *SLATS, *shade], [grey(0.5)], lights=[LAMP])
    places = places_on_slats(20)
    way = np.array([0.0, 0.4, 0.0]) - places
    expected = 0.5 * 2.0 * way[:, 1] / np.linalg.norm(way, axis=1) ** 3
    # Where the ray to the lamp passes below the shade's rim it is lit.
    expected[covered & (places[:, 2] * 0.1 / way[:, 1] < 0.0)] = 0.0
    assert found(room, places, bounces=1) == pytest.approx(expected, rel=1e-4)


@wp.kernel
def lacking_kernel(first: int, lit: RadiosityCache, scale: float, vpl: wp.array[int], area: wp.array[float]) -> None:
    vpl[0] = vpl_around(lit, wp.vec3(0.0, 0.0, 0.0), wp.vec3(0.0, 1.0, 0.0), scale)
    area[0] = lacking_area(lit, wp.vec3(0.0, 0.0, 0.0), wp.vec3(0.0, 1.0, 0.0), scale)


@pytest.mark.parametrize(("height", "scale", "lacks"), [(0.0, 0.5, False), (-0.4, 0.01, True)])
def test_a_usual_vpl_lacks_where_there_is_none_but_not_where_they_are_dense(
    height: float, scale: float, lacks: bool
) -> None:
    room = resident_of(box(), [grey(0.5)])
    lit = radiosity_cache(room, room.data, cluster_vpls(room, square_of_vpls(2500, height), 60, 0))
    vpl, area = wp.zeros(1, dtype=int, device=CPU), wp.zeros(1, dtype=float, device=CPU)
    lit.radius.fill_(0.0148)
    launch(lacking_kernel, 1, [lit, scale, vpl, area], CPU)
    assert vpl.numpy()[0] < 0
    assert area.numpy()[0] == pytest.approx(16.0 / 2500.0 if lacks else 0.0)
