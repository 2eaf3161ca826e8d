from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp
from scenes import box, camera_of, grey, quad, resident_of
from trimesh.creation import icosphere

from gpu.core.device import allocate
from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import add_soft_light, direct_samples, trace_direct_light
from gpu.direct.path_tracing import PathSamples, trace_paths
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import chain_samples
from gpu.lights.build import build_light_table
from gpu.scene.camera import look_at
from gpu.scene.load import load_scene
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import AlphaMode, Camera, Doubles, Environment, Light, LightKind, Material, Sky
from gpu.settings import Component

SIZE = (16, 16)
INSIDE = look_at((0.1, 0.0, 0.2), (0.4, 0.2, -0.3), yfov_degrees=90.0)
BULB = Light("bulb", LightKind.POINT, (1.0, 2.0, 4.0), position=(0.1, 0.0, -0.2))


def paths(
    device_scene: DeviceScene,
    camera: Camera = INSIDE,
    component: Component = Component.FULL,
    bounces: int = 4,
    runs: tuple[int, ...] = (16,),
    size: tuple[int, int] = SIZE,
    **options: Any,
) -> Doubles:
    """The path-traced picture (height, width, 3), its samples traced in `runs`."""
    scene = device_scene.view(lambertian=options.get("lambertian", False))
    mean = wp.full(size[0] * size[1], wp.vec3(-7.0, -7.0, -7.0), dtype=wp.vec3, device="cpu")
    table, data = build_light_table(device_scene), camera_of(device_scene, camera, size)
    first = 0
    for samples in runs:
        which = parameters(
            PathSamples,
            count=samples,
            before=first,
            bounces=bounces,
            direct=component is not Component.INDIRECT,
            indirect=component is not Component.DIRECT,
            seed=options.get("seed", 0),
            **{name: value for name, value in options.items() if name == "roulette_bounce"},
        )
        trace_paths(scene, table, data, size, which, mean)
        first += samples
    return np.asarray(mean.numpy(), np.float64).reshape(size[1], size[0], 3)


@pytest.mark.parametrize(("albedo", "bounces"), [(0.5, 16), (0.8, 3)])
def test_a_furnace_has_the_radiance_of_its_series(albedo: float, bounces: int) -> None:
    device_scene = resident_of(box(), [grey(albedo, emission=1.0)])
    expected = sum(albedo**k for k in range(bounces + 2))
    assert paths(device_scene, bounces=bounces, runs=(32,)).mean() == pytest.approx(expected, rel=0.01)
    series = {
        Component.DIRECT: 1.0 + albedo,
        Component.INDIRECT: sum(albedo**k for k in range(2, bounces + 2)),
    }
    for component, value in series.items():
        assert paths(device_scene, component=component, bounces=bounces, runs=(32,)).mean() == pytest.approx(
            value, rel=0.02
        )


def test_a_bulb_in_a_grey_box_lights_all_of_it_as_its_flux_says() -> None:
    device_scene = resident_of(box(), [grey(0.5)], lights=[BULB])
    views = [look_at((0, 0, 0), target, (0.0, 0.3, 1.0), 90.0, 1.0) for axis in np.eye(3) for target in (axis, -axis)]
    # Rays of a 90° view from the middle cover a wall evenly, so the mean picture is the mean radiance of the walls.
    pictures = [paths(device_scene, view, Component.INDIRECT, 2, (64,)).mean(axis=(0, 1)) for view in views]
    flux = 4.0 * np.pi * np.array(BULB.intensity)
    assert np.allclose(np.mean(pictures, axis=0), flux * (0.25 + 0.125) / (6.0 * np.pi), rtol=0.03)


