import numpy as np
import pytest
import warp as wp
from lit_surfaces import by_hand, floors, joined, mapped
from scenes import column, results, square_of_vpls

from gpu.scene.types import Doubles, Ints
from gpu.vpl.radiosity_cache import CELLS_MOVED, RadiosityCache, vpl_around


@wp.kernel
def around_kernel(first: int, lit: RadiosityCache, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], scale: float,
                  out: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: the VPL that answers for it."""
    point = first + wp.tid()
    out[point] = vpl_around(lit, position[point], normal[point], scale)


def around(lit: RadiosityCache, points: Doubles, normals: Doubles, scale: float = 1e-3) -> Ints:
    """The VPLs that answer for points, (point,)."""
    inputs = [lit, column(points, wp.vec3), column(normals, wp.vec3), scale]
    return results(around_kernel, len(points), inputs, wp.int32).astype(np.int32)


def test_vpls_without_neighbours_have_no_disk() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(1))
    assert (lit.radius.numpy() == 0.0).all()
    assert (lit.radiosity.numpy() == 0.0).all()
    assert (around(lit, np.zeros((1, 3)), np.array([[0.0, 1.0, 0.0]])) == -1).all()


def test_a_point_is_answered_by_a_vpl_near_it_on_its_surface() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(2500, seed=4))
    points = np.random.default_rng(5).uniform(-0.25, 0.25, (200, 3)) * [1.0, 0.0, 1.0]
    up = np.tile([0.0, 1.0, 0.0], (200, 1))
    found = around(lit, points, up)
    assert (found >= 0).all()
    distance = np.linalg.norm(lit.position.numpy()[found] - points, axis=1)
    assert (distance < 2.0 * lit.radius.numpy()[found]).all()
    assert (around(lit, points, -up) == -1).all()
    for away in ((0.0, 0.2, 0.0), (1.0, 0.0, 0.0)):
        assert (around(lit, points + np.array(away), up) == -1).all()


def test_surfaces_of_dense_and_of_sparse_vpls_both_answer() -> None:
    heights = (0.0, 0.3)
    dense, sparse = square_of_vpls(10_000, heights[0], seed=4), square_of_vpls(100, heights[1], seed=5)
    lit = mapped(floors(heights), joined(dense, sparse))
    points = np.random.default_rng(6).uniform(-0.2, 0.2, (200, 3)) * [1.0, 0.0, 1.0]
    up = np.tile([0.0, 1.0, 0.0], (200, 1))
    for height in heights:
        found = around(lit, points + np.array([0.0, height, 0.0]), up)
        assert (found >= 0).all()
        assert lit.position.numpy()[found, 1] == pytest.approx(np.full(200, height))


def test_of_many_vpls_in_a_cell_those_that_are_read_lie_all_over_it() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(10_000))  # row after row
    points = np.random.default_rng(5).uniform(-0.25, 0.25, (500, 3)) * [1.0, 0.0, 1.0]
    found = around(lit, points, np.tile([0.0, 1.0, 0.0], (500, 1)), 0.015)
    assert (found >= 0).all()
    distance = np.linalg.norm(lit.position.numpy()[found] - points, axis=1)
    assert np.quantile(distance / lit.radius.numpy()[found], 0.9) < 1.0


@pytest.mark.parametrize("scale", [1.0, 1e-6])
def test_vpls_of_radii_far_from_what_is_asked_for_are_not_found(scale: float) -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(2500, seed=4))
    up = np.array([[0.0, 1.0, 0.0]])
    assert around(lit, np.zeros((1, 3)), up)[0] >= 0
    assert around(lit, np.zeros((1, 3)), up, scale)[0] == -1


# Where cells begin.
CORNER = -np.array([[*CELLS_MOVED]], np.float64)


@pytest.mark.parametrize(("radii", "answers"), [(0.1, True), (1.9, True), (2.1, False)])
def test_a_vpl_answers_within_two_of_its_radii(radii: float, answers: bool) -> None:
    radius = 0.0148
    # The largest of its cells are of 4.2 radii.
    begin = CORNER + 1e-3 * radius
    point = begin + np.array([radii * radius, 0.0, 0.0])
    assert (around(by_hand(begin, radius), point, np.array([[0.0, 1.0, 0.0]]))[0] == 0) == answers


@pytest.mark.parametrize(("scale", "answers"), [(2.6, True), (3.1, False), (1.0 / 900.0, False), (1.0 / 600.0, True)])
def test_a_vpl_stands_in_cells_of_three_sizes_and_nine_are_searched(scale: float, answers: bool) -> None:
    radius = 0.0148
    point = CORNER + 1e-3 * radius
    assert (around(by_hand(point, radius), point, np.array([[0.0, 1.0, 0.0]]), scale * radius)[0] == 0) == answers


def test_points_of_a_wall_at_the_end_of_unit_space_are_in_one_cell_whatever_rounding_makes_of_them() -> None:
    wall = np.array([[0.2, -0.5, 0.1]])
    for size in (0.0148, 0.1):
        for towards in (-1.0, 0.0):
            point = np.array([[0.2, float(np.nextafter(np.float32(-0.5), np.float32(towards))), 0.1]])
            assert around(by_hand(wall, size), point, np.array([[0.0, 1.0, 0.0]]))[0] == 0


@pytest.mark.parametrize(("count", "read"), [(12, 12), (24, 12)])
def test_twelve_vpls_of_a_cell_are_read_at_most(count: int, read: int) -> None:
    positions = CORNER + np.random.default_rng(2).uniform(0.001, 0.015, (count, 3)) * [1.0, 0.0, 1.0] + [0.0, 1e-4, 0.0]
    found = around(by_hand(positions, 0.0148), positions, np.tile([0.0, 1.0, 0.0], (count, 1)))
    assert (found == np.arange(count)).sum() == read
