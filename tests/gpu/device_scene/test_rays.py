from typing import Any

import numpy as np
import pytest
import warp as wp
from scenes import box, column, grey, quad, resident_of, results

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import closest_hit, connected, occluded
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import AlphaMode, Doubles, Material, Texture, TextureSlot


@wp.kernel
def connected_kernel(first: int, scene: SceneData, p: wp.array[wp.vec3], q: wp.array[wp.vec3], p_normal: wp.vec3,
                     q_normal: wp.vec3, out: wp.array[int]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = int(connected(scene, p[index], p_normal, q[index], q_normal))


@wp.kernel
def shoot_kernel(first: int, scene: SceneData, origins: wp.array[wp.vec3], direction: wp.vec3,
                 out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """(face, t, whether occluded) of each ray."""
    index = first + wp.tid()
    hit = closest_hit(scene, origins[index], direction, 10.0)
    out[index] = wp.vec3(float(hit.face), hit.t, wp.where(occluded(scene, origins[index], direction, 10.0), 1.0, 0.0))


def test_points_see_each_other_both_ways_unless_something_is_between() -> None:
    half = [0.25, 0.0, 0.0]
    parts = [*box(), quad([-0.5, 0.0, -0.5], half, [0.0, 0.0, 1.0]), quad([0.25, 0.0, -0.5], [0.0, 0.0, 1.0], half)]
    device_scene = resident_of(parts, [grey(0.5)])
    rng = np.random.default_rng(2)
    floor, ceiling = rng.random((2, 2000, 3)) - 0.5
    floor[:, 1], ceiling[:, 1] = -0.5, 0.5
    ends = column(floor, wp.vec3), column(ceiling, wp.vec3)
    up, down = wp.vec3(0.0, 1.0, 0.0), wp.vec3(0.0, -1.0, 0.0)
    there = results(connected_kernel, 2000, [device_scene.data, *ends, up, down], int)
    back = results(connected_kernel, 2000, [device_scene.data, *ends[::-1], down, up], int)
    middle = (floor[:, 0] + ceiling[:, 0]) / 2.0
    assert np.array_equal(there, back)
    assert np.array_equal(there == 1, np.abs(middle) < 0.25)


def test_a_point_is_connected_with_itself_and_its_nearest_neighbours() -> None:
    device_scene = resident_of(box(), [grey(0.5)])
    p = np.tile([[0.1, -0.5, 0.2]], (3, 1))
    q = p + np.array([[0.0, 0.0, 0.0], [1e-7, 0.0, 0.0], [1e-3, 0.0, 0.0]])
    up = wp.vec3(0.0, 1.0, 0.0)
    seen = results(connected_kernel, 3, [device_scene.data, column(p, wp.vec3), column(q, wp.vec3), up, up], int)
    assert (seen == 1).all()


def test_nothing_is_seen_through_the_back_of_ones_own_surface() -> None:
    device_scene = resident_of([quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])], [grey(0.5)])
    p, q = column([[0.1, 0.0, 0.1]], wp.vec3), column([[0.2, -0.3, 0.1]], wp.vec3)
    up, down, nowhere = wp.vec3(0.0, 1.0, 0.0), wp.vec3(0.0, -1.0, 0.0), wp.vec3(0.0, 0.0, 0.0)
    for p_normal, q_normal, seen in ((up, up, 0), (down, up, 1), (down, down, 0), (up, nowhere, 0), (down, nowhere, 1)):
        for ends, normals in (((p, q), (p_normal, q_normal)), ((q, p), (q_normal, p_normal))):
            assert results(connected_kernel, 1, [device_scene.data, *ends, *normals], int)[0] == seen