def test_full_is_direct_and_indirect() -> None:
    lamp = quad([-0.1, 0.45, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    device_scene = resident_of([*box(), lamp], [grey(0.6), grey(0.0, emission=5.0)])
    full, direct, indirect = (paths(device_scene, component=component) for component in Component)
    assert np.allclose(full, direct + indirect, rtol=1e-4, atol=1e-6)
    assert (indirect > 0.0).mean() > 0.9


def test_direct_light_is_that_of_the_other_methods() -> None:
    lamp = quad([-0.1, 0.45, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    device_scene = resident_of([*box(), lamp], [grey(0.6), grey(0.0, emission=5.0)], lights=[BULB])
    gbuffer = allocate(GBuffer, SIZE[0] * SIZE[1], device_scene.device)
    trace_primary_rays(
        device_scene.data, camera_of(device_scene, INSIDE, SIZE), SIZE, gbuffer, chain_samples(gbuffer.face.device)
    )
    out = wp.zeros(SIZE[0] * SIZE[1], dtype=wp.vec3, device="cpu")
    soft = wp.zeros_like(out)
    table, moment = build_light_table(device_scene), wp.zeros(1, dtype=int, device="cpu")
    trace_direct_light(device_scene.data, table, gbuffer, SIZE, direct_samples(64, moment, 0), out, soft)
    add_soft_light(gbuffer, soft, out)
    expected = out.numpy().reshape(SIZE[1], SIZE[0], 3)
    picture = paths(device_scene, component=Component.DIRECT, runs=(64,))
    assert np.allclose(picture, expected, rtol=0.05)
    assert np.allclose(picture.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=2e-3)


def test_runs_continue_each_other() -> None:
    device_scene = resident_of(box(), [grey(0.7)], lights=[BULB])
    whole, parts = paths(device_scene, runs=(12,)), paths(device_scene, runs=(5, 4, 3))
    assert np.allclose(whole, parts, rtol=1e-4)
    assert np.array_equal(whole, paths(device_scene, runs=(12,)))
    assert not np.allclose(whole, paths(device_scene, runs=(12,), seed=1), rtol=1e-4)


def test_the_sky_is_met_and_shown() -> None:
    device_scene = resident_of(
        [quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])], [grey(0.5)], sky=Sky((1.0, 2.0, 3.0))
    )
    picture = paths(device_scene, look_at((0.0, 0.1, 0.0), (0.0, 0.0, 1e-3), yfov_degrees=20.0), runs=(64,))
    # Irradiance from above is 5π/6; a flat floor sees nothing else.
    assert np.allclose(picture.mean(axis=(0, 1)), 0.5 * np.array([1.0, 2.0, 3.0]) * 5.0 / 6.0, rtol=0.02)
    above = paths(device_scene, look_at((0.0, 0.1, 0.0), (0.0, 1.0, 1e-3), yfov_degrees=1.0))
    assert np.allclose(above, [1.0, 2.0, 3.0], rtol=0.01)


def test_the_cornell_box_agrees_with_its_reference(shared: Path) -> None:
    reference = np.load(shared / "references" / "cornell-box.npz")
    full, direct = (reference[name].astype(np.float64) for name in ("full", "direct"))
    device_scene = DeviceScene(load_scene(str(shared / "scenes" / "cornell-box.glb")), "cpu")
    camera = device_scene.scene.cameras[0]
    # Every third pixel of the reference in both directions has its centre on one of these.
    for component, reference_light in ((Component.DIRECT, direct), (Component.INDIRECT, full - direct)):
        expected = reference_light[1::3, 1::3]
        picture = paths(device_scene, camera, component, 4, (8,), (256, 256), lambertian=True)
        assert np.allclose(picture.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=0.01)
        ours, theirs = (image.reshape(32, 8, 32, 8, 3).mean(axis=(1, 3)) for image in (picture, expected))
        error = np.mean((ours - theirs) ** 2 / (theirs**2 + 0.01 * theirs.mean() ** 2))
        assert error < 0.01


def test_roulette_begins_at_its_bounce_and_leaves_the_mean() -> None:
    device_scene = resident_of(box(), [grey(0.5)], lights=[BULB])
    usual, early = (paths(device_scene, runs=(64,), **options) for options in ({}, {"roulette_bounce": 0}))
    assert early.mean() == pytest.approx(usual.mean(), rel=0.03)
    assert np.array_equal(paths(device_scene, bounces=2), paths(device_scene, bounces=2, roulette_bounce=9))
    assert not np.array_equal(paths(device_scene, bounces=3), paths(device_scene, bounces=3, roulette_bounce=3))


LAMP = quad([-2.0, -2.0, -1.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 1)
CLEAR = Material(transmission=1.0, roughness=0.0, double_sided=True)
SHUT = quad([-2.0, -2.0, 1.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], 2)  # black, behind the camera


def ahead(height: float = 0.05) -> Camera:
    """Along −Z from z = 0.9, everywhere at the same angle."""
    base = look_at((0.0, 0.0, 0.9), (0.0, 0.0, 0.0))
    return Camera("ahead", base.to_world, height, orthographic=True)


def before_lamp(part: MeshPart | list[MeshPart], material: Material, runs: int = 256, **options: Any) -> Doubles:
    """The mean colour of something before a lamp of radiance 2."""
    parts = part if isinstance(part, list) else [part]
    device_scene = resident_of([*parts, LAMP, SHUT], [material, grey(0.0, emission=2.0), grey(0.0)])
    return np.asarray(paths(device_scene, ahead(), runs=(runs,), size=(8, 8), **options).mean(axis=(0, 1)))


SHEET = quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])


def slab(thickness: float) -> list[MeshPart]:
    """A closed body of parallel faces whose fronts are outside."""
    parts = box(0, 0.5)
    return [
        MeshPart(part.positions * [3.9, 3.9, thickness], part.triangles[:, ::-1], material=part.material)
        for part in parts
    ]


def test_a_mirror_shows_a_lamp_by_its_colour() -> None:
    mirror = Material(base_color=(0.9, 0.5, 0.2, 1.0), metallic=1.0, roughness=0.0)
    lamp = quad([-2.0, -2.0, 1.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], 1)
    device_scene = resident_of([SHEET, lamp], [mirror, grey(0.0, emission=2.0)])
    picture = paths(device_scene, ahead(), runs=(1,), size=(8, 8))
    assert np.allclose(picture, 2.0 * np.array([0.9, 0.5, 0.2]), rtol=1e-5)
    # A mirror's light is direct, as that of any other surface: it was scattered once.
    assert np.allclose(paths(device_scene, ahead(), Component.DIRECT, runs=(1,), size=(8, 8)), picture)
    assert not paths(device_scene, ahead(), Component.INDIRECT, runs=(1,), size=(8, 8)).any()


def test_a_pane_lets_through_what_fresnel_leaves() -> None:
    tinted = replace(CLEAR, base_color=(0.9, 0.5, 0.2, 1.0))
    expected = 2.0 * (1.0 - 2.0 * 0.04 / 1.04) * np.array([0.9, 0.5, 0.2])
    assert np.allclose(before_lamp(SHEET, tinted), expected, rtol=0.01)
    frosted = replace(tinted, roughness=0.15)
    assert np.allclose(before_lamp(SHEET, frosted), expected, rtol=0.02)


def test_a_pane_in_part_shows_what_is_behind_and_itself() -> None:
    """Its glass shows the lamp behind, and the rest is lit by one before it."""
    pane = replace(CLEAR, base_color=(0.9, 0.5, 0.2, 1.0), transmission=0.3, specular=0.0)
    colour = np.array([0.9, 0.5, 0.2])
    assert np.allclose(before_lamp(SHEET, pane), 0.3 * 2.0 * (1.0 - 2.0 * 0.04 / 1.04) * colour, rtol=0.02)
    sun = Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, 0.0, -1.0))
    picture = paths(resident_of([SHEET], [pane], lights=[sun]), ahead(), runs=(256,), size=(8, 8)).mean(axis=(0, 1))
    assert np.allclose(picture, 0.7 * colour / np.pi * 3.0, rtol=0.02)


