from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from emitters import POINT, SPOT, SUN, lamp_room
from scenes import box, grey, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.lights.path_light import by_reach
from gpu.lights.reflective_shadow_map import (
    ShadowMaps,
    halvings_of,
    make_shadow_maps,
    map_of_emitters,
    trace_shadow_maps,
)
from gpu.lights.shadow_map_parameters import SHADOW_MAP_PARAMETERS
from gpu.lights.sun_map import sun_maps
from gpu.scene.types import AlphaMode, Doubles, Material

SIDE = 64
MOST = SHADOW_MAP_PARAMETERS.most_maps


def mapped(device_scene: DeviceScene, seed: int = 0, suns: Any = None) -> tuple[ShadowMaps, Vpls]:
    """The maps of a scene's lights."""
    table = build_light_table(device_scene)
    table.suns = suns or table.suns
    maps = make_shadow_maps(device_scene, table, table.all_emitters, SIDE)
    vpls = allocate_vpls(maps.count * SIDE**2, device_scene.device)
    features = device_scene.features(lambertian=False)
    trace_shadow_maps(device_scene.data, table, maps, 4, seed, features, vpls)
    return maps, vpls


def test_maps_carry_what_walls_reflect_of_all_lights() -> None:
    """A closed box of albedo ½, a lamp on its ceiling, a bulb and a spot: all their light meets a wall."""
    device_scene = lamp_room(lights=[POINT, SPOT])
    maps, vpls = mapped(device_scene)
    assert (maps.count, maps.atlas_side) == (3, 2 * SIDE)
    flux = vpls.flux.numpy().astype(np.float64).reshape(3, -1, 3).sum(axis=1)
    lamp = np.full(3, np.pi * 3.0 * 0.04)
    bulb, spot = 4.0 * np.pi * np.array(POINT.intensity), 2.0 * np.pi * 0.2 * np.array(SPOT.intensity)
    # The lamp itself, which is black, hides a little.
    assert flux == pytest.approx(0.5 * np.stack([lamp, bulb, spot]), rel=0.04)


def test_a_ray_meets_the_same_of_a_veil_that_its_chain_of_mirrors_met() -> None:
    """A bulb in a box that is there by 0.4, in one of mirrors: these scatter none of its light."""
    veil = Material(base_color=(0.5, 0.5, 0.5, 0.4), alpha_mode=AlphaMode.BLEND, specular=0.0)
    mirror = Material(metallic=1.0, roughness=0.0)
    _, vpls = mapped(resident_of([*box(), *box(1, 0.3)], [mirror, veil], lights=[POINT]))
    lit = vpls.flux.numpy().sum(axis=1) > 0.0
    assert 0.6 < lit.mean() < 1.0
    assert np.abs(vpls.position.numpy()[lit]).max() == pytest.approx(0.3, abs=1e-4)


def test_pixels_of_a_map_that_are_neighbours_see_neighbouring_places() -> None:
    _, vpls = mapped(resident_of(box(), [grey(0.5)], lights=[POINT]))
    position = vpls.position.numpy()
    # In Morton's order each four are a square of pixels: 1/32 of a turn wide, half a unit away.
    square = position.reshape(-1, 4, 3)
    assert np.median(np.linalg.norm(square - square[:, :1], axis=2).max(axis=1)) < 0.1
    assert np.abs(position).max() == pytest.approx(0.5, abs=1e-5)


