import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column, results

from gpu.clustering.cluster_bounds import (
    PER_RUN,
    ClusterRunBounds,
    allocate_runs,
    bound_runs,
    nearest_in_runs,
    stretched,
)
from gpu.clustering.grid import Grid, Representatives
from gpu.clustering.nearest import nearest_of_all

CPU = wp.get_device("cpu")


@wp.kernel
def runs_kernel(first: int, clusters: Representatives, runs: ClusterRunBounds, position: wp.array[wp.vec3],
                normal: wp.array[wp.vec3], guess: wp.array[int], found: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: its nearest cluster."""
    point = first + wp.tid()
    found[point] = nearest_in_runs(clusters, runs, position[point], normal[point], guess[point], 0, 1)


@wp.kernel
def lanes_kernel(first: int, clusters: Representatives, runs: ClusterRunBounds, position: wp.array[wp.vec3],
                 normal: wp.array[wp.vec3], guess: wp.array[int], lanes: int,
                 found: wp.array2d[float]) -> None:  # fmt: skip
    """One thread a lane of a point: the cluster that is the nearest to it, and how far that is."""
    lane = first + wp.tid()
    point = lane // lanes
    nearest = nearest_in_runs(clusters, runs, position[point], normal[point], guess[point], lane % lanes, lanes)
    found[lane, 0] = stretched(clusters, nearest, position[point], normal[point])
    found[lane, 1] = float(nearest)


@wp.kernel
def all_kernel(first: int, clusters: Representatives, position: wp.array[wp.vec3], normal: wp.array[wp.vec3],
               found: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: its nearest cluster, by a look at each."""
    point = first + wp.tid()
    count = clusters.spacing.shape[0]
    threshold = clusters.chosen.normal_threshold
    found[point] = nearest_of_all(clusters, count, position[point], normal[point], threshold, 1)


def patches(count: int, seed: int) -> tuple[NDArray, NDArray]:
    """Points on small patches that face everywhere, a run of patches side by side."""
    rng = np.random.default_rng(seed)
    centre, axis = rng.uniform(-0.5, 0.5, (count // 10, 3)), rng.normal(size=(count // 10, 3))
    position = np.repeat(centre, 10, axis=0) + rng.normal(0.0, 0.02, (count, 3))
    normal = np.repeat(axis, 10, axis=0) + rng.normal(0.0, 0.2, (count, 3))
    return position, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def clusters_at(position: NDArray, normal: NDArray, used: NDArray) -> Representatives:
    clusters = Grid(len(position), CPU).data
    for name, values in (("position", position), ("normal", normal), ("spacing", used)):
        getattr(clusters, name).assign(values.astype(np.float32))
    return clusters


@pytest.mark.parametrize("share", [1.0, 0.7, 0.01])
def test_it_finds_what_a_look_at_each_finds(share: float) -> None:
    count = 70 * int(PER_RUN) + 3
    position, normal = patches(10 * count, 1)
    used = np.random.default_rng(2).uniform(size=count) < share
    clusters, runs = clusters_at(position[::10], normal[::10], used), allocate_runs(count, CPU)
    bound_runs(clusters, runs)
    points = [column(values, wp.vec3) for values in patches(3000, 3)]
    guess = column(np.random.default_rng(4).choice(np.flatnonzero(used), 3000), wp.int32)
    found = results(runs_kernel, 3000, [clusters, runs, *points, guess], wp.int32)
    assert np.array_equal(found, results(all_kernel, 3000, [clusters, *points], wp.int32))


def test_the_nearest_of_what_its_lanes_find_is_a_points_nearest() -> None:
    """On a GPU lanes tell each other; here each keeps what it has found."""
    count, number, lanes = 70 * int(PER_RUN) + 3, 500, 8
    position, normal = patches(10 * count, 1)
    clusters, runs = clusters_at(position[::10], normal[::10], np.ones(count)), allocate_runs(count, CPU)
    bound_runs(clusters, runs)
    points = [column(values, wp.vec3) for values in patches(number, 3)]
    guess = column(np.random.default_rng(4).integers(0, count, number), wp.int32)
    found = wp.zeros((number * lanes, 2), dtype=float, device=CPU)
    wp.launch(lanes_kernel, dim=number * lanes, inputs=[0, clusters, runs, *points, guess, lanes, found], device=CPU)
    each = found.numpy().reshape(number, lanes, 2)
    nearest = [min(map(tuple, of_point))[1] for of_point in each.tolist()]
    assert np.array_equal(nearest, results(all_kernel, number, [clusters, *points], wp.int32))
    assert (each[:, :, 1].std(axis=1) > 0.0).any()


def test_of_equally_near_ones_the_first_is_found() -> None:
    count = 3 * int(PER_RUN)
    up = np.tile([0.0, 1.0, 0.0], (count, 1))
    clusters, runs = clusters_at(np.zeros((count, 3)), up, np.arange(count) > 1), allocate_runs(count, CPU)
    bound_runs(clusters, runs)
    inputs = [clusters, runs, column(np.ones((1, 3)), wp.vec3), column(up[:1], wp.vec3)]
    assert results(runs_kernel, 1, [*inputs, column([count - 1], wp.int32)], wp.int32)[0] == 2


def test_far_and_unlike_runs_are_not_looked_at() -> None:
    """Clusters moved after their run was bounded are found only where the run is looked at."""
    count = 2 * int(PER_RUN)
    position, up = np.zeros((count, 3)), np.tile([0.0, 1.0, 0.0], (count, 1))
    second = np.arange(count) >= int(PER_RUN)
    inputs = [column(np.zeros((1, 3)), wp.vec3), column(up[:1], wp.vec3), column([0], wp.int32)]
    near = np.where(second, 0.0, 0.1)[:, None] * [1.0, 0.0, 0.0]
    for bounded, looked_at in (((0.2, 1.0), False), ((0.05, 1.0), True), ((0.05, -1.0), False)):
        x, y = bounded
        position = np.where(second, x, 0.1)[:, None] * [1.0, 0.0, 0.0]
        clusters, runs = (
            clusters_at(position, np.where(second[:, None], y, 1.0) * up, second >= 0),
            allocate_runs(count, CPU),
        )
        bound_runs(clusters, runs)
        moved = clusters_at(near, up, second >= 0)
        assert (results(runs_kernel, 1, [moved, runs, *inputs], wp.int32)[0] >= int(PER_RUN)) == looked_at


@pytest.mark.parametrize(("away", "looked_at"), [(0.2, False), (0.05, True)])
def test_far_runs_are_not_looked_at_from_where_all_normals_are_unlike(away: float, looked_at: bool) -> None:
    count = 2 * int(PER_RUN)
    second, up = np.arange(count) >= int(PER_RUN), np.tile([0.0, 1.0, 0.0], (count, 1))

    def at(x: float) -> Representatives:
        return clusters_at(np.where(second, x, 0.1)[:, None] * [1.0, 0.0, 0.0], up, second >= 0)

    runs = allocate_runs(count, CPU)
    bound_runs(at(away), runs)
    inputs = [column(np.zeros((1, 3)), wp.vec3), column(-up[:1], wp.vec3), column([0], wp.int32)]
    assert (results(runs_kernel, 1, [at(0.0), runs, *inputs], wp.int32)[0] >= int(PER_RUN)) == looked_at
