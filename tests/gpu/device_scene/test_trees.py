import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import grey, quad, scene_of

from gpu.device_scene.trees import tree_over
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import Material


@pytest.mark.parametrize("device", DEVICES)
def test_a_tree_numbers_its_triangles_from_the_first_and_leaves_repeated_ones_out(device: str) -> None:
    """And knows the corners of each, and whether its back is culled."""
    one, two = quad([0, 0, 0], [1, 0, 0], [0, 1, 0], 0), quad([0, 0, 1], [1, 0, 0], [0, 1, 0], 1)
    scene = DeviceScene(scene_of([two, one, one, two], [grey(0.5), Material(double_sided=False)]), device)
    culled = wp.array([0, 1, 0, 1, 0, 1, 0, 1], dtype=float, device=device)
    tree = tree_over(scene.data, culled, 2, 8)
    faces, corners = tree.faces.numpy(), tree.corners.numpy().reshape(-1, 3, 4)
    assert sorted(faces.tolist()) == [0, 1, 4, 5]
    expected = scene.data.vertices.numpy()[scene.data.triangles.numpy()[2 + faces]]
    assert np.array_equal(corners[:, :, :3], expected)
    assert np.array_equal(corners[:, 0, 3], culled.numpy()[2 + faces])
