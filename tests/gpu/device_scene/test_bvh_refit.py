import numpy as np
import pytest
import warp as wp
from devices import DEVICES

from gpu.device_scene.binary_tree import NO_NODE
from gpu.device_scene.bvh import MAX_LEVELS, Bvh
from gpu.device_scene.bvh_build import build
from gpu.device_scene.bvh_refit import copied, refit
from gpu.scene.types import Doubles


def arrays(corners: Doubles, device: str) -> tuple[wp.array, wp.array, wp.array]:
    """Vertices, triangles of three each and their corners' indices of triangles (triangle, corner, 3)."""
    numbers = np.arange(3 * len(corners))
    return (
        wp.array(corners.reshape(-1, 3), dtype=wp.vec3, device=device),
        wp.array(numbers.reshape(-1, 3), dtype=wp.vec3i, device=device),
        wp.array(numbers, dtype=int, device=device),
    )


def boxes(bvh: Bvh) -> dict[int, Doubles]:
    """Of each node that there is, the least and the greatest of its children's bounds, (2, 3)."""
    children, bounds = bvh.children.numpy().reshape(-1, 2, 4), bvh.bounds.numpy().reshape(-1, 3, 2, 4)
    there = {node: children[node, 0] != NO_NODE for node in range(bvh.levels.numpy()[-1])}
    return {
        node: np.array([bounds[node, :, 0, used].min(axis=0), bounds[node, :, 1, used].max(axis=0)])
        for node, used in there.items()
    }


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("count", [1, 7, 500])
def test_boxes_follow_what_is_in_them_as_closely_as_those_of_a_new_tree(count: int, device: str) -> None:
    rng = np.random.default_rng(count)
    before = rng.uniform(-0.5, 0.5, (count, 1, 3)) + 0.05 * rng.uniform(-0.5, 0.5, (count, 3, 3))
    after = np.where(np.arange(count)[:, None, None] % 3, before, before + 0.3).astype(np.float32)
    first = np.zeros((2, 3, 3), np.float32)  # triangles of other trees
    culled = wp.array(np.arange(count) % 2, dtype=float, device=device)
    vertices, triangles, _ = arrays(np.concatenate([first, after]), device)
    bvh = build(*arrays(before.astype(np.float32), device)[::2], culled)
    kept = [getattr(bvh, name).numpy().copy() for name in ("bounds", "corners", "children", "faces")]
    fitted, levels = copied(bvh), bvh.levels.numpy().tolist()
    refit(fitted, levels, vertices, triangles, 2)
    found = fitted.corners.numpy().reshape(-1, 3, 4)
    assert np.array_equal(found[:, :, :3], after[bvh.faces.numpy()])
    assert np.array_equal(found[:, 0, 3], bvh.faces.numpy() % 2)
    again = copied(fitted)
    refit(again, levels, *arrays(before.astype(np.float32), device)[:2], 0)
    for name, values in zip(("bounds", "corners", "children", "faces"), kept, strict=True):
        assert np.array_equal(getattr(bvh, name).numpy(), values)  # which stays as it was
        assert np.array_equal(getattr(again, name).numpy(), values)
    assert np.array_equal(boxes(fitted)[0], [after.min(axis=(0, 1)), after.max(axis=(0, 1))])
    sizes = [np.prod(np.diff(box, axis=0)) for box in boxes(fitted).values()]
    assert np.isfinite(sizes).all()
    assert len(bvh.levels) == MAX_LEVELS + 1
