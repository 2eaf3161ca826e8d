import numpy as np
import pytest
import warp as wp
from emitters import DOWN, POINT, SPOT, SUN, lamp_room
from scenes import box, grey, quad, resident_of, results
from scipy import stats

from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.emission import emit
from gpu.lights.light_table import (
    LightTable,
)
from gpu.sampling.sobol import sobol_pair
from gpu.scene.types import AlphaMode, Doubles, Environment, Light, LightKind, Material, Sky, Texture, TextureSlot

COUNT = 1 << 14


@wp.kernel
def emit_kernel(first: int, scene: SceneData, table: LightTable, out: wp.array[wp.vec3]) -> None:
    """Origin, normal, direction and flux of each particle."""
    index = first + wp.tid()
    pick = sobol_pair(index, 0, 1)
    particle = emit(scene, table, pick.a, sobol_pair(index, 1, 1), sobol_pair(index, 2, 1))
    out[4 * index] = particle.origin
    out[4 * index + 1] = particle.normal
    out[4 * index + 2] = particle.direction
    out[4 * index + 3] = particle.flux


def particles(device_scene: DeviceScene) -> Doubles:
    """(particle, 4, 3): origin, normal, direction, flux."""
    table = build_light_table(device_scene)
    return results(emit_kernel, COUNT, [device_scene.data, table], wp.vec3, width=4).reshape(-1, 4, 3)


@pytest.mark.parametrize("kind", ["lamp", "point", "spot", "sun", "sky", "environment", "all"])
def test_particles_carry_the_power_of_all_emitters(kind: str) -> None:
    radius_squared = 0.75
    power = {
        "lamp": np.full(3, np.pi * 3.0 * 0.04),
        "point": 4.0 * np.pi * np.array(POINT.intensity),
        # The falloff's integral over the cosine is 0.1 for the inner cone and a third of 0.3 for the rest.
        "spot": 2.0 * np.pi * 0.2 * np.array(SPOT.intensity),
        "sun": np.pi * radius_squared * np.array(SUN.intensity),
        "environment": 4.0 * np.pi**2 * radius_squared * np.array([0.1, 0.2, 0.3]),
        "sky": 2.0 * np.pi**2 * radius_squared * np.array([0.1, 0.2, 0.3]),
    }
    sources = {"point": POINT, "spot": SPOT, "sun": SUN}
    if kind == "all":
        device_scene = lamp_room(lights=[*sources.values()], sky=Sky((0.1, 0.2, 0.3)))
        expected = np.sum([of for name, of in power.items() if name != "environment"], axis=0)
    elif kind == "lamp":
        device_scene, expected = lamp_room(), power["lamp"]
    else:
        lights = [sources[kind]] if kind in sources else []
        even = Environment("even", np.tile(np.float32([0.1, 0.2, 0.3]), (4, 8, 1)))
        sky = {"sky": Sky((0.1, 0.2, 0.3)), "environment": even}.get(kind)
        device_scene, expected = resident_of(box(), [grey(0.5)], lights=lights, sky=sky), power[kind]
    flux = particles(device_scene)[:, 3]
    assert np.allclose(flux.mean(axis=0), expected, rtol=0.01)


def test_particles_leave_the_front_of_lamps_and_cover_the_scene_from_afar() -> None:
    origin, normal, direction, _ = np.moveaxis(particles(lamp_room()), 1, 0)
    assert np.allclose(normal, DOWN, atol=1e-6)
    assert np.allclose(origin[:, 1], 0.45, atol=1e-6)
    assert (np.abs(origin[:, [0, 2]]) <= 0.1 + 1e-6).all()
    assert (direction[:, 1] < 0.0).all()
    origin, normal, direction, _ = np.moveaxis(particles(resident_of(box(), [grey(0.5)], lights=[SUN])), 1, 0)
    assert np.allclose(direction, SUN.direction, atol=1e-6)
    assert not normal.any()
    past = np.linalg.norm(np.cross(origin, direction), axis=1)
    assert stats.chisquare(np.histogram(past**2 / 0.75, 32, (0.0, 1.0))[0]).pvalue > 1e-3
    assert (np.sum(origin * direction, axis=1) < -1.0).all()


def test_two_sided_lamps_send_as_much_from_their_backs() -> None:
    lamp = Material(emission=(2.0, 2.0, 2.0), double_sided=True)
    found = particles(resident_of([quad([-0.5, 0, -0.5], [1, 0, 0], [0, 0, 1])], [lamp]))
    assert np.allclose(found[:, 3].mean(axis=0), 4.0 * np.pi, rtol=0.01)
    assert (np.sum(found[:, 1] * found[:, 2], axis=1) > 0.0).all()
    for side in (-1.0, 1.0):
        own = np.abs(found[found[:, 1, 1] * side > 0.0, 2, 1])
        assert len(own) == pytest.approx(COUNT / 2, rel=0.01)
        assert stats.chisquare(np.histogram(own**2, 32, (0.0, 1.0))[0]).pvalue > 1e-3


def test_what_alpha_cuts_away_sends_nothing() -> None:
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[:, :6, 3] = 0
    lamp = Material(emission=(2.0, 2.0, 2.0), alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0))
    device_scene = resident_of([quad([-0.5, 0, -0.5], [1, 0, 0], [0, 0, 1])], [lamp],
                           textures=[Texture("quarter", pixels, srgb=True, nearest=True)])  # fmt: skip
    found = particles(device_scene)
    assert np.allclose(found[:, 3].mean(axis=0), np.pi / 2.0, rtol=0.02)
    assert (found[found[:, 3, 0] > 0.0, 0, 0] > 0.25 - 1e-6).all()


def test_textured_emission_keeps_its_power() -> None:
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[:, :4, :3] = 0
    lamp = Material(emission=(2.0, 2.0, 2.0), emission_slot=TextureSlot(0))
    device_scene = resident_of([quad([-0.5, 0, -0.5], [1, 0, 0], [0, 0, 1])], [lamp],
                           textures=[Texture("half", pixels, srgb=True, nearest=True)])  # fmt: skip
    assert np.allclose(particles(device_scene)[:, 3].mean(axis=0), np.pi, rtol=0.02)


def test_particles_are_finite_beside_lights_of_no_power() -> None:
    dark = Light("dark", LightKind.POINT, (0.0, 0.0, 0.0))
    found = particles(resident_of(box(), [grey(0.5)], lights=[POINT, dark]))
    assert np.isfinite(found).all()
    assert np.linalg.norm(found[:, 2], axis=1) == pytest.approx(1.0, abs=1e-5)
