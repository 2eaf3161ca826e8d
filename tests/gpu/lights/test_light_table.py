import numpy as np
import pytest
import warp as wp
from emitters import DOWN, POINT, SPOT, SUN, lamp_room, share_kernel
from scenes import box, grey, quad, resident_of, results
from scipy import stats

from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_table import (
    NOT_AN_EMITTER,
    LightTable,
    PowerCdf,
    choose_emitter,
    emit,
    emitter_of,
)
from gpu.sampling.sobol import hashed, sobol_pair
from gpu.scene.types import Doubles, Light, LightKind, Material, Sky, Texture, TextureSlot

COUNT = 1 << 14


@wp.kernel
def choose_kernel(first: int, shares: PowerCdf, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    choice = choose_emitter(shares, hashed(wp.uint32(index)))
    out[index] = wp.vec2(float(choice.index), choice.probability)


@wp.kernel
def emitter_kernel(first: int, table: LightTable, out: wp.array[int]) -> None:
    index = first + wp.tid()
    out[index] = emitter_of(table, index)


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


def test_emitters_are_chosen_in_proportion_to_power() -> None:
    device_scene = lamp_room(lights=[POINT, SPOT, SUN], sky=Sky((0.1, 0.2, 0.3)))
    table = build_light_table(device_scene)
    assert table.all_emitters.count == 2 + 1 + 3
    radius = table.radius
    assert radius == pytest.approx(0.75**0.5)
    lamp = np.pi * 3.0 * 0.04 / 2.0
    powers = [lamp, lamp, 0.2 * 2.0 * (np.pi * radius) ** 2, 2.0 * 4.0 * np.pi, 3.0 * 2.0 * np.pi * 0.4,
              3.5 / 3.0 * np.pi * radius**2]  # fmt: skip
    chosen = results(choose_kernel, COUNT, [table.all_emitters], wp.vec2)
    counts = np.bincount(chosen[:, 0].astype(int), minlength=6)
    expected = np.array(powers) / np.sum(powers)
    assert stats.chisquare(counts, expected * COUNT).pvalue > 1e-3
    assert np.allclose(chosen[:, 1], expected[chosen[:, 0].astype(int)], rtol=1e-4)
    assert results(share_kernel, 6, [table.all_emitters], float).sum() == pytest.approx(1.0, abs=1e-6)


def test_each_emissive_triangle_is_found_among_all() -> None:
    device_scene = lamp_room()
    emitters = results(emitter_kernel, 14, [build_light_table(device_scene)], int)
    assert emitters[12:].tolist() == [0, 1]
    assert (emitters[:12] == int(NOT_AN_EMITTER)).all()


@pytest.mark.parametrize("kind", ["lamp", "point", "spot", "sun", "sky", "all"])
def test_particles_carry_the_power_of_all_emitters(kind: str) -> None:
    radius_squared = 0.75
    power = {
        "lamp": np.full(3, np.pi * 3.0 * 0.04),
        "point": 4.0 * np.pi * np.array(POINT.intensity),
        # The falloff's integral over the cosine is 0.1 for the inner cone and a third of 0.3 for the rest.
        "spot": 2.0 * np.pi * 0.2 * np.array(SPOT.intensity),
        "sun": np.pi * radius_squared * np.array(SUN.intensity),
        "sky": 2.0 * np.pi**2 * radius_squared * np.array([0.1, 0.2, 0.3]),
    }
    sources = {"point": POINT, "spot": SPOT, "sun": SUN}
    if kind == "all":
        device_scene = lamp_room(lights=[*sources.values()], sky=Sky((0.1, 0.2, 0.3)))
        expected = np.sum(list(power.values()), axis=0)
    elif kind == "lamp":
        device_scene, expected = lamp_room(), power["lamp"]
    else:
        lights = [sources[kind]] if kind in sources else []
        sky = Sky((0.1, 0.2, 0.3)) if kind == "sky" else None
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


def test_textured_emission_keeps_its_power() -> None:
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[:, :4, :3] = 0
    lamp = Material(emission=(2.0, 2.0, 2.0), emission_slot=TextureSlot(0))
    device_scene = resident_of([quad([-0.5, 0, -0.5], [1, 0, 0], [0, 0, 1])], [lamp],
                           textures=[Texture("half", pixels, srgb=True, nearest=True)])  # fmt: skip
    assert np.allclose(particles(device_scene)[:, 3].mean(axis=0), np.pi, rtol=0.02)


def test_shares_hold_for_lights_of_no_power() -> None:
    dark = Light("dark", LightKind.POINT, (0.0, 0.0, 0.0))
    device_scene = resident_of(box(), [grey(0.5)], lights=[POINT, dark])
    table = build_light_table(device_scene)
    chosen = results(choose_kernel, COUNT, [table.all_emitters], wp.vec2)
    assert (chosen[:, 0] == 0).all()
    assert np.isfinite(particles(device_scene)).all()
