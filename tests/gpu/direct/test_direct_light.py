from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from scenes import box, camera_of, grey, quad, rectangle_over, resident_of, results

from gpu.core.device import allocate
from gpu.device_scene.bsdf import reflected
from gpu.device_scene.features import MAX_ENUMERATED
from gpu.device_scene.surface import Surface
from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import add_soft_light, direct_samples, trace_direct_light
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import chain_samples
from gpu.lights.build import build_light_table
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles, Environment, Light, LightKind, Material, Sky

SIZE = (32, 32)
GRID = wp.constant(200)
UP = (0.0, 1.0, 0.0)


def direct(
    device_scene: DeviceScene, camera: Camera, samples: int = 1, seed: int = 0, frame: int = 0, **view: Any
) -> Doubles:
    """What `camera` sees of direct light, (height, width, 3)."""
    scene = device_scene.view(lambertian=view.get("lambertian", False))
    gbuffer = allocate(GBuffer, SIZE[0] * SIZE[1], device_scene.device)
    trace_primary_rays(scene, camera_of(device_scene, camera, SIZE), SIZE, gbuffer, chain_samples(device_scene.device))
    out = wp.full(SIZE[0] * SIZE[1], wp.vec3(-7.0, -7.0, -7.0), dtype=wp.vec3, device="cpu")
    soft = wp.zeros_like(out)
    table, moment = build_light_table(device_scene), wp.full(1, frame, dtype=int, device="cpu")
    which = direct_samples(samples, moment, seed, known=view.get("known"), settled=view.get("settled", 0))
    trace_direct_light(scene, table, gbuffer, SIZE, which, out, soft)
    add_soft_light(gbuffer, soft, out)
    return np.asarray(out.numpy(), np.float64).reshape(SIZE[1], SIZE[0], 3)


@wp.kernel
def sun_kernel(first: int, surface: Surface, view: wp.vec3, light: wp.vec3, out: wp.array[wp.vec3]) -> None:
    out[first + wp.tid()] = reflected(surface, view, light)


def floor(material: int = 0) -> Any:
    """A unit square in the plane y = 0 that faces up."""
    return quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], material)


def down_at(x: float, z: float, size: float = 1e-3) -> Camera:
    """A camera that sees the floor at one place."""
    base = look_at((x, 0.1, z), (x, 0.0, z))
    return Camera("down", base.to_world, size, orthographic=True)


SUN = Light("sun", LightKind.DIRECTIONAL, (3.0, 2.0, 1.0), direction=(0.6, -0.8, 0.0))


def test_the_sun_is_exact_and_its_shadow_hard() -> None:
    blocker = quad([0.1, 0.4, -0.1], [0.0, 0.0, 0.2], [0.2, 0.0, 0.0])  # its shadow moves by 0.3 along x
    device_scene = resident_of([floor(), blocker], [grey(0.5)], lights=[SUN])
    lift = np.array([0.0, 0.2, 0.0])  # to the world's floor from unit space's
    assert np.allclose(device_scene.scene.placement.centre, lift)
    lit = direct(device_scene, down_at(0.2, 0.3, 0.05))
    assert np.allclose(lit, 0.5 / np.pi * 0.8 * np.array(SUN.intensity), rtol=1e-4)
    edge = direct(
        device_scene, Camera("down", look_at((0.4, 0.3, 0.0), (0.4, 0.0, 0.0)).to_world, 0.16, orthographic=True)
    )
    dark = edge.max(axis=2) == 0.0
    assert np.isin(edge[..., 0], [0.0, edge.max()]).mean() > 0.99
    assert dark.mean() == pytest.approx(0.04 / 0.1024, abs=0.03)


