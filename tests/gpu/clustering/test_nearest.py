import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column, results

from gpu.clustering.grid import ClusteringParameters, Grid, Representatives, level_of, separation
from gpu.clustering.nearest import nearest_of_all, nearest_of_some, nearest_search
from gpu.core.parameters import parameters

# How much more a distance along the normal counts than one along the surface.
STRETCH = 8.0
COS_30 = 0.8660254  # 2022 paper, Eq. 7

CPU = wp.get_device("cpu")
NUMBER = 5
widening = nearest_search(1, widens=True)
SPACING = 0.08


@wp.func
def straight(chosen: ClusteringParameters, p: wp.vec3, p_normal: wp.vec3, q: wp.vec3, q_normal: wp.vec3) -> float:
    """Distance as the crow flies."""
    return wp.length(q - p)


def search_kernel(metric: wp.Function) -> wp.Kernel:
    """The kernel that searches by a metric."""
    search = nearest_search(NUMBER, metric)

    @wp.kernel
    def kernel(first: int, clusters: Representatives, position: wp.array[wp.vec3], normal: wp.array[wp.vec3],
               spacing: float, found: wp.array[int]) -> None:  # fmt: skip
        """One thread a point: its nearest representatives, found: (point, NUMBER) flattened."""
        point = first + wp.tid()
        nearest = search(clusters, position[point], normal[point], level_of(clusters.chosen, spacing))
        for f in range(wp.static(NUMBER)):
            found[NUMBER * point + f] = nearest.cluster[f]

    return kernel


