"""Irradiance from samples against closed forms, and densities against what they must integrate to."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from scenes import grey, quad, rectangle_over, resident_of, results

from gpu.core.constants import PI
from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table, emitters_of
from gpu.lights.light_sampling import light_at_hit, sample_light
from gpu.lights.light_table import LightTable
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cone_direction
from gpu.scene.types import AlphaMode, Doubles, Light, LightKind, Sky, Texture, TextureSlot

COUNT = 1 << 13
FLOOR = quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])


@wp.kernel
def irradiance_kernel(first: int, scene: SceneData, table: LightTable, position: wp.vec3, normal: wp.vec3,
                      out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    pick = sobol_pair(index, 0, 3)
    sample = sample_light(scene, table, table.all_emitters, position, pick.a, sobol_pair(index, 1, 3))
    out[index] = sample.irradiance * wp.max(wp.dot(sample.direction, normal), 0.0)


@wp.kernel
def met_kernel(first: int, scene: SceneData, table: LightTable, position: wp.vec3, out: wp.array[float]) -> None:
    """The density of the light that is met in a uniform direction, over the density of that direction."""
    index = first + wp.tid()
    place = sobol_pair(index, 0, 4)
    direction = cone_direction(wp.vec3(0.0, 1.0, 0.0), -1.0, place.x, place.y)
    hit = closest_hit(scene, position, direction, 10.0)
    found = light_at_hit(scene, table, table.all_emitters, position, direction, hit)
    out[index] = found.density * 4.0 * PI


@wp.kernel
def agreement_kernel(first: int, scene: SceneData, table: LightTable, position: wp.vec3,
                     out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """(density · solid angle, irradiance over it, radiance) of one light sample and of the ray along it."""
    index = first + wp.tid()
    pick = sobol_pair(index, 0, 5)
    sample = sample_light(scene, table, table.all_emitters, position, pick.a, sobol_pair(index, 1, 5))
    hit = closest_hit(scene, position, sample.direction, 10.0)
    found = light_at_hit(scene, table, table.all_emitters, position, sample.direction, hit)
    out[index] = wp.vec3(
        found.density * sample.solid_angle, sample.irradiance[0] / sample.solid_angle, found.radiance[0]
    )


@wp.kernel
def solid_angle_kernel(first: int, scene: SceneData, table: LightTable, position: wp.vec3,
                       out: wp.array[float]) -> None:  # fmt: skip
    """The solid angle that each light sample stands for."""
    index = first + wp.tid()
    pick = sobol_pair(index, 0, 3)
    sample = sample_light(scene, table, table.all_emitters, position, pick.a, sobol_pair(index, 1, 3))
    out[index] = sample.solid_angle


def irradiance(device_scene: DeviceScene, position: Any, normal: Any = (0.0, 1.0, 0.0)) -> Doubles:
    inputs = [device_scene.data, build_light_table(device_scene), wp.vec3(*position), wp.vec3(*normal)]
    return np.asarray(results(irradiance_kernel, COUNT, inputs, wp.vec3).mean(axis=0))


@pytest.mark.parametrize("height", [0.02, 0.2, 0.8])
def test_a_rectangle_overhead(height: float) -> None:
    lamp = quad([-0.2, height, -0.1], [0.4, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    device_scene = resident_of([FLOOR, lamp], [grey(0.5), grey(0.0, emission=2.0)])
    middle = -height / 2.0  # the scene is centred: its floor is half the height below
    got = irradiance(device_scene, (0.0, middle, 0.0))
    assert np.allclose(got, np.pi * 2.0 * rectangle_over(0.2, 0.1, height), rtol=0.01)


def test_a_lamp_lights_nothing_behind_it() -> None:
    lamp = quad([-0.2, 0.5, -0.1], [0.0, 0.0, 0.2], [0.4, 0.0, 0.0], 1)
    device_scene = resident_of([FLOOR, lamp], [grey(0.5), grey(0.0, emission=2.0)])
    assert np.allclose(irradiance(device_scene, (0.0, -0.25, 0.0)), 0.0)


@pytest.mark.parametrize("height", [0.1, 0.8])
@pytest.mark.parametrize("turned", [False, True])
def test_a_two_sided_lamp_lights_both_sides_by_all_of_its_radiance(height: float, turned: bool) -> None:
    edges = [[0.4, 0.0, 0.0], [0.0, 0.0, 0.2]]
    lamp = quad([-0.2, height, -0.1], *(edges[::-1] if turned else edges), 1)
    material = replace(grey(0.0, emission=2.0), double_sided=True)
    got = irradiance(resident_of([FLOOR, lamp], [grey(0.5), material]), (0.0, -height / 2.0, 0.0))
    assert np.allclose(got, np.pi * 2.0 * rectangle_over(0.2, 0.1, height), rtol=0.01)


@pytest.mark.parametrize("height", [0.1, 0.8])
def test_a_lamp_lights_nothing_where_alpha_has_cut_it_away(height: float) -> None:
    """A lamp of twice the width whose outer quarters are cut away is the lamp of above."""
    pixels = np.full((1, 8, 4), 255, np.uint8)
    pixels[:, [0, 1, 6, 7], 3] = 0
    sign = replace(grey(0.0, emission=2.0), alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0))
    lamp = quad([-0.4, height, -0.1], [0.8, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    textures = [Texture("letters", pixels, srgb=True, nearest=True)]
    device_scene = resident_of([FLOOR, lamp], [grey(0.5), sign], textures=textures)
    got = irradiance(device_scene, (0.0, -height / 2.0, 0.0))
    assert np.allclose(got, np.pi * 2.0 * rectangle_over(0.2, 0.1, height), rtol=0.02)


def test_punctual_lights() -> None:
    point = Light("point", LightKind.POINT, (1.0, 2.0, 3.0), position=(0.3, 0.4, 0.0))
    device_scene = resident_of([FLOOR], [grey(0.5)], lights=[point])
    assert np.allclose(irradiance(device_scene, (0.0, 0.0, 0.0)), np.array([1, 2, 3]) * 0.8 / 0.25, rtol=1e-4)
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 2.0, 3.0), direction=(0.6, -0.8, 0.0))
    device_scene = resident_of([FLOOR], [grey(0.5)], lights=[sun])
    assert np.allclose(irradiance(device_scene, (0.1, 0.0, 0.2)), np.array([1, 2, 3]) * 0.8, rtol=1e-4)


@pytest.mark.parametrize(("cosine", "share"), [(0.95, 1.0), (0.75, 0.25), (0.5, 0.0)])
def test_a_spot_fades_from_its_inner_to_its_outer_cone(cosine: float, share: float) -> None:
    sine = (1.0 - cosine**2) ** 0.5
    spot = Light("spot", LightKind.SPOT, (2.0, 2.0, 2.0), position=(-sine * 0.4, cosine * 0.4, 0.0),
                 direction=(0.0, -1.0, 0.0), cos_inner=0.9, cos_outer=0.6)  # fmt: skip
    device_scene = resident_of([FLOOR], [grey(0.5)], lights=[spot])
    assert np.allclose(irradiance(device_scene, (0.0, 0.0, 0.0)), 2.0 * share * cosine / 0.16, rtol=1e-3)


def test_the_sky_is_brightest_above() -> None:
    device_scene = resident_of([FLOOR], [grey(0.5)], sky=Sky((1.0, 2.0, 3.0)))
    sky = np.array([1.0, 2.0, 3.0])
    assert np.allclose(irradiance(device_scene, (0, 0, 0)), sky * np.pi * 5.0 / 6.0, rtol=0.01)
    assert np.allclose(irradiance(device_scene, (0, 0, 0), (0, -1, 0)), sky * np.pi / 6.0, rtol=0.02)
    assert np.allclose(irradiance(device_scene, (0, 0, 0), (1, 0, 0)), sky * np.pi / 2.0, rtol=0.02)


def lamps(sides: bool | None = False, **rest: Any) -> DeviceScene:
    """A near lamp, sampled by solid angle, and a far one, sampled by area, both facing down, or up if two-sided."""
    edges = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]][:: -1 if sides else 1]
    near = quad([-0.5, 0.1, -0.3], *(np.multiply(0.6, edge) for edge in edges), 1)
    far = quad([0.3, 0.9, 0.2], *(np.multiply(0.1, edge) for edge in edges), 2)
    materials = [replace(grey(0.0, emission), double_sided=sides) for emission in (2.0, 60.0)]
    return resident_of([FLOOR, near, far], [grey(0.5), *materials], **rest)


@pytest.mark.parametrize("sides", [False, True])
def test_the_density_of_met_light_integrates_to_one(sides: bool | None) -> None:
    device_scene = lamps(sides)
    inputs = [device_scene.data, build_light_table(device_scene), wp.vec3(0.1, -0.44, 0.1)]
    assert results(met_kernel, 1 << 17, inputs, float).mean() == pytest.approx(1.0, rel=0.03)


@pytest.mark.parametrize("sides", [False, True])
def test_sampling_and_meeting_the_same_light_agree(sides: bool | None) -> None:
    device_scene = lamps(sides, sky=Sky((0.5, 0.5, 0.5)))
    inputs = [device_scene.data, build_light_table(device_scene), wp.vec3(0.1, -0.44, 0.1)]
    product, sampled, met = results(agreement_kernel, COUNT, inputs, wp.vec3).T
    # A sample that something hides meets another light, or none.
    same = np.isclose(sampled, met, rtol=1e-3)
    assert same.mean() > 0.5
    assert np.allclose(product[same], 1.0, rtol=5e-3)
    for radiance in (2.0, 60.0):
        assert np.isclose(sampled, radiance).sum() > 50


@pytest.mark.parametrize(
    ("height", "options", "even"),
    [
        (0.7, {}, True),  # each triangle is seen as 0.14 sr
        (0.9, {}, False),  # 0.09 sr
        (0.7, {"min_solid_angle": 0.2}, False),
        (0.9, {"min_solid_angle": 0.05}, True),
    ],
)
def test_triangles_that_are_seen_large_are_sampled_evenly_in_solid_angle(
    height: float, options: dict[str, float], even: bool
) -> None:
    lamp = quad([-0.2, height, -0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4], 1)
    device_scene = resident_of([FLOOR, lamp], [grey(0.5), grey(0.0, emission=2.0)])
    inputs = [device_scene.data, emitters_of(device_scene, **options).table, wp.vec3(0.0, -height / 2.0, 0.0)]
    solid_angles = results(solid_angle_kernel, 256, inputs, float)
    assert (np.ptp(solid_angles) < 1e-3 * solid_angles.mean()) == even


def test_a_lamp_lights_nothing_in_its_own_plane() -> None:
    lamp = quad([-0.5, -0.3, -0.5], [1.0, 0.1, 0.0], [0.0, 0.6, 1.0], 0)
    device_scene = resident_of([lamp], [grey(0.0, emission=2.0)])
    corners = device_scene.data.vertices.numpy()[device_scene.data.triangles.numpy()[0]]
    along = corners[1] - corners[0]
    for place in np.random.default_rng(0).dirichlet((1.0, 1.0, 1.0), 20):
        # Rounding puts points of the plane on either side of it.
        assert irradiance(device_scene, place @ corners, along / np.linalg.norm(along)).max() < 1e-3
