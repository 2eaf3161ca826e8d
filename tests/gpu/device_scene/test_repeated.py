from time import process_time

import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import grey, quad, resident_of

from gpu.device_scene.data import SceneData
from gpu.device_scene.repeated import distinct
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import AlphaMode, Doubles, Material

# Two times the same corners; 6 is beside 0, by as little as there is.
VERTICES = np.array(2 * [[0, 0, 0], [1, 0, 0], [0, 1, 0]] + [[1e-45, 0, 0]], np.float32)
VERTICES[3, 1] = -0.0


def scene_data(triangles: np.ndarray, materials: np.ndarray, device: str = "cpu", uvs: Doubles | None = None,
               colors: Doubles | None = None) -> SceneData:  # fmt: skip
    """Triangles with corners of VERTICES."""
    data = SceneData()
    data.vertices = wp.array(VERTICES, dtype=wp.vec3, device=device)
    data.uvs = wp.array(np.zeros((1, 7, 2)) if uvs is None else uvs, dtype=wp.vec2, device=device)
    data.has_colors = colors is not None
    data.colors = wp.array(np.ones((1, 4)) if colors is None else colors, dtype=wp.vec4, device=device)
    data.triangles = wp.array(triangles, dtype=wp.vec3i, device=device)
    data.triangle_material = wp.array(materials, dtype=int, device=device)
    return data


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize(
    ("other", "equal"),
    [
        ([0, 1, 2], True),
        ([3, 4, 5], True),
        ([1, 2, 0], False),  # which rounds otherwise
        ([0, 2, 1], False),  # from behind
        ([6, 1, 2], False),
        ([0, 1, 1], False),
    ],
)
def test_the_same_corners_in_the_same_order_are_the_same_triangle(other: list[int], equal: bool, device: str) -> None:
    data = scene_data(np.array([[0, 1, 2], other]), np.zeros(2), device)
    assert distinct(data, 0, 2, looks=False)[0].numpy().tolist() == ([0] if equal else [0, 1])


def test_other_materials_make_another_triangle() -> None:
    data = scene_data(np.array([[4, 5, 6], [0, 1, 2], [0, 1, 2], [0, 1, 2]]), np.array([1, 1, 0, 0]))
    assert distinct(data, 1, 4, looks=False)[0].numpy().tolist() == [0, 1]
    assert distinct(data, 2, 4, looks=False)[0].numpy().tolist() == [0]


def test_what_looks_different_is_different_where_that_counts() -> None:
    uvs, colors = np.zeros((2, 7, 2)), np.ones((7, 4))
    uvs[1, 4, 1], colors[6, 3] = 0.5, 0.5
    triangles = np.array([[0, 1, 2], [3, 4, 5], [3, 1, 2]])
    for values in ({"uvs": uvs}, {"colors": colors[[0, 1, 2, 3, 6, 5, 4]]}):
        data = scene_data(triangles, np.zeros(3), **values)
        assert distinct(data, 0, 3, looks=True)[0].numpy().tolist() == [0, 1]
        assert distinct(data, 0, 3, looks=False)[0].numpy().tolist() == [0]


def test_a_million_in_one_place_are_one() -> None:
    data = scene_data(np.tile([0, 1, 2], (1_000_000, 1)), np.zeros(1_000_000))
    began = process_time()
    assert distinct(data, 0, 1_000_000, looks=False)[0].numpy().tolist() == [0]
    assert process_time() - began < 10.0


def listed(scene: DeviceScene, name: str) -> list[int]:
    return sorted(getattr(scene.data, name).faces.numpy().tolist())


def test_rays_look_for_one_of_equal_triangles() -> None:
    one, two = quad([0, 0, 0], [1, 0, 0], [0, 1, 0], 0), quad([0, 0, 0], [1, 0, 0], [0, 1, 0], 1)
    other = quad([0, 0, 1], [1, 0, 0], [0, 1, 0], 0)
    scene = resident_of([one, one, two, one, other], [grey(0.5), Material(alpha_mode=AlphaMode.MASK)])
    assert listed(scene, "opaque") == [0, 1, 6, 7]
    assert listed(scene, "masked") == [0, 1]
    assert scene.data.opaque_count == 8
    assert len(scene.data.triangles) == 10