@wp.kernel
def all_kernel(first: int, clusters: Representatives, position: wp.array[wp.vec3], normal: wp.array[wp.vec3],
               threshold: float, every: int, found: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: the nearest of all representatives, or of each `every`-th."""
    point = first + wp.tid()
    found[point] = nearest_of_all(clusters, clusters.spacing.shape[0], position[point], normal[point], threshold, every)


def scattered(count: int, seed: int) -> tuple[NDArray, NDArray]:
    """Points in unit space with normals near the axes."""
    rng = np.random.default_rng(seed)
    normals = np.eye(3)[rng.integers(0, 3, count)] * rng.choice([-1, 1], (count, 1)) + rng.normal(0, 0.1, (count, 3))
    return rng.uniform(-0.5, 0.5, (count, 3)), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def separations(points: tuple[NDArray, NDArray], clusters: tuple[NDArray, NDArray]) -> tuple[NDArray, NDArray]:
    """The metric and the cosines between normals, both (point, cluster)."""
    way = clusters[0][None] - points[0][:, None]
    here, there = np.abs((way * points[1][:, None]).sum(axis=2)), np.abs((way * clusters[1][None]).sum(axis=2))
    plane = np.maximum(here, there)
    stretched = np.sqrt((way**2).sum(axis=2) + (STRETCH**2 - 1.0) * plane**2)
    return stretched, points[1] @ clusters[1].T


def grid_of(clusters: tuple[NDArray, NDArray], used: NDArray, **changes: float) -> Grid:
    grid = Grid(len(used), CPU, parameters(ClusteringParameters, **changes))
    for name, values in (("position", clusters[0]), ("normal", clusters[1]), ("spacing", np.where(used, SPACING, 0.0))):
        getattr(grid.data, name).assign(values.astype(np.float32))
    grid.build()
    return grid


def expected_nearest(
    points: tuple[NDArray, NDArray], clusters: tuple[NDArray, NDArray], usable: NDArray, distance: NDArray
) -> NDArray:
    """The nearest of the `usable` (point, cluster) in the 27 cells around, (point, NUMBER)."""
    cell = 2.0 ** np.ceil(np.log2(1.5 * SPACING))
    cells = [np.floor(p[0].astype(np.float32) / np.float32(cell)) for p in (points, clusters)]
    near = (np.abs(cells[1][None] - cells[0][:, None]) <= 1).all(axis=2)
    distance = np.where(near & usable, distance, np.inf)
    expected = np.argsort(distance, axis=1)[:, :NUMBER]
    return np.where(np.isfinite(np.take_along_axis(distance, expected, axis=1)), expected, -1)


@pytest.mark.parametrize("threshold", [COS_30, 0.0])
@pytest.mark.parametrize("metric", [separation, straight])
def test_the_nearest_of_like_normal_come_in_order(metric: wp.Function, threshold: float) -> None:
    points, clusters = scattered(300, 0), scattered(500, 1)
    used = np.arange(len(clusters[0])) % 7 != 0
    inputs = [column(points[0], wp.vec3), column(points[1], wp.vec3)]
    kernel = search_kernel(metric)
    grid = grid_of(clusters, used, normal_threshold=threshold)
    found = results(kernel, 300, [grid.data, *inputs, SPACING], wp.int32, NUMBER)
    distance, cosine = separations(points, clusters)
    if metric is straight:
        distance = np.linalg.norm(clusters[0][None] - points[0][:, None], axis=2)
    expected = expected_nearest(points, clusters, (cosine > threshold) & used[None], distance)
    assert (expected == -1).any()
    assert (expected[:, -1] >= 0).any()
    assert np.array_equal(found.reshape(300, NUMBER), expected)


def test_of_all_a_like_normal_comes_first_but_none_is_left_out() -> None:
    points, clusters = scattered(200, 2), scattered(7, 3)
    used = np.arange(7) > 2
    inputs = [column(points[0], wp.vec3), column(points[1], wp.vec3)]
    threshold = COS_30
    found = results(all_kernel, 200, [grid_of(clusters, used).data, *inputs, threshold, 1], wp.int32)
    distance, cosine = separations(points, clusters)
    distance = np.where(used[None], distance + 1000.0 * (cosine <= threshold), np.inf)
    assert (distance.min(axis=1) > 1000.0).any()  # for some there is no like normal
    assert np.array_equal(found, distance.argmin(axis=1))
    assert (
        results(all_kernel, 200, [grid_of(clusters, used & False).data, *inputs, threshold, 1], wp.int32) == -1
    ).all()


@wp.kernel
def some_kernel(first: int, clusters: Representatives, search: int, found: wp.array[int]) -> None:
    """One thread: about the nearest one to the origin."""
    up = wp.vec3(0.0, 1.0, 0.0)
    found[first + wp.tid()] = nearest_of_some(clusters, clusters.spacing.shape[0], wp.vec3(0.0, 0.0, 0.0), up, search)


@pytest.mark.parametrize(("used", "nearest"), [([5, 6], 6), ([3, 5], 5), ([], -1)])
def test_of_some_the_nearest_is_taken_and_of_all_if_none_of_these_is_in_use(used: list[int], nearest: int) -> None:
    """Of ten the first and the seventh are looked at; farther ones come first."""
    places = np.stack([np.linspace(0.5, 0.1, 10), np.zeros(10), np.zeros(10)], axis=1)
    grid = grid_of((places, np.tile([0.0, 1.0, 0.0], (10, 1))), np.isin(np.arange(10), used))
    assert results(some_kernel, 1, [grid.data, 2], wp.int32).tolist() == [nearest]


@wp.kernel
def widening_kernel(first: int, clusters: Representatives, normals: wp.array[wp.vec3], spacing: float,
                    found: wp.array[wp.vec2i]) -> None:  # fmt: skip
    """One thread a normal at the origin: its nearest representative, and whether that has a like normal."""
    point = first + wp.tid()
    nearest = widening(clusters, wp.vec3(0.0, 0.0, 0.0), normals[point], level_of(clusters.chosen, spacing))
    found[point] = wp.vec2i(nearest.cluster[0], int(nearest.alike))


def widened(spacing: float, degrees: float) -> tuple[int, int]:
    """What a point of SPACING finds of one cluster of another spacing beside it, whose normal is turned."""
    grid = Grid(1, CPU)
    grid.data.position.assign(np.array([[0.01, 0.0, 0.0]], np.float32))
    grid.data.normal.assign(np.array([[0.0, 1.0, 0.0]], np.float32))
    grid.data.spacing.fill_(spacing)
    grid.build()
    angle = np.radians(degrees)
    normals = column([[np.sin(angle), np.cos(angle), 0.0]], wp.vec3)
    ((cluster, alike),) = results(widening_kernel, 1, [grid.data, normals, SPACING], wp.vec2i)
    return int(cluster), int(alike)


@pytest.mark.parametrize(
    ("octaves", "degrees", "expected"),
    [
        (0, 20.0, (0, 1)),
        (3, 20.0, (0, 1)),  # in cells of four times the size
        (4, 20.0, (-1, 0)),  # too far apart in size
        (0, 29.0, (0, 1)),  # 2022 paper, Eq. 7: within 30°
        (0, 31.0, (0, 0)),
        (0, 89.0, (0, 0)),
        (3, 80.0, (0, 0)),
        (0, 91.0, (-1, 0)),
    ],
)
def test_a_search_that_widens_takes_larger_cells_then_other_normals(
    octaves: int, degrees: float, expected: tuple[int, int]
) -> None:
    assert widened(SPACING * 2.0**octaves, degrees) == expected
