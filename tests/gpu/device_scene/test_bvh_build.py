import numpy as np
import pytest
import warp as wp

from gpu.device_scene import bvh_build
from gpu.device_scene.binary_tree import NO_NODE
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_build import build, with_room

CPU = wp.get_device("cpu")


def tree_of(count: int) -> tuple[Bvh, np.ndarray]:
    """A tree over random triangles, and these (triangle, corner, 3)."""
    rng = np.random.default_rng(count)
    triangles = rng.uniform(-0.5, 0.5, (count, 1, 3)) + 0.05 * rng.uniform(-0.5, 0.5, (count, 3, 3))
    triangles = triangles.astype(np.float32)
    vertices = wp.array(triangles.reshape(-1, 3), dtype=wp.vec3, device=CPU)
    culled = wp.array(np.arange(count) % 2, dtype=float, device=CPU)
    return build(vertices, wp.array(np.arange(3 * count), dtype=int, device=CPU), culled), triangles


@pytest.mark.parametrize("count", [1, 2, 3, 8, 100, 3000])
def test_each_triangle_is_in_one_leaf_and_in_all_boxes_above(count: int) -> None:
    bvh, triangles = tree_of(count)
    bounds = bvh.bounds.numpy().reshape(-1, 3, 2, 4)
    children = bvh.children.numpy().reshape(-1, 2, 4)
    faces, corners = bvh.faces.numpy(), bvh.corners.numpy().reshape(-1, 3, 4)[:, :, :3]
    assert sorted(faces) == list(range(count))
    assert np.array_equal(corners, triangles[faces])
    assert np.array_equal(bvh.corners.numpy().reshape(-1, 3, 4)[:, 0, 3], faces % 2)
    visited: list[int] = []
    places: list[int] = []
    todo: list[tuple[int, list[np.ndarray]]] = [(0, [])]
    while todo:
        node, boxes = todo.pop()
        visited.append(node)
        for slot in range(4):
            child, number = children[node, :, slot]
            box = bounds[node, :, :, slot]
            if child == NO_NODE:
                assert (box > 1e20).all()
            elif number == 0:
                todo.append((int(child), [*boxes, box]))
            else:
                for place in range(child, child + number):
                    places.append(place)
                    for lower, upper in ((b[:, 0], b[:, 1]) for b in [*boxes, box]):
                        assert (corners[place] >= lower).all()
                        assert (corners[place] <= upper).all()
    assert sorted(visited) == list(range(len(visited)))
    assert len(children) == with_room(len(visited))
    assert not children[len(visited) :].any()
    assert sorted(places) == list(range(count))


def test_nodes_are_wide_where_there_is_enough_to_hold() -> None:
    bvh, _ = tree_of(3000)
    children = bvh.children.numpy().reshape(-1, 2, 4)
    children = children[: 1 + children[:, 0].max(initial=0, where=children[:, 1] == 0)]
    used = (children[:, 0] != NO_NODE).sum(axis=1)
    assert used.min() >= 2
    assert (used[: 1 + 4 + 16] == 4).all()  # those of the first levels
    assert used.mean() > 2.8


def test_more_levels_than_a_ray_can_keep_in_mind_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bvh_build, "MAX_LEVELS", 2)
    with pytest.raises(RuntimeError, match="3000 triangles has more than 2 levels"):
        tree_of(3000)


def test_there_is_room_for_up_to_an_eighth_more_nodes() -> None:
    lengths = [with_room(count) for count in range(1, 5000)]
    assert lengths == sorted(lengths)
    assert all(count <= length <= 1.125 * count for count, length in enumerate(lengths, 1))
    assert len(set(lengths[3000:4000])) <= 5


def test_a_row_of_ever_smaller_things_stays_as_it_was_built() -> None:
    """Rays would find them soonest in a chain that is longer than a ray's stack."""
    rng = np.random.default_rng(0)
    shapes = 0.3 * rng.uniform(-1.0, 1.0, (300, 3, 3)) + np.array([1.0, 0.0, 0.0])
    triangles = shapes * (0.4 * 1.1 ** -np.arange(300.0))[:, None, None]
    vertices = wp.array(triangles.reshape(-1, 3), dtype=wp.vec3, device=CPU)
    indices = wp.array(np.arange(900), dtype=int, device=CPU)
    bvh = build(vertices, indices, wp.zeros(300, dtype=float, device=CPU))
    assert sorted(bvh.faces.numpy()) == list(range(300))