@pytest.mark.parametrize("roughness", [0.0, 0.15])
def test_a_slab_transmits_by_fresnel_and_beer(roughness: float) -> None:
    colour, distance, thickness = np.array([0.9, 0.5, 0.2]), 0.5, 0.4
    glass = replace(
        CLEAR, thickness=1.0, attenuation_color=tuple(colour), attenuation_distance=distance, roughness=roughness
    )
    inside = colour ** (thickness / distance)
    face = 0.04
    expected = 2.0 * (1.0 - face) ** 2 * inside / (1.0 - (face * inside) ** 2)
    found = before_lamp(slab(thickness), glass, 512, bounces=8)
    assert np.allclose(found, expected, rtol=0.01 if roughness == 0.0 else 0.03)


def test_glass_is_not_seen_in_a_furnace() -> None:
    parts = [MeshPart(p.positions * 0.4, p.triangles[:, ::-1], material=1) for p in box()]
    for glass in (replace(CLEAR, thickness=1.0), CLEAR):
        device_scene = resident_of([*box(), *parts], [grey(0.0, emission=1.0), glass])
        picture = paths(device_scene, look_at((0.4, 0.35, 0.45), (0.0, 0.0, 0.0)), bounces=16, runs=(64,))
        assert picture.mean() == pytest.approx(1.0, abs=0.01)
        assert np.allclose(picture, 1.0, atol=0.5)


