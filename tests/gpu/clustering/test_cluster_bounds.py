import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA
from numpy.typing import NDArray
from scenes import column, results

from gpu.clustering.cluster_bounds import PER_RUN, ClusterRunBounds, ClusterRuns, nearest_in_runs
from gpu.clustering.grid import Grid, Representatives
from gpu.clustering.nearest import nearest_of_all

CPU = wp.get_device("cpu")


@wp.kernel
def runs_kernel(first: int, clusters: Representatives, runs: ClusterRunBounds, position: wp.array[wp.vec3],
                normal: wp.array[wp.vec3], guess: wp.array[int], lanes: int, found: wp.array[int]) -> None:  # fmt: skip
    """`lanes` threads a point: its nearest cluster."""
    index = first + wp.tid()
    point = index // lanes
    lane = index % lanes
    nearest = nearest_in_runs(clusters, runs, position[point], normal[point], guess[point], lane, lanes)
    if lane == 0:
        found[point] = nearest


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


def clusters_at(position: NDArray, normal: NDArray, used: NDArray, device: wp.Device = CPU) -> Representatives:
    clusters = Grid(len(position), device).data
    for name, values in (("position", position), ("normal", normal), ("spacing", used)):
        getattr(clusters, name).assign(values.astype(np.float32))
    return clusters


def bounds_of(clusters: Representatives) -> ClusterRunBounds:
    runs = ClusterRuns(len(clusters.spacing), clusters.spacing.device)
    runs.bound(clusters)
    return runs.bounds


@pytest.mark.parametrize("share", [1.0, 0.7, 0.01])
def test_it_finds_what_a_look_at_each_finds(share: float) -> None:
    count = 70 * int(PER_RUN) + 3
    position, normal = patches(10 * count, 1)
    used = np.random.default_rng(2).uniform(size=count) < share
    clusters = clusters_at(position[::10], normal[::10], used)
    points = [column(values, wp.vec3) for values in patches(3000, 3)]
    guess = column(np.random.default_rng(4).choice(np.flatnonzero(used), 3000), wp.int32)
    found = results(runs_kernel, 3000, [clusters, bounds_of(clusters), *points, guess, 1], wp.int32)
    assert np.array_equal(found, results(all_kernel, 3000, [clusters, *points], wp.int32))


def test_it_finds_those_of_both_sides_of_a_thin_wall() -> None:
    rng, missed = np.random.default_rng(5), list[int]()
    for count in range(8, 12):
        for _ in range(8):
            axis = rng.normal(size=3)
            sides = [rng.choice([1.0, -1.0], number, p=[0.8, 0.2])[:, None] for number in (count, 200)]
            (position, normal), points = ((rng.uniform(-0.5, 0.5, (len(it), 3)), it * axis) for it in sides)
            length = np.linalg.norm(axis)
            clusters = clusters_at(position, normal / length, np.ones(count))
            wanted = [column(points[0], wp.vec3), column(points[1] / length, wp.vec3)]
            inputs = [clusters, bounds_of(clusters), *wanted, column(np.zeros(200), wp.int32), 1]
            found = results(runs_kernel, 200, inputs, wp.int32)
            missed.append(np.count_nonzero(found != results(all_kernel, 200, [clusters, *wanted], wp.int32)))
    assert missed == [0] * len(missed)


@NEEDS_CUDA
def test_eight_threads_find_what_one_does_on_cuda() -> None:
    count, number, device = 70 * int(PER_RUN) + 3, 3000, wp.get_device("cuda:0")
    position, normal = patches(10 * count, 1)
    clusters = clusters_at(position[::10], normal[::10], np.arange(count) % 5 > 0, device)
    points = [wp.array(values, dtype=wp.vec3, device=device) for values in patches(number, 3)]
    guess = wp.full(number, 1, dtype=int, device=device)
    inputs = [0, clusters, bounds_of(clusters), *points, guess]
    found = [wp.zeros(number, dtype=int, device=device) for _ in range(2)]
    for lanes, of_lanes in zip((1, 8), found, strict=True):
        wp.launch(runs_kernel, dim=lanes * number, inputs=[*inputs, lanes, of_lanes], device=device)
    assert np.array_equal(*(of_lanes.numpy() for of_lanes in found))


def test_of_equally_near_ones_the_first_is_found() -> None:
    count = 3 * int(PER_RUN)
    up = np.tile([0.0, 1.0, 0.0], (count, 1))
    clusters = clusters_at(np.zeros((count, 3)), up, np.arange(count) > 1)
    inputs = [clusters, bounds_of(clusters), column(np.ones((1, 3)), wp.vec3), column(up[:1], wp.vec3)]
    assert results(runs_kernel, 1, [*inputs, column([count - 1], wp.int32), 1], wp.int32)[0] == 2


def test_runs_are_of_neighbours_whatever_their_numbers() -> None:
    """Such as start again at a random point would make their run as wide as the scene."""
    position, _ = patches(80 * int(PER_RUN), 1)
    up = np.tile([0.0, 1.0, 0.0], (len(position), 1))
    radii = [
        np.sort(bounds_of(clusters_at(of, up, np.ones(len(of)))).sphere.numpy()[:, 3])
        for of in (position, np.random.default_rng(2).permutation(position))
    ]
    assert np.median(radii[1]) < 0.25
    assert np.allclose(*radii, rtol=0.1, atol=0.01)


def is_looked_at(bounded: tuple[float, float], normal: float) -> bool:
    """Whether, from the middle of things, a search looks at a run that was bounded at this x and y of its normals, when
    there is another at 0.1: all of it was moved to the middle since.

    normal: y of the point's.
    """
    count = 2 * int(PER_RUN)
    x, y = bounded
    second, up = np.arange(count) >= int(PER_RUN), np.tile([0.0, 1.0, 0.0], (count, 1))
    position = np.where(second, x, 0.1)[:, None] * [1.0, 0.0, 0.0]
    clusters = clusters_at(position, np.where(second, y, 1.0)[:, None] * up, np.ones(count))
    runs = bounds_of(clusters)
    for array, value in ((runs.place, [0.0, 0.0, 0.0]), (runs.normal, [0.0, 1.0, 0.0])):
        moved = array.numpy()
        moved[runs.place.numpy()[:, 3] >= int(PER_RUN), :3] = value
        array.assign(moved)
    inputs = [column(np.zeros((1, 3)), wp.vec3), column(normal * up[:1], wp.vec3), column([0], wp.int32), 1]
    return bool(results(runs_kernel, 1, [clusters, runs, *inputs], wp.int32)[0] >= int(PER_RUN))


@pytest.mark.parametrize(("bounded", "looked_at"), [((0.2, 1.0), False), ((0.05, 1.0), True), ((0.05, -1.0), False)])
def test_far_and_unlike_runs_are_not_looked_at(bounded: tuple[float, float], *, looked_at: bool) -> None:
    assert is_looked_at(bounded, 1.0) == looked_at


@pytest.mark.parametrize(("away", "looked_at"), [(0.2, False), (0.05, True)])
def test_far_runs_are_not_looked_at_from_where_all_normals_are_unlike(away: float, *, looked_at: bool) -> None:
    assert is_looked_at((away, 1.0), -1.0) == looked_at
