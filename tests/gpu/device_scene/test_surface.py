from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of, results

from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.surface import hit_at, surface_at
from gpu.device_scene.upload import DeviceScene
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Material, Texture, TextureSlot

POSITION, GEOMETRIC, NORMAL, ALBEDO, DIFFUSE, EMISSION, F0, ROUGHNESS = range(8)
SQRT_HALF = 0.5**0.5


@wp.kernel
def surface_kernel(first: int, scene: SceneData, origins: wp.array[wp.vec3], directions: wp.array[wp.vec3],
                   out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """The surface that each ray hits, eight vectors a ray."""
    index = first + wp.tid()
    hit = closest_hit(scene, origins[index], directions[index], 10.0)
    surface = surface_at(scene, hit, directions[index])
    out[8 * index] = surface.position
    out[8 * index + 1] = surface.geometric_normal
    out[8 * index + 2] = surface.normal
    out[8 * index + 3] = surface.albedo
    out[8 * index + 4] = surface.diffuse
    out[8 * index + 5] = surface.emission
    out[8 * index + 6] = surface.f0
    out[8 * index + 7] = wp.vec3(surface.roughness, 0.0, 0.0)


@wp.kernel
def hit_at_kernel(first: int, scene: SceneData, origins: wp.array[wp.vec3], direction: wp.vec3,
                  out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """(face, u, v) of each ray's hit, and of the point where that is."""
    index = first + wp.tid()
    hit = closest_hit(scene, origins[index], direction, 10.0)
    found = hit_at(scene, hit.face, origins[index] + direction * hit.t)
    out[2 * index] = wp.vec3(float(hit.face), hit.u, hit.v)
    out[2 * index + 1] = wp.vec3(float(found.face), found.u, found.v)


def seen(device_scene: DeviceScene, origin: Any, direction: Any, *, lambertian: bool = False) -> Doubles:
    """The surface that one ray hits, (8, 3)."""
    scene = device_scene.view(lambertian=lambertian)
    unit = np.asarray(direction, float) / np.linalg.norm(direction)
    inputs = [scene, column([origin], wp.vec3), column([unit], wp.vec3)]
    return results(surface_kernel, 1, inputs, wp.vec3, width=8)


def wall(material: Material, **rest: Any) -> DeviceScene:
    """A unit square in the plane z = 0 that faces +Z, u to the right, v upwards."""
    return resident_of([quad([-0.5, -0.5, 0], [1, 0, 0], [0, 1, 0])], [material], **rest)


def textured(colour: tuple[int, int, int], srgb: bool = False, alpha: int = 255) -> Texture:
    return Texture("flat", np.full((2, 2, 4), (*colour, alpha), np.uint8), srgb=srgb)


def test_both_sides_reflect_and_only_the_front_emits() -> None:
    device_scene = wall(grey(0.4, emission=3.0))
    front = seen(device_scene, [0.1, 0.2, 1.0], [0, 0, -1])
    back = seen(device_scene, [0.1, 0.2, -1.0], [0, 0, 1])
    assert np.allclose(front[POSITION], [0.1, 0.2, 0.0], atol=1e-6)
    assert np.allclose(front[[GEOMETRIC, NORMAL]], [0, 0, 1])
    assert np.allclose(back[[GEOMETRIC, NORMAL]], [0, 0, -1])
    assert np.allclose(front[EMISSION], 3.0)
    assert np.allclose(back[EMISSION], 0.0)
    assert np.allclose([front[ALBEDO], back[ALBEDO]], 0.4)


def test_a_point_of_a_triangle_is_the_hit_of_the_ray_that_comes_there() -> None:
    origins = np.random.default_rng(1).uniform([-0.45, -0.45, 1.0], [0.45, 0.45, 2.0], (64, 3))
    inputs = [wall(grey(0.5)).data, column(origins, wp.vec3), wp.vec3(0.0, 0.0, -1.0)]
    hits = results(hit_at_kernel, len(origins), inputs, wp.vec3, width=2).reshape(-1, 2, 3)
    assert {*hits[:, 0, 0]} == {0.0, 1.0}
    assert np.allclose(hits[:, 1], hits[:, 0], atol=1e-5)


def test_a_point_lies_a_little_towards_the_viewer_within_its_surface() -> None:
    """Where walls meet it would be in both, and light from behind one would reach it."""
    for origin in ([0.3, 0.2, 1.0], [-0.2, 0.1, -0.7]):
        way = -np.asarray(origin)
        position, normal = seen(wall(grey(0.5)), origin, way)[[POSITION, GEOMETRIC]]
        assert position @ normal == 0.0
        expected = -(way - (way @ normal) * normal) / np.linalg.norm(way) * 32.0 * 2.0**-23 * 0.0625
        assert position == pytest.approx(expected, rel=0.02)


def bent_wall() -> DeviceScene:
    """That square with vertex normals that lean 45° to the left on the left and to the right on the right."""
    part = quad([-0.5, -0.5, 0], [1, 0, 0], [0, 1, 0])
    normals = np.array([[-1.0, 0, 1], [1, 0, 1], [1, 0, 1], [-1, 0, 1]]) * SQRT_HALF
    return resident_of([MeshPart(part.positions, part.triangles, normals=normals)], [grey(0.5)])


def test_normals_are_interpolated_and_face_the_viewer() -> None:
    for x, expected in ((-0.49, [-SQRT_HALF, 0, SQRT_HALF]), (0.0, [0, 0, 1]), (0.49, [SQRT_HALF, 0, SQRT_HALF])):
        front = seen(bent_wall(), [x, 0.0, 1.0], [0, 0, -1])
        assert np.allclose(front[NORMAL], expected, atol=0.03)
        assert np.allclose(front[GEOMETRIC], [0, 0, 1])
        back = seen(bent_wall(), [x, 0.0, -1.0], [0, 0, 1])
        assert np.allclose(back[NORMAL], -np.array(expected), atol=0.03)


def test_a_normal_that_faces_away_is_tilted_to_the_horizon() -> None:
    direction = np.array([0.95, 0.0, -((1 - 0.95**2) ** 0.5)])
    surface = seen(bent_wall(), np.array([0.49, 0.0, 0.0]) - direction, direction)
    assert -0.01 < surface[NORMAL] @ -direction < 0.01
    assert np.linalg.norm(surface[NORMAL]) == pytest.approx(1.0, abs=1e-5)


def test_lambertian_views_take_geometric_normals_and_the_whole_base_colour() -> None:
    device_scene = wall(Material(base_color=(0.9, 0.5, 0.1, 1.0), metallic=1.0, roughness=0.2))
    surface = seen(device_scene, [0.0, 0.1, 1.0], [0, 0, -1], lambertian=True)
    assert np.allclose(surface[[ALBEDO, DIFFUSE]], [0.9, 0.5, 0.1])
    assert np.allclose(surface[F0], 0.0)
    flat = seen(bent_wall(), [0.4, 0.1, 1.0], [0, 0, -1], lambertian=True)
    assert np.allclose(flat[NORMAL], [0, 0, 1])


def test_metals_reflect_by_their_colour_and_dielectrics_by_their_index() -> None:
    metal = seen(wall(Material(base_color=(0.9, 0.5, 0.1, 1.0), metallic=1.0)), [0.0, 0.1, 1.0], [0, 0, -1])
    assert np.allclose(metal[F0], [0.9, 0.5, 0.1])
    assert np.allclose(metal[DIFFUSE], 0.0)
    assert np.allclose(metal[ALBEDO], [0.9, 0.5, 0.1])
    glass = Material(base_color=(0.3, 0.3, 0.3, 1.0), ior=1.5, specular=0.5, specular_color=(1.0, 0.5, 0.0))
    surface = seen(wall(glass), [0.0, 0.1, 1.0], [0, 0, -1])
    assert np.allclose(surface[F0], [0.02, 0.01, 0.0])
    assert np.allclose(surface[DIFFUSE], 0.3)


def test_alpha_and_colour_of_textures_scale_what_dielectrics_reflect() -> None:
    slots = {"specular_slot": TextureSlot(0), "specular_color_slot": TextureSlot(1)}
    half = Texture("half", np.full((2, 2, 4), 102, np.uint8), srgb=False)
    material = Material(specular=0.5, specular_color=(1.0, 1.0, 2.0), **slots)  # type: ignore[arg-type]
    surface = seen(wall(material, textures=[half, textured((51, 255, 255))]), [0.0, 0.1, 1.0], [0, 0, -1])
    assert np.allclose(surface[F0], 0.04 * 0.2 * np.array([0.2, 1.0, 2.0]), atol=1e-5)


def test_green_and_blue_of_the_texture_scale_roughness_and_metal() -> None:
    material = Material(base_color=(0.8,) * 3 + (1.0,), metallic=1.0, roughness=0.8,
                        metallic_roughness_slot=TextureSlot(0))  # fmt: skip
    surface = seen(wall(material, textures=[textured((255, 51, 102))]), [0.0, 0.1, 1.0], [0, 0, -1])
    assert surface[ROUGHNESS][0] == pytest.approx(0.16, abs=1e-6)
    assert np.allclose(surface[DIFFUSE], 0.8 * 0.6)
    assert np.allclose(surface[F0], 0.04 * 0.6 + 0.8 * 0.4)


def test_emission_is_textured_and_unlit_surfaces_show_their_colour() -> None:
    material = Material(emission=(4.0, 2.0, 1.0), emission_slot=TextureSlot(0))
    surface = seen(wall(material, textures=[textured((51, 255, 0))]), [0.0, 0.1, 1.0], [0, 0, -1])
    assert np.allclose(surface[EMISSION], [0.8, 2.0, 0.0])
    shown = seen(wall(Material(base_color=(0.2, 0.4, 0.6, 1.0), unlit=True)), [0.0, 0.1, 1.0], [0, 0, -1])
    assert np.allclose(shown[EMISSION], [0.2, 0.4, 0.6])
    assert np.allclose(shown[[ALBEDO, DIFFUSE, F0]], 0.0)


def test_vertex_colours_tint_the_base_colour() -> None:
    part = quad([-0.5, -0.5, 0], [1, 0, 0], [0, 1, 0])
    colours = np.array([[1.0, 0, 0, 1], [0, 1, 0, 1], [0, 1, 0, 1], [1, 0, 0, 1]])
    device_scene = resident_of([MeshPart(part.positions, part.triangles, colors=colours)], [grey(0.8)])
    surface = seen(device_scene, [0.25, 0.1, 1.0], [0, 0, -1])
    assert np.allclose(surface[ALBEDO], [0.2, 0.6, 0.0], atol=1e-5)


@pytest.mark.parametrize("mirrored", [False, True])
def test_red_of_a_normal_map_follows_u_and_green_goes_up_in_the_image(mirrored: bool) -> None:
    corner, across = ([0.5, 0.5, 0], [-1, 0, 0]) if mirrored else ([-0.5, 0.5, 0], [1, 0, 0])
    for colour, lean in (((255, 128, 128), [np.sign(across[0]), 0, 0]), ((128, 255, 128), [0, 1, 0])):
        part = quad(corner, across, [0, -1, 0])  # v downwards, as an image on a wall
        towards_z = part.triangles if mirrored else part.triangles[:, ::-1]
        part = MeshPart(part.positions, towards_z, uvs=part.uvs)
        material = Material(normal_slot=TextureSlot(0))
        device_scene = resident_of([part], [material], textures=[textured(colour)])
        for side in (1.0, -1.0):
            surface = seen(device_scene, [0.1, 0.2, side], [0, 0, -side])
            assert np.allclose(surface[NORMAL] * side, lean, atol=0.03), (colour, side)


def test_the_normal_scale_flattens() -> None:
    material = Material(normal_slot=TextureSlot(0), normal_scale=0.5)
    surface = seen(wall(material, textures=[textured((255, 128, 255))]), [0.0, 0.1, 1.0], [0, 0, -1])
    expected = np.array([0.5, 0.0, 1.0]) / 1.25**0.5
    assert np.allclose(surface[NORMAL], expected, atol=0.01)


def test_no_surface_is_smoother_than_highlights_can_be_seen() -> None:
    for roughness, expected in ((0.0, 0.05), (0.04, 0.05), (0.06, 0.06)):
        found = seen(wall(Material(roughness=roughness)), [0.0, 0.1, 1.0], [0, 0, -1])
        assert found[ROUGHNESS][0] == pytest.approx(expected)


@wp.kernel
def glass_kernel(first: int, scene: SceneData, origins: wp.array[wp.vec3], directions: wp.array[wp.vec3],
                 out: wp.array[wp.vec4]) -> None:  # fmt: skip
    """(share of glass, index, absorption of red, clear + 2 · thin + 4 · mirror + 8 · f90) of what a ray hits."""
    index = first + wp.tid()
    surface = surface_at(scene, closest_hit(scene, origins[index], directions[index], 10.0), directions[index])
    kinds = float(int(surface.clear)) + 2.0 * float(int(surface.thin)) + 4.0 * float(int(surface.mirror))
    out[index] = wp.vec4(surface.glass, surface.eta, surface.absorption[0], kinds + 8.0 * surface.f90)


def glass_of(material: Material, *, lambertian: bool = False, **rest: Any) -> tuple[Doubles, Doubles]:
    """What the front and the back of a wall are."""
    scene = wall(material, **rest).view(lambertian=lambertian)
    inputs = [scene, column([[0.1, 0.2, 1.0], [0.1, 0.2, -1.0]], wp.vec3), column([[0, 0, -1], [0, 0, 1]], wp.vec3)]
    front, back = results(glass_kernel, 2, inputs, wp.vec4)
    return front, back


def test_bodies_refract_and_absorb_behind_their_fronts() -> None:
    body = Material(transmission=0.8, roughness=0.0, thickness=1.0, ior=1.6, attenuation_color=(0.5, 1.0, 1.0),
                    attenuation_distance=2.0)  # fmt: skip
    front, back = glass_of(body)
    assert np.allclose(front, [0.8, 1.6, np.log(2.0) / 2.0, 1.0 + 8.0])
    assert np.allclose(back, [0.8, 1.0 / 1.6, 0.0, 1.0 + 8.0])
    assert not glass_of(body, lambertian=True)[0].any()


def test_sheets_are_alike_from_both_sides() -> None:
    front, back = glass_of(Material(transmission=1.0, roughness=0.5, ior=1.0, specular=0.5, metallic=0.25))
    assert np.allclose(front, [0.75, 1.0001, 0.0, 2.0 + 8.0 * (0.5 * 0.75 + 0.25)])
    assert np.array_equal(front, back)
    texture = textured((128, 0, 0))
    half, _ = glass_of(Material(transmission=1.0, transmission_slot=TextureSlot(0)), textures=[texture])
    assert half[0] == pytest.approx(128 / 255, abs=1e-4)


def test_smooth_metals_are_mirrors_and_smooth_glass_is_clear() -> None:
    for roughness, mirror in ((0.029, True), (0.031, False)):
        front, _ = glass_of(Material(metallic=1.0, roughness=roughness))
        assert front[3] == 8.0 + 4.0 * mirror
        assert glass_of(Material(metallic=0.9, roughness=roughness))[0][3] == pytest.approx(8.0)
    for roughness, clear in ((0.099, True), (0.101, False)):
        assert glass_of(Material(transmission=1.0, thickness=1.0, roughness=roughness))[0][3] == 8.0 + clear


@wp.kernel
def coat_normal_kernel(first: int, scene: SceneData, out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    direction = wp.vec3(0.0, 0.0, -1.0)
    out[index] = surface_at(scene, closest_hit(scene, wp.vec3(0.1, 0.2, 1.0), direction, 10.0), direction).coat_normal


def test_coats_have_a_normal_map_of_their_own() -> None:
    """They do not lie in the folds of what is below."""
    bent, own = (
        {"normal_slot": TextureSlot(0)},
        {"clearcoat_normal_slot": TextureSlot(0), "clearcoat_normal_scale": 0.5},
    )
    for slots, expected in ((bent, [0.0, 0.0, 1.0]), (own, np.array([0.5, 0.0, 1.0]) / 1.25**0.5)):
        data = wall(Material(clearcoat=1.0, **slots), textures=[textured((255, 128, 255))]).data
        assert np.allclose(results(coat_normal_kernel, 1, [data], wp.vec3)[0], expected, atol=0.01)


@wp.kernel
def coat_kernel(first: int, scene: SceneData, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    direction = wp.vec3(0.0, 0.0, -1.0)
    surface = surface_at(scene, closest_hit(scene, wp.vec3(0.1, 0.2, 1.0), direction, 10.0), direction)
    out[index] = wp.vec2(surface.coat, surface.coat_roughness)


def test_coats_have_their_factors_and_textures() -> None:
    slots = {"clearcoat_slot": TextureSlot(0), "clearcoat_roughness_slot": TextureSlot(0)}
    coat = Material(clearcoat=0.8, clearcoat_roughness=0.5)
    cases = [(coat, (0.8, 0.5)), (replace(coat, clearcoat_roughness=0.0), (0.8, 0.05)),
             (replace(coat, **slots), (0.8 * 128 / 255, 0.5 * 64 / 255)), (Material(), (0.0, 0.0))]  # fmt: skip
    for material, expected in cases:
        data = wall(material, textures=[textured((128, 64, 0))]).data
        assert np.allclose(results(coat_kernel, 1, [data], wp.vec2)[0], expected, atol=1e-3)
    lambertian = wall(coat).view(lambertian=True)
    assert not results(coat_kernel, 1, [lambertian], wp.vec2).any()


@wp.kernel
def sheen_kernel(first: int, scene: SceneData, out: wp.array[wp.vec4]) -> None:
    """Sheen with its roughness, and what it leaves of the diffuse lobe, f0 and f90."""
    index = first + wp.tid()
    direction = wp.vec3(0.0, 0.0, -1.0)
    surface = surface_at(scene, closest_hit(scene, wp.vec3(0.1, 0.2, 1.0), direction, 10.0), direction)
    out[2 * index] = wp.vec4(surface.sheen[0], surface.sheen[1], surface.sheen[2], surface.sheen_roughness)
    out[2 * index + 1] = wp.vec4(surface.diffuse[0], surface.f0[0], surface.f90, surface.glass)


def sheen_of(material: Material, *, lambertian: bool = False) -> Doubles:
    data = wall(material, textures=[textured((128, 64, 255))]).view(lambertian=lambertian)
    return results(sheen_kernel, 1, [data], wp.vec4, width=2)


def test_cloth_has_its_sheen_and_textures_over_less_of_all_else() -> None:
    slots = {"sheen_color_slot": TextureSlot(0), "sheen_roughness_slot": TextureSlot(0)}
    cloth = Material(sheen_color=(0.5, 0.25, 1.0), sheen_roughness=1.0)
    sheen, below = sheen_of(cloth)
    assert np.allclose(sheen, [0.5, 0.25, 1.0, 1.0])
    assert np.allclose(below, np.array([1.0, 0.04, 1.0, 0.0]) * (1.0 - 0.164), atol=0.01)  # E(1, 1)
    assert sheen_of(replace(cloth, sheen_roughness=0.0))[0, 3] == pytest.approx(0.1)
    assert np.allclose(sheen_of(replace(cloth, **slots))[0], [0.5 * 128 / 255, 0.25 * 64 / 255, 1.0, 1.0], atol=1e-3)
    plain = sheen_of(Material())
    assert not plain[0].any()
    assert np.allclose(plain[1], [1.0, 0.04, 1.0, 0.0])
    assert not sheen_of(cloth, lambertian=True)[0].any()
    assert not sheen_of(replace(cloth, unlit=True))[0].any()


def test_glass_has_no_sheen_and_mirrors_with_sheen_are_lobes() -> None:
    cloth = Material(sheen_color=(1.0, 1.0, 1.0), sheen_roughness=1.0)
    assert not sheen_of(replace(cloth, transmission=0.5))[0].any()
    assert glass_of(replace(cloth, metallic=1.0, roughness=0.0))[0][3] < 12.0


@wp.kernel
def grain_kernel(first: int, scene: SceneData, side: float, out: wp.array[wp.vec4]) -> None:
    """The grain as it is seen from before or behind (side ±1), and whether the surface is a mirror."""
    index = first + wp.tid()
    direction = wp.vec3(0.0, 0.0, -side)
    surface = surface_at(scene, closest_hit(scene, wp.vec3(0.1, 0.2, side), direction, 10.0), direction)
    out[index] = wp.vec4(surface.grain[0], surface.grain[1], surface.grain[2], float(int(surface.mirror)))


def grain_of(material: Material, *, side: float = 1.0, **rest: Any) -> Doubles:
    data = wall(material, textures=[textured((128, 255, 128))], **rest).data
    return np.asarray(results(grain_kernel, 1, [data, side], wp.vec4)[0])


def test_grain_lies_along_u_as_its_factors_and_textures_turn_it() -> None:
    brushed = Material(metallic=1.0, roughness=0.0, anisotropy=0.5)
    assert np.allclose(grain_of(brushed), [0.25, 0.0, 0.0, 0.0])
    turned = replace(brushed, anisotropy_rotation=np.pi / 3.0)
    # Counter-clockwise from u towards where the image's top is, which is against v: downwards here.
    assert np.allclose(grain_of(turned)[:3], [0.125, -0.25 * 0.75**0.5, 0.0], atol=1e-6)
    assert np.allclose(np.abs(grain_of(turned, side=-1.0)[:3]), [0.125, 0.25 * 0.75**0.5, 0.0], atol=1e-6)
    mapped = replace(brushed, anisotropy_slot=TextureSlot(0))
    assert np.allclose(grain_of(mapped)[:3], [0.0, -((0.5 * 128 / 255) ** 2), 0.0], atol=1e-3)
    assert grain_of(replace(brushed, anisotropy=0.0))[3] == 1.0
    for plain in (replace(brushed, unlit=True), replace(brushed, metallic=0.0, transmission=1.0)):
        assert not grain_of(plain)[:3].any()


def test_without_uvs_there_is_no_direction_to_grain() -> None:
    square = quad([-0.5, -0.5, 0], [1, 0, 0], [0, 1, 0])
    bare = resident_of([replace(square, uvs=())], [Material(metallic=1.0, anisotropy=1.0)])
    assert not results(grain_kernel, 1, [bare.data, 1.0], wp.vec4)[0, :3].any()


@wp.kernel
def film_kernel(first: int, scene: SceneData, out: wp.array[wp.vec4]) -> None:
    """A film's share, index, thickness and what it makes of red."""
    index = first + wp.tid()
    direction = wp.vec3(0.0, 0.0, -1.0)
    surface = surface_at(scene, closest_hit(scene, wp.vec3(0.1, 0.2, 1.0), direction, 10.0), direction)
    out[index] = wp.vec4(surface.film, surface.film_ior, surface.film_thickness, surface.f0[0] - surface.film_f0[0])


def test_films_have_their_factors_and_textures() -> None:
    slots = {"iridescence_slot": TextureSlot(0), "iridescence_thickness_slot": TextureSlot(0)}
    grey = (0.5, 0.5, 0.5, 1.0)
    film = Material(base_color=grey, metallic=1.0, iridescence=0.5, iridescence_least=200.0, iridescence_most=600.0)
    thickness = 200.0 + 400.0 * 64 / 255
    cases = [(film, (0.5, 1.3, 600.0)), (replace(film, **slots), (0.5 * 128 / 255, 1.3, thickness)),
             (replace(film, unlit=True), (0.0, 0.0, 0.0)), (Material(specular=0.0, iridescence=1.0), (0.0, 0.0, 0.0)),
             (Material(), (0.0, 0.0, 0.0))]  # fmt: skip
    for material, expected in cases:
        data = wall(material, textures=[textured((128, 64, 0))]).data
        found = results(film_kernel, 1, [data], wp.vec4)[0]
        assert np.allclose(found[:3], expected, atol=0.01)
        assert expected[0] == 0.0 or abs(found[3]) > 0.01
    assert not results(film_kernel, 1, [wall(film).view(lambertian=True)], wp.vec4)[0, :3].any()


@wp.kernel
def through_kernel(first: int, scene: SceneData, side: float, out: wp.array[wp.vec4]) -> None:
    """What goes through, and red of the diffuse lobe; absorption, and whether it is a sheet."""
    index = first + wp.tid()
    direction = wp.vec3(0.0, 0.0, -side)
    surface = surface_at(scene, closest_hit(scene, wp.vec3(0.1, 0.2, side), direction, 10.0), direction)
    through, absorption = surface.through, surface.absorption
    out[2 * index] = wp.vec4(through[0], through[1], through[2], surface.diffuse[0])
    out[2 * index + 1] = wp.vec4(absorption[0], absorption[1], absorption[2], float(int(surface.thin)))


def through_of(material: Material, side: float = 1.0, *, lambertian: bool = False) -> Doubles:
    data = wall(material, textures=[textured((128, 64, 255), alpha=51)]).view(lambertian=lambertian)
    return np.asarray(results(through_kernel, 1, [data, side], wp.vec4, width=2))


def test_light_goes_through_by_factors_and_textures_and_is_taken_from_the_diffuse_lobe() -> None:
    paper = Material(diffuse_transmission=0.5, diffuse_transmission_color=(1.0, 0.5, 0.25))
    for side in (1.0, -1.0):
        assert np.allclose(through_of(paper, side), [[0.5, 0.25, 0.125, 0.5], [0.0, 0.0, 0.0, 1.0]])
    half_metal = replace(paper, metallic=0.5)
    assert np.allclose(through_of(half_metal)[0], [0.25, 0.125, 0.0625, 0.25])
    mapped = replace(paper, diffuse_transmission_slot=TextureSlot(0), diffuse_transmission_color_slot=TextureSlot(0))
    assert np.allclose(through_of(mapped)[0], [0.1 * 128 / 255, 0.05 * 64 / 255, 0.025, 0.9], atol=1e-3)
    assert not through_of(replace(paper, unlit=True))[0, :3].any()
    assert through_of(paper, lambertian=True)[0].tolist() == [0.0, 0.0, 0.0, 1.0]
    wax = replace(paper, thickness=1.0, attenuation_color=(0.5, 0.25, 1.0), attenuation_distance=2.0)
    absorbed = -np.log([0.5, 0.25, 1.0]) / 2.0
    front, back = (through_of(wax, side)[1] for side in (1.0, -1.0))
    assert front[3] == back[3] == 0.0
    assert not back[:3].any()
    assert np.allclose(front[:3] / front[1], absorbed / absorbed[1], atol=1e-6)