@pytest.mark.parametrize(("samples", "half"), [(4, 2), (3, 2), (1, 1)])
def test_pixels_whose_light_is_known_of_many_frames_take_half_the_samples(samples: int, half: int) -> None:
    lamp = quad([-0.5, 0.5, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1)
    device_scene = resident_of([floor(), lamp], [grey(0.5), grey(0.0, 5.0)])
    frames = np.tile([4, 5, 0, 8], SIZE[0] * SIZE[1] // 4)
    known = wp.array(frames, dtype=int, device="cpu")
    light = direct(device_scene, down_at(0.2, 0.3, 0.3), samples, frame=3, known=known, settled=5)
    settled = (frames >= 5).reshape(SIZE[1], SIZE[0])
    for chosen, count in ((settled, half), (~settled, samples)):
        assert np.array_equal(light[chosen], direct(device_scene, down_at(0.2, 0.3, 0.3), count, frame=3)[chosen])
    assert light.std() > 0.0


def test_a_floor_is_lit_on_the_side_that_is_seen_alone() -> None:
    device_scene = resident_of([floor()], [grey(0.5)], lights=[SUN])
    below = direct(device_scene, look_at((0.0, -0.3, 0.0), (0.0, 0.0, 0.0)))
    assert not below.any()


@pytest.mark.parametrize("samples", [1, 3, 4])
def test_an_area_light_has_its_mean_at_any_number_of_samples(samples: int) -> None:
    lamp = quad([-0.2, 0.4, -0.1], [0.4, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    device_scene = resident_of([floor(), lamp], [grey(0.5), grey(0.0, emission=2.0)])
    picture = direct(device_scene, down_at(0.0, 0.0), samples)
    assert np.allclose(picture.mean(axis=(0, 1)), 0.5 * 2.0 * rectangle_over(0.2, 0.1, 0.4), rtol=0.01)


def test_half_an_area_light_hidden_halves_its_light() -> None:
    lamp = quad([-0.2, 0.4, -0.1], [0.4, 0.0, 0.0], [0.0, 0.0, 0.2], 1)
    blocker = quad([0.0, 0.35, -0.5], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0])
    device_scene = resident_of([floor(), lamp, blocker], [grey(0.5), grey(0.0, emission=2.0)])
    pictures = [direct(device_scene, down_at(0.0, 0.0), 4, seed).mean(axis=(0, 1)) for seed in range(4)]
    assert np.allclose(np.mean(pictures, axis=0), 0.5 * rectangle_over(0.2, 0.1, 0.4), rtol=0.02)
    assert not np.array_equal(pictures[0], pictures[1])


def test_noise_falls_with_samples_and_averages_out_among_neighbours() -> None:
    lamp = quad([-0.2, 0.3, -0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4], 1)
    blocker = quad([0.0, 0.15, -0.5], [0.1, 0.0, 0.0], [0.0, 0.0, 1.0])
    device_scene = resident_of([floor(), lamp, blocker], [grey(0.5), grey(0.0, emission=2.0)])
    one, four = (direct(device_scene, down_at(0.0, 0.0), samples)[..., 0] for samples in (1, 4))
    assert four.var() < one.var() / 4.0
    blocks = one.reshape(8, 4, 8, 4).mean(axis=(1, 3))
    assert blocks.var() < one.var() / 16.0 / 2.0  # white noise would give a sixteenth


def test_frames_complement_each_other() -> None:
    lamp = quad([-0.2, 0.3, -0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4], 1)
    blocker = quad([0.0, 0.15, -0.5], [0.1, 0.0, 0.0], [0.0, 0.0, 1.0])
    device_scene, camera = (
        resident_of([floor(), lamp, blocker], [grey(0.5), grey(0.0, emission=2.0)]),
        down_at(0.0, 0.0),
    )
    together = np.mean([direct(device_scene, camera, frame=frame) for frame in range(16)], axis=0)
    independent = np.mean([direct(device_scene, camera, seed=seed) for seed in range(16)], axis=0)
    assert together.mean() == pytest.approx(independent.mean(), rel=0.01)
    assert together.var() < independent.var() / 2.0


def test_many_punctual_lights_have_the_mean_of_few() -> None:
    lights = [Light(str(k), LightKind.POINT, (1.0 + k, 2.0, 1.0), position=(0.1 * k - 0.4, 0.3, 0.1)) for k in range(9)]
    camera = down_at(0.0, 0.0)
    many = direct(resident_of([floor()], [grey(0.5)], lights=lights), camera, 4)
    assert len(lights) > MAX_ENUMERATED
    halves = [direct(resident_of([floor()], [grey(0.5)], lights=half), camera) for half in (lights[:4], lights[4:])]
    assert all(half.std(axis=(0, 1)).max() < 1e-2 * half.mean() for half in halves)
    assert np.allclose(many.mean(axis=(0, 1)), np.sum(halves, axis=0).mean(axis=(0, 1)), rtol=0.01)


@wp.kernel
def highlight_kernel(first: int, surface: Surface, view: wp.vec3, corner: wp.vec3, edge_u: wp.vec3, edge_v: wp.vec3,
                     out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """A cell's share of what a lamp of unit radiance in the grid's parallelogram gives to `surface`."""
    index = first + wp.tid()
    u = (float(index % GRID) + 0.5) / float(GRID)
    v = (float(index // GRID) + 0.5) / float(GRID)
    way = corner + edge_u * u + edge_v * v - surface.position
    light = wp.normalize(way)
    normal = wp.cross(edge_u, edge_v)
    facing = wp.max(-wp.dot(light, normal), 0.0)
    out[index] = reflected(surface, view, light) * (facing / (wp.length_sq(way) * float(GRID * GRID)))


@pytest.mark.parametrize("roughness", [0.15, 0.4, 0.8])
def test_highlights_of_area_lights_have_their_integral(roughness: float) -> None:
    material = Material(base_color=(0.2, 0.2, 0.2, 1.0), metallic=0.0, roughness=roughness, specular=1.0)
    corner, edge_u, edge_v = np.array([0.1, 0.25, -0.1]), np.array([0.2, 0.0, 0.0]), np.array([0.0, 0.0, 0.2])
    device_scene = resident_of([floor(), quad(corner, edge_u, edge_v, 1)], [material, grey(0.0, emission=1.0)])
    eye, place = np.array([-0.2, 0.25, 0.0]), np.zeros(3)
    view = (eye - place) / np.linalg.norm(eye - place)
    base = look_at(eye, place)
    picture = direct(device_scene, Camera("spot", base.to_world, 1e-4, orthographic=True), 64)
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*UP)
    surface.diffuse, surface.f0, surface.f90 = wp.vec3(0.2, 0.2, 0.2), wp.vec3(0.04, 0.04, 0.04), 1.0
    surface.roughness = roughness
    vectors = [wp.vec3(*v) for v in (view, corner, edge_u, edge_v)]
    expected = results(highlight_kernel, int(GRID) ** 2, [surface, *vectors], wp.vec3).sum(axis=0)
    assert np.allclose(picture.mean(axis=(0, 1)), expected, rtol=0.01)
    assert picture.std() < 0.25 * picture.mean()


def test_emitters_and_the_sky_are_shown() -> None:
    device_scene = resident_of(
        [quad([-1, -1, 0], [1, 0, 0], [0, 2, 0], 0)], [grey(0.0, emission=5.0)], sky=Sky((1.0, 2.0, 3.0))
    )
    camera = look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), yfov_degrees=10.0, aspect=1.0)
    picture = direct(device_scene, camera)
    assert np.allclose(picture[:, :16], 5.0)
    assert np.allclose(picture[15, 31], np.array([1.0, 2.0, 3.0]) / 2.0, rtol=0.02)


def test_a_sample_of_the_sky_is_one_that_faces_the_surface() -> None:
    """With one shadow ray a pixel, samples that are spread over the whole sky deviate by 1.3 of the mean."""
    wall = quad([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0)
    camera = look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), yfov_degrees=10.0, aspect=1.0)
    picture = direct(resident_of([wall], [grey(0.5)], sky=Sky((1.0, 1.0, 1.0))), camera)[..., 0]
    assert picture.mean() == pytest.approx(0.25, rel=0.01)
    assert picture.std() < 0.15 * picture.mean()


def test_a_flat_lamp_does_not_light_itself() -> None:
    lamp = Material(base_color=(0.9, 0.9, 0.9, 1.0), emission=(2.0, 2.0, 2.0), roughness=0.3)
    for edge_u, edge_v in (([0.7, 0.1, 0.2], [0.1, 0.3, -0.9]), ([0.3, 0.7, 0.0], [0.0, 0.1, 0.6])):
        device_scene = resident_of([quad([-0.3, 0.1, 0.2], edge_u, edge_v)], [lamp])
        centre = np.array(device_scene.scene.placement.centre)
        eye = centre + 0.3 * np.cross(edge_u, edge_v)
        picture = direct(device_scene, look_at(eye, centre, yfov_degrees=30.0), 4)
        assert np.allclose(picture, 2.0, rtol=1e-3)


def test_a_closed_box_without_a_lamp_is_black() -> None:
    device_scene = resident_of(box(), [grey(0.5)], sky=Sky((1.0, 1.0, 1.0)))
    assert not direct(device_scene, look_at((0.0, 0.0, 0.0), (0.3, 0.2, 0.1)), 4).any()


def test_lambertian_views_have_no_highlight() -> None:
    material = Material(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0, roughness=0.2)
    device_scene = resident_of([floor()], [material], lights=[SUN])
    camera = look_at((0.3, 0.4, 0.0), (0.0, 0.0, 0.0), yfov_degrees=1.0)
    expected = 0.5 / np.pi * 0.8 * np.array(SUN.intensity)
    assert np.allclose(direct(device_scene, camera, lambertian=True), expected, rtol=1e-4)
    assert (direct(device_scene, camera)[16, 16] > 1.5 * expected).all()


def test_an_environment_lights_as_its_irradiance_says() -> None:
    pixels = np.full((8, 16, 3), 0.5, np.float32)
    pixels[1, 3] = 100.0
    camera = down_at(0.0, 0.0)
    edges = np.clip(np.cos(np.pi * np.arange(9) / 8), 0.0, None) ** 2
    irradiance = (pixels[..., 0].sum(axis=1) * (edges[:-1] - edges[1:]) / 2.0 * 2.0 * np.pi / 16).sum()
    lit = direct(resident_of([floor()], [grey(0.5)], sky=Environment("sun", pixels)), camera, 16)
    assert lit.mean() == pytest.approx(0.5 / np.pi * irradiance, rel=0.02)
    glossy = Material(metallic=1.0, roughness=0.3)
    even = Environment("even", np.ones((4, 8, 3), np.float32))
    assert direct(resident_of([floor()], [glossy], sky=even), camera, 16).mean() == pytest.approx(0.97, abs=0.03)


def test_cloth_shines_back_to_where_light_comes_from() -> None:
    material = replace(grey(0.0), sheen_color=(1.0, 0.5, 0.0), sheen_roughness=0.5)
    device_scene = resident_of([floor()], [material], lights=[SUN])
    base = look_at((-0.06, 0.08, 0.0), (0.0, 0.0, 0.0))
    picture = direct(device_scene, Camera("spot", base.to_world, 1e-3, orthographic=True))
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*UP)
    surface.sheen, surface.sheen_roughness = wp.vec3(1.0, 0.5, 0.0), 0.5
    light = -np.array(SUN.direction)
    expected = results(sun_kernel, 1, [surface, wp.vec3(-0.6, 0.8, 0.0), wp.vec3(*light)], wp.vec3)[0]
    assert expected[1] > 0.01
    assert np.allclose(picture, expected * SUN.intensity, rtol=0.01)


def test_brushed_metal_has_highlights_along_its_grain() -> None:
    """u of the floor grows along z: what mirrors the sun is as bright as it is, what is beside that along z as well."""
    material = Material(metallic=1.0, roughness=0.4, anisotropy=0.8)
    device_scene = resident_of([floor()], [material], lights=[SUN])
    surface = Surface()
    surface.normal = surface.geometric_normal = wp.vec3(*UP)
    surface.f0, surface.f90, surface.roughness = wp.vec3(1.0, 1.0, 1.0), 1.0, 0.4
    surface.grain = wp.vec3(0.0, 0.0, 0.64)
    light, seen = -np.array(SUN.direction), []
    for view in ((0.6, 0.8, 0.0), (0.48, 0.64, 0.6), (0.0, 1.0, 0.0)):
        base = look_at(tuple(0.1 * np.array(view)), (0.0, 0.0, 0.0), up=(0.1, 0.2, 0.3))
        picture = direct(device_scene, Camera("spot", base.to_world, 1e-3, orthographic=True))
        expected = results(sun_kernel, 1, [surface, wp.vec3(*view), wp.vec3(*light)], wp.vec3)[0]
        assert np.allclose(picture, expected * SUN.intensity, rtol=0.01)
        seen.append(expected[0])
    assert seen[1] > 3.0 * seen[2]


def test_paper_is_lit_from_behind() -> None:
    """By the sun, and by a lamp, whose light is sampled."""
    paper = replace(grey(0.8), specular=0.0, diffuse_transmission=0.25, diffuse_transmission_color=(1.0, 0.5, 0.25))
    through = np.array([0.25, 0.125, 0.0625])
    below = Camera("spot", look_at((0.0, -0.2, 0.01), (0.0, 0.0, 0.0)).to_world, 0.05, orthographic=True)
    seen = direct(resident_of([floor()], [paper], lights=[SUN]), below)
    assert np.allclose(seen, through / np.pi * -SUN.direction[1] * np.array(SUN.intensity), rtol=1e-3)
    lamp = quad([-0.4, 0.3, -0.4], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8], 1)
    pictures = [direct(resident_of([floor(), lamp], [paper, grey(0.0, 1.0)]), camera, 64).mean(axis=(0, 1))
                for camera in (below, Camera("spot", look_at((0.0, 0.2, 0.01), (0.0, 0.0, 0.0)).to_world, 0.05,
                                             orthographic=True))]  # fmt: skip
    assert pictures[0] / pictures[1] == pytest.approx(through / 0.6, rel=0.02)