def test_alpha_is_the_share_that_is_there() -> None:
    veil = Material(base_color=(0.0, 0.0, 0.0, 0.3), specular=0.0, alpha_mode=AlphaMode.BLEND)
    assert np.allclose(before_lamp(SHEET, veil), 2.0 * 0.7, rtol=0.02)
    floor = quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1)
    above = quad([-0.5, 0.3, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 0)
    sun = Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, -1.0, 0.0))
    device_scene = resident_of([floor, above], [veil, grey(0.5)], lights=[sun])
    base = look_at((0.4, 0.25, 0.0), (0.0, 0.0, 0.0))
    camera = Camera("low", base.to_world, 0.01, orthographic=True)
    picture = paths(device_scene, camera, runs=(256,), size=(8, 8))
    assert picture.mean() == pytest.approx(0.7 * 0.5 / np.pi * 3.0, rel=0.01)


@pytest.mark.parametrize(("transmission", "alpha"), [(1.0, 1.0), (0.6, 1.0), (0.3, 1.0), (0.3, 0.5)])
def test_light_through_a_pane_is_sampled_and_tinted(transmission: float, alpha: float) -> None:
    tinted = replace(CLEAR, base_color=(0.9, 0.5, 0.2, alpha), transmission=transmission)
    if alpha < 1.0:
        tinted = replace(tinted, alpha_mode=AlphaMode.BLEND)
    floor = quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1)
    above = quad([-0.5, 0.3, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 0)
    sun = Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, -1.0, 0.0))
    device_scene = resident_of([floor, above], [tinted, grey(0.5)], lights=[sun])
    camera = Camera("low", look_at((0.4, 0.25, 0.0), (0.0, 0.0, 0.0)).to_world, 0.01, orthographic=True)
    picture = paths(device_scene, camera, Component.DIRECT, runs=(1,), size=(8, 8))
    through = (1.0 - alpha) + alpha * transmission * np.array([0.9, 0.5, 0.2]) * (1.0 - 2.0 * 0.04 / 1.04)
    assert np.allclose(picture, through * 0.5 / np.pi * 3.0, rtol=1e-3)


