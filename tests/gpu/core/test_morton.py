import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.core.morton import EMPTY_KEY, morton_key, morton_order, pixel_of_morton_2d


@wp.kernel
def key_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], keys: wp.array[int]) -> None:
    """One thread a point: its key."""
    index = first + wp.tid()
    keys[index] = morton_key(position[index], normal[index])


def test_like_normals_lie_together_and_neighbours_are_near() -> None:
    rng = np.random.default_rng(0)
    count = 4000
    positions = rng.uniform(-0.5, 0.5, (count, 3))
    normals = np.eye(3)[rng.integers(0, 3, count)] * rng.choice([-1.0, 1.0], (count, 1))
    keys = results(key_kernel, count, [column(positions, wp.vec3), column(normals, wp.vec3)], wp.int32)
    assert keys.max() < int(EMPTY_KEY)
    order = np.argsort(keys)
    changes = (np.diff(normals[order], axis=0) != 0.0).any(axis=1).sum()
    assert changes == 5  # six directions, each in one run
    steps = np.linalg.norm(np.diff(positions[order], axis=0), axis=1)
    assert np.median(steps) < 0.15  # at random it is 0.66


def test_positions_at_the_edge_of_unit_space_are_clamped() -> None:
    inputs = [column([[0.5, 0.5, 0.5], [-0.5, -0.5, -0.5]], wp.vec3), column([[0, 0, 1]] * 2, wp.vec3)]
    low, high = sorted(results(key_kernel, 2, inputs, wp.int32))
    assert 0 <= low < high < int(EMPTY_KEY)


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (64, 32), (1000, 3)])
def test_pixels_are_ordered_by_the_bits_of_both_coordinates_in_turn(size: tuple[int, int]) -> None:
    order = morton_order(size, wp.get_device("cpu")).numpy()
    x, y = np.arange(size[0] * size[1]) % size[0], np.arange(size[0] * size[1]) // size[0]
    codes = sum((x >> bit & 1) << 2 * bit | (y >> bit & 1) << 2 * bit + 1 for bit in range(10))
    assert order.tolist() == np.argsort(codes).tolist()


@wp.kernel
def pixel_kernel(first: int, out: wp.array[wp.vec2i]) -> None:
    """One thread a number in Morton's order: its pixel."""
    code = first + wp.tid()
    out[code] = pixel_of_morton_2d(code)


def test_numbers_in_morton_s_order_tell_their_pixels() -> None:
    order = morton_order((64, 64), wp.get_device("cpu")).numpy()
    pixels = results(pixel_kernel, 4096, [], wp.vec2i)
    assert (pixels == np.stack([order % 64, order // 64], axis=1)).all()
