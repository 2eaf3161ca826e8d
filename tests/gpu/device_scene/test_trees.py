import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import grey, quad, scene_of

from gpu.core.device import duplicate
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.data import SceneData
from gpu.device_scene.ray_cost import ray_costs
from gpu.device_scene.trees import tree_of_moved, tree_over
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import Doubles, Material


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


def test_a_tree_is_kept_where_it_still_fits_what_has_moved() -> None:
    """Not where something lies in the place of something else, now or before, nor where boxes have become wide."""
    rng = np.random.default_rng(1)
    corners = rng.uniform(-0.4, 0.4, (400, 3)).tolist()
    scene = scene_of([quad(corner, [0.01, 0, 0], [0, 0.01, 0]) for corner in corners], [grey(0.5)])
    placed = DeviceScene(scene, "cpu")
    count, usual = len(scene.triangles), ray_costs(placed.data.opaque).mean()

    def fitted(places: Doubles) -> "Bvh | None":
        moved = duplicate(SceneData, placed.data)
        moved.vertices = wp.array(places, dtype=wp.vec3, device="cpu")
        return tree_of_moved(moved, placed.data.opaque, usual, 0, count)

    assert fitted(scene.vertices + 0.1) is not None
    shuffled = np.repeat(rng.permutation(scene.vertices.reshape(-1, 6, 3)[:, :1]), 6, axis=1)
    assert (
        fitted((shuffled + scene.vertices.reshape(-1, 6, 3) - scene.vertices.reshape(-1, 6, 3)[:, :1]).reshape(-1, 3))
        is None
    )
    together = scene.vertices.copy()
    together[:6] = together[6:12]
    assert fitted(together) is None
