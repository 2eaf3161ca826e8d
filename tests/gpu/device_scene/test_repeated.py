from time import process_time

import numpy as np
import pytest
from scenes import grey, quad, resident_of

from gpu.device_scene.repeated import repeated
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import AlphaMode, Material

# Two times the same corners; 6 is beside 0, by as little as there is.
VERTICES = np.array(2 * [[0, 0, 0], [1, 0, 0], [0, 1, 0]] + [[1e-45, 0, 0]], np.float32)
VERTICES[3, 1] = -0.0


@pytest.mark.parametrize(
    ("other", "equal"),
    [
        ([0, 1, 2], True),
        ([1, 2, 0], True),
        ([5, 3, 4], True),
        ([0, 2, 1], False),  # from behind
        ([6, 1, 2], False),
        ([0, 1, 1], False),
    ],
)
def test_the_same_corners_in_the_same_sense_are_the_same_triangle(other: list[int], equal: bool) -> None:
    triangles = np.array([[0, 1, 2], other])
    assert repeated(VERTICES, triangles, np.zeros(2, int)).tolist() == [False, equal]


def test_other_materials_make_another_triangle() -> None:
    triangles = np.array([[0, 1, 2], [0, 1, 2], [1, 2, 0]])
    assert repeated(VERTICES, triangles, np.array([1, 0, 0])).tolist() == [False, False, True]


def test_a_million_in_one_place_are_one() -> None:
    began = process_time()
    again = repeated(VERTICES, np.tile([0, 1, 2], (1_000_000, 1)), np.zeros(1_000_000, int))
    assert again.sum() == 999_999
    assert process_time() - began < 10.0


def listed(scene: DeviceScene, name: str) -> list[int]:
    return sorted(getattr(scene.data, name).faces.numpy().tolist())


def test_rays_look_for_one_of_equal_triangles() -> None:
    one, two = quad([0, 0, 0], [1, 0, 0], [0, 1, 0], 0), quad([0, 0, 0], [1, 0, 0], [0, 1, 0], 1)
    scene = resident_of([one, one, two, one], [grey(0.5), Material(alpha_mode=AlphaMode.MASK)])
    assert listed(scene, "opaque") == [0, 1]
    assert listed(scene, "masked") == [0, 1]
    assert scene.data.opaque_count == 6
    assert len(scene.data.triangles) == 8