def test_what_is_merely_shown_is_seen_in_mirrors_and_through_glass() -> None:
    sign = Material(base_color=(0.2, 0.4, 0.6, 1.0), unlit=True)
    back = quad([-2.0, -2.0, -1.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 1)
    device_scene = resident_of([SHEET, back, SHUT], [CLEAR, sign, grey(0.0)])
    picture = paths(device_scene, ahead(), runs=(256,), size=(8, 8)).mean(axis=(0, 1))
    assert np.allclose(picture, np.array([0.2, 0.4, 0.6]) / 1.04 * 0.96, rtol=0.02)


def spotted(height: int = 16) -> Environment:
    """Light from all around with a small sun, of radiance 1 on the average of the upper half, seen from a floor."""
    pixels = np.full((height, 2 * height, 3), 0.5, np.float32)
    pixels[height // 4, 3] = 200.0
    return Environment("spotted", pixels)


def test_nothing_white_is_seen_in_an_even_environment() -> None:
    even = Environment("even", np.ones((4, 8, 3), np.float32))
    parts = [MeshPart(p.positions * 0.4, p.triangles[:, ::-1]) for p in box()]
    for material in (grey(1.0), replace(CLEAR, thickness=1.0), Material(metallic=1.0, roughness=0.0)):
        device_scene = resident_of(parts, [material], sky=even)
        picture = paths(device_scene, look_at((0.4, 0.35, 0.45), (0.0, 0.0, 0.0)), bounces=8, runs=(16,))
        assert picture.mean() == pytest.approx(1.0, abs=0.01)


def test_glass_on_a_white_floor_is_not_seen_in_an_even_environment() -> None:
    even, mesh = Environment("even", np.ones((4, 8, 3), np.float32)), icosphere(3, 0.24)
    points = np.asarray(mesh.vertices)
    ball = MeshPart(points, np.asarray(mesh.faces), normals=points / 0.24)
    floor = quad([-0.5, -0.25, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1)
    device_scene = resident_of([ball, floor], [replace(CLEAR, thickness=1.0), grey(1.0)], sky=even)
    above = look_at((0.0, 0.6, 0.0), (0.0, -0.25, 0.0), (0.0, 0.0, 1.0), yfov_degrees=40.0)
    # The floor's light through the ball, and its caustic and shadow beside it, from the same environment.
    assert paths(device_scene, above, bounces=16, runs=(64,)).mean() == pytest.approx(1.0, abs=0.01)


def test_an_environment_lights_and_is_seen_in_mirrors() -> None:
    sky, up = spotted(), quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    camera = Camera("down", look_at((0.0, 0.2, 0.0), (0.0, 0.0, 0.0)).to_world, 0.05, orthographic=True)
    angle = (0.5 - (np.arange(32) + 0.5) / 32) * 2.0 * np.pi
    edges = np.cos(np.pi * np.arange(17) / 16)
    # The irradiance of each row's pixels: cosine over solid angle.
    rows = np.clip(edges, 0.0, None) ** 2
    expected = (sky.pixels[..., 0].sum(axis=1) * (rows[:-1] - rows[1:]) / 2.0 * 2.0 * np.pi / 32).sum()
    lit = paths(resident_of([up], [grey(0.5)], sky=sky), camera, runs=(256,), size=(16, 16))
    assert lit.mean() == pytest.approx(0.5 / np.pi * expected, rel=0.02)
    mirror = Material(metallic=1.0, roughness=0.0)
    eye = np.array([np.sin(angle[3] + np.pi) * 0.3, 0.3 / np.tan(np.pi * 4.5 / 16), np.cos(angle[3] + np.pi) * 0.3])
    towards = look_at(eye, (0.0, 0.0, 0.0), yfov_degrees=0.1)
    assert np.allclose(paths(resident_of([up], [mirror], sky=sky), towards, runs=(1,)), 200.0, rtol=0.1)


def test_a_coat_reflects_over_what_is_below() -> None:
    even, up = Environment("even", np.ones((4, 8, 3), np.float32)), quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0])
    camera = Camera("down", look_at((0.0, 0.2, 0.0), (0.0, 0.0, 0.0)).to_world, 0.05, orthographic=True)
    for albedo, expected in ((0.0, 0.04), (1.0, 1.0)):
        coated = replace(grey(albedo), clearcoat=1.0, clearcoat_roughness=0.2)
        picture = paths(resident_of([up], [coated], sky=even), camera, runs=(256,), size=(16, 16))
        assert picture.mean() == pytest.approx(expected, rel=0.03)


def test_cloth_shines_when_it_is_seen_from_along_it() -> None:
    """Black velvet in even light sends back what its fibres do."""
    even, up = Environment("even", np.ones((4, 8, 3), np.float32)), quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0])
    velvet = replace(grey(0.0), sheen_color=(1.0, 0.5, 0.0), sheen_roughness=0.5)
    for cosine, expected in ((1.0, 0.027), (0.5, 0.188), (0.1, 0.567)):
        eye = np.array([np.sqrt(1.0 - cosine**2), cosine, 0.0]) * 0.2
        camera = Camera("spot", look_at(eye, (0.0, 0.0, 0.0)).to_world, 1e-3, orthographic=True)
        picture = paths(resident_of([up], [velvet], sky=even), camera, runs=(256,), size=(16, 16)).mean(axis=(0, 1))
        assert picture == pytest.approx(np.array([1.0, 0.5, 0.0]) * expected, abs=0.012)


