import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import grey, quad, scene_of

from gpu.core.device import duplicate
from gpu.device_scene.bvh_refit import copied
from gpu.device_scene.data import SceneData
from gpu.device_scene.moved_tree import MovedTree, facts_of
from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import Floats


def quads(count: int, device: str) -> DeviceScene:
    """Small ones, here and there."""
    corners = np.random.default_rng(1).uniform(-0.4, 0.4, (count, 3)).tolist()
    scene = scene_of([quad(corner, [0.01, 0, 0], [0, 0.01, 0]) for corner in corners], [grey(0.5)])
    return DeviceScene(scene, device)


@pytest.mark.parametrize("device", DEVICES)
def test_a_tree_is_dear_where_boxes_have_become_wide(device: str) -> None:
    placed = quads(400, device)
    data, vertices = placed.data, placed.scene.vertices
    facts = facts_of(data, data.opaque, 0, len(placed.scene.triangles), looks=False)
    assert (facts.begin, facts.levels[:2], len(facts.twins)) == (0, (0, 1), 0)
    tree, moved, there = copied(data.opaque), MovedTree(facts, placed.device), duplicate(SceneData, data)
    there.vertices = wp.clone(data.vertices)

    def dear(places: Floats) -> bool:
        there.vertices.assign(places)
        moved.fit(tree, there)
        return moved.is_dear()

    own = vertices.reshape(-1, 6, 3)
    shuffled = np.random.default_rng(2).permutation(own[:, :1]) + own - own[:, :1]
    assert [dear(vertices + 0.1), dear(shuffled.reshape(-1, 3)), dear(vertices)] == [False, True, False]
    assert np.array_equal(tree.bounds.numpy(), data.opaque.bounds.numpy())


def test_triangles_that_were_left_out_have_to_stay_where_others_are() -> None:
    one, two = quad([0, 0, 0], [1, 0, 0], [0, 1, 0]), quad([0, 0, 1], [1, 0, 0], [0, 1, 0])
    placed = DeviceScene(scene_of([two, one, one, one], [grey(0.5)]), "cpu")
    facts = facts_of(placed.data, placed.data.opaque, 0, 8, looks=False)
    assert facts.twins.shape == (4, 2, 3)
    together, apart = placed.scene.vertices.copy(), placed.scene.vertices.copy()
    together[placed.scene.triangles[2:]] += np.float32(0.1)
    apart[placed.scene.triangles[6:]] += np.float32(0.1)
    assert facts.holds(placed.scene.vertices)
    assert facts.holds(together)
    assert not facts.holds(apart)