def test_a_lamp_in_the_plane_of_a_wall_is_not_behind_it() -> None:
    device_scene = resident_of(box(half=0.47), [grey(0.5)])
    scale = device_scene.scene.placement.scale
    rng = np.random.default_rng(3)
    floor = rng.uniform(-0.45, 0.45, (5000, 3))
    floor[:, 1] = -0.47
    lamp = np.tile([[0.1, 0.47, -0.23]], (5000, 1))
    ends = column(floor * scale, wp.vec3), column(lamp * scale, wp.vec3)
    up, nowhere = wp.vec3(0.0, 1.0, 0.0), wp.vec3(0.0, 0.0, 0.0)
    assert (results(connected_kernel, 5000, [device_scene.data, *ends, up, nowhere], int) == 1).all()


def masked_layers(**material: Any) -> DeviceScene:
    """Five sheets facing +Z, at z = −0.5 … 0.5, whose texture is clear on the left and solid on the right."""
    pixels = np.full((1, 2, 4), 255, np.uint8)
    pixels[0, 0, 3] = 0
    sheets = [quad([-0.5, -0.5, z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]) for z in np.linspace(-0.5, 0.5, 5)]
    sheet = Material(alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0), **material)
    return resident_of(sheets, [sheet], textures=[Texture("mask", pixels, srgb=True, nearest=True)])


def shoot(device_scene: DeviceScene, scene: SceneData, x: float) -> Doubles:
    origins = column([[x, 0.1, 2.0]], wp.vec3)
    return results(shoot_kernel, 1, [scene, origins, wp.vec3(0.0, 0.0, -1.0)], wp.vec3)[0]


def test_light_passes_where_a_mask_is_clear_through_all_layers() -> None:
    device_scene = masked_layers()
    assert device_scene.data.opaque_count == 0
    assert shoot(device_scene, device_scene.data, -0.2).tolist() == [int(NO_HIT), 10.0, 0.0]
    face, distance, dark = shoot(device_scene, device_scene.data, 0.2)
    assert distance == pytest.approx(1.5, abs=1e-5)
    assert int(face) in (8, 9)
    assert dark == 1.0


def test_the_first_solid_surface_behind_a_mask_is_hit() -> None:
    pixels = np.zeros((1, 1, 4), np.uint8)
    parts = [
        quad([-0.5, -0.5, 0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0),
        quad([-0.5, -0.5, -0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1),
    ]
    clear = Material(alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0))
    device_scene = resident_of(parts, [clear, grey(0.5)], textures=[Texture("mask", pixels, srgb=True)])
    face, distance, dark = shoot(device_scene, device_scene.data, 0.2)
    assert int(face) < device_scene.data.opaque_count
    assert distance == pytest.approx(2.5, abs=1e-5)
    assert dark == 1.0


@pytest.mark.parametrize(("clear", "met"), [(63, 1.0), (64, 0.0)])
def test_rays_look_through_64_layers_of_masks(clear: int, met: float) -> None:
    heights = np.linspace(0.5, -0.5, clear + 1)
    sheets = [quad([-0.5, -0.5, z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], int(z == heights[-1])) for z in heights.tolist()]
    materials = [Material(alpha_mode=AlphaMode.MASK, base_color=(1.0, 1.0, 1.0, alpha)) for alpha in (0.0, 1.0)]
    device_scene = resident_of(sheets, materials)
    face, _, dark = shoot(device_scene, device_scene.data, 0.2)
    assert (float(face != int(NO_HIT)), dark) == (met, met)


def test_the_cutoff_and_the_factor_count() -> None:
    for cutoff, alpha, dark in ((0.4, 0.5, 1.0), (0.6, 0.5, 0.0)):
        device_scene = masked_layers(alpha_cutoff=cutoff, base_color=(1.0, 1.0, 1.0, alpha))
        assert shoot(device_scene, device_scene.data, 0.2)[2] == dark


def test_a_lambertian_view_takes_masks_as_solid() -> None:
    device_scene = masked_layers()
    assert shoot(device_scene, device_scene.view(lambertian=True), -0.2)[2] == 1.0