def test_a_film_mirrors_in_colours_of_the_angle() -> None:
    """As gpu.device_scene.thin_film tells, whose tests compare it with the extension's formulas."""
    even, up = Environment("even", np.ones((4, 8, 3), np.float32)), quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0])
    film = Material(base_color=(0.5, 0.5, 0.5, 1.0), metallic=1.0, roughness=0.0, iridescence=1.0, iridescence_most=300)
    for cosine, expected in ((1.0, (0.436, 0.312, 0.411)), (0.5, (0.586, 0.551, 0.383))):
        eye = np.array([np.sqrt(1.0 - cosine**2), cosine, 0.0]) * 0.2
        camera = Camera("spot", look_at(eye, (0.0, 0.0, 0.0)).to_world, 1e-3, orthographic=True)
        picture = paths(resident_of([up], [film], sky=even), camera, runs=(1,), size=(4, 4))
        assert np.allclose(picture, expected, atol=0.005)


PAPER = replace(
    grey(0.8), specular=0.0, diffuse_transmission=0.5, diffuse_transmission_color=(0.5, 0.25, 0.125), double_sided=True
)


@pytest.mark.parametrize("height", [0.2, -0.2])
def test_paper_shows_light_from_either_side(height: float) -> None:
    """Light of 1 W/m²/sr from above: the lit side reflects 0.8 of one half, the other shows the colour of the rest."""
    sky = Environment("above", np.concatenate([np.ones((32, 8, 3)), np.zeros((32, 8, 3))]).astype(np.float32))
    sheet = quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0])
    camera = Camera("spot", look_at((0.0, height, 0.01), (0.0, 0.0, 0.0)).to_world, 0.05, orthographic=True)
    picture = paths(resident_of([sheet], [PAPER], sky=sky), camera, runs=(256,), size=(16, 16)).mean(axis=(0, 1))
    assert picture == pytest.approx((0.4, 0.4, 0.4) if height > 0.0 else (0.25, 0.125, 0.0625), rel=0.02)


def test_light_goes_on_to_walls_behind_paper() -> None:
    """A far sun on a large sheet close above a floor: what comes through lights that, and is lit from below again."""
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    sheet = quad([-0.5, 0.0, -0.5], [0, 0, 1], [1, 0, 0], 0)
    floor = quad([-0.5, -0.002, -0.5], [0, 0, 1], [1, 0, 0], 1)
    camera = look_at((0.0, -0.001, 0.0), (0.0, -0.002, 0.0), (0.0, 0.0, 1.0), yfov_degrees=60.0)
    scene = resident_of([sheet, floor], [PAPER, grey(0.5)], lights=[sun])
    found = paths(scene, camera, Component.INDIRECT, 12, (256,), (16, 16)).mean(axis=(0, 1))
    through = 0.5 * np.array(PAPER.diffuse_transmission_color)
    assert found * np.pi == pytest.approx(through * 0.5 / (1.0 - 0.5 * 0.4), rel=0.03)