def test_lights_of_less_power_have_fewer_pixels_of_about_as_much_flux_each() -> None:
    weak = replace(POINT, intensity=tuple(np.array(POINT.intensity) / 20.0))
    maps, vpls = mapped(resident_of(box(), [grey(0.5)], lights=[POINT, weak]))
    flux = vpls.flux.numpy().astype(np.float64).sum(axis=1).reshape(2, -1)
    assert maps.halvings.numpy().tolist() == [0, 2]
    assert (flux > 0.0).sum(axis=1).tolist() == [SIDE**2, SIDE**2 // 16]
    assert flux[0].sum() == pytest.approx(20.0 * flux[1].sum(), rel=0.01)
    # All around, as those of the other.
    places = vpls.position.numpy().reshape(2, -1, 3)
    assert places[1, flux[1] > 0.0].mean(axis=0) == pytest.approx(places[0].mean(axis=0), abs=0.01)


@pytest.mark.parametrize(("power", "halvings"), [(1.0, 0), (0.26, 0), (0.24, 1), (0.01, 2), (0.0, 2)])
def test_sides_are_halved_down_to_the_least(power: float, halvings: int) -> None:
    assert halvings_of(2.0**32 * np.array([1.0, power]), SIDE).tolist() == [0, halvings]


def test_a_sun_is_mapped_from_all_around_the_scene() -> None:
    maps, vpls = mapped(resident_of(box(), [grey(0.5)], lights=[SUN]))
    flux, position = vpls.flux.numpy().astype(np.float64), vpls.position.numpy()
    lit = flux.sum(axis=1) > 0.0
    # The cube's shadow, across the sun's direction: of its top 0.8, of a side 0.6.
    assert flux.sum(axis=0) == pytest.approx(0.5 * 1.4 * np.array(SUN.intensity), rel=0.02)
    assert maps.count == 1
    assert lit.mean() == pytest.approx(1.4 / (np.pi * 0.75), abs=0.02)
    assert {round(float(x), 3) for x in position[lit][:, 1]} >= {0.5}


def test_all_but_a_sun_that_lights_nothing_seen_is_worth_the_same_however_faint() -> None:
    faint = [replace(POINT, intensity=(1e-5 * step,) * 3) for step in (1, 2, 3)]
    device_scene = resident_of(box(), [grey(0.5)], lights=[replace(SUN, intensity=(9.0, 9.0, 9.0)), POINT, *faint])
    table = build_light_table(device_scene)
    table.suns = sun_maps(np.zeros((1, 256, 256), np.int32), device_scene.device)
    maps = make_shadow_maps(device_scene, by_reach(table, None), table.all_emitters, SIDE)
    sun, *others = maps.worth.numpy().tolist()
    assert 0.0 < sun < 0.9
    assert others == [1.0] * 4


def test_the_same_seed_gives_the_same_maps() -> None:
    device_scene = lamp_room()
    first, again, other = (mapped(device_scene, seed)[1].position.numpy().tobytes() for seed in (3, 3, 4))
    assert first == again
    assert first != other


def faces(*rows: tuple[float, float, float]) -> Doubles:
    """Triangles at heights and distances, turned up by an angle."""
    return np.array([[x, y, 0.0, 0.0, np.cos(turn), np.sin(turn)] for x, y, turn in rows])


@pytest.mark.parametrize(
    ("second", "maps"),
    [((0.24, 0.0, 0.0), [0, 0]), ((0.26, 0.0, 0.0), [0, 1]), ((0.0, 0.0, 0.44), [0, 0]), ((0.0, 0.0, 0.46), [0, 1])],
)
def test_triangles_near_each_other_that_face_alike_share_a_map(
    second: tuple[float, float, float], maps: list[int]
) -> None:
    assert map_of_emitters(np.array([0.5, 1.0]), faces((0.0, 0.0, 0.0), second)).tolist() == maps


def test_sky_and_lights_have_maps_of_their_own_while_there_are_enough() -> None:
    few = map_of_emitters((np.arange(MOST) + 1.0) / MOST, faces((0.0, 0.0, 0.0)))
    assert few.tolist() == list(range(MOST))
    ends = np.cumsum(np.append(np.full(MOST, 0.5 / MOST), 0.5))
    many = map_of_emitters(ends, faces((0.0, 0.0, 0.0)))
    # The last has half of the power; the others share maps two by two.
    assert many.tolist() == [*np.repeat(np.arange(MOST // 2), 2), MOST // 2]


def test_a_sun_s_map_looks_closer_where_its_light_matters_and_loses_none() -> None:
    device_scene = resident_of(box(), [grey(0.5)], lights=[SUN])
    seen = np.zeros((1, 256, 256), np.int32)
    seen[0, 100:140, 90:130] = 1
    _, plain = mapped(device_scene)
    _, closer = mapped(device_scene, suns=sun_maps(seen, device_scene.device))
    flux = [vpls.flux.numpy().astype(np.float64).sum(axis=0) for vpls in (plain, closer)]
    assert flux[1] == pytest.approx(flux[0], rel=0.03)
    apart = [
        np.linalg.norm(np.diff(vpls.position.numpy().reshape(-1, 4, 3), axis=1), axis=2) for vpls in (plain, closer)
    ]
    # Neighbours are a quarter as far apart, still as neighbours are.
    assert np.median(apart[1]) < 0.5 * np.median(apart[0])


def test_paper_sends_to_both_sides() -> None:
    color = (1.0, 0.5, 0.25)
    paper = replace(grey(0.8), specular=0.0, diffuse_transmission=0.25, diffuse_transmission_color=color)
    _, vpls = mapped(resident_of(box(), [paper], lights=[POINT]))
    outwards = (vpls.position.numpy() * vpls.normal.numpy()).sum(axis=1) > 0.0
    flux, sent = vpls.flux.numpy().astype(np.float64), 4.0 * np.pi * np.array(POINT.intensity)
    assert flux[~outwards].sum(axis=0) == pytest.approx(0.6 * sent, rel=0.04)
    assert flux[outwards].sum(axis=0) == pytest.approx(0.25 * np.array(color) * sent, rel=0.06)
