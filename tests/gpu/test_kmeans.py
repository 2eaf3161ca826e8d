import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column

from gpu.kmeans import KMeans, Points

CPU = wp.get_device("cpu")


def points_of(positions: NDArray, normals: NDArray, spacing: float, count: int | None = None) -> Points:
    """Points of weight one."""
    points = Points()
    points.position, points.normal = column(positions, wp.vec3), column(normals, wp.vec3)
    points.weight = column(np.ones(len(positions)), float)
    points.spacing = column(np.full(len(positions), spacing), float)
    points.count = column([len(positions) if count is None else count], wp.int32)
    return points


def plane(count: int, seed: int = 0) -> tuple[NDArray, NDArray]:
    """Points of a unit square that face up, along one axis."""
    rng = np.random.default_rng(seed)
    positions = np.stack([rng.uniform(-0.5, 0.5, count), np.zeros(count), rng.uniform(-0.5, 0.5, count)], axis=1)
    return positions[np.argsort(positions[:, 0])], np.tile([0.0, 1.0, 0.0], (count, 1))


@pytest.mark.parametrize("exhaustive", [True, False])
def test_representatives_are_members_nearest_their_means(exhaustive: bool) -> None:
    positions, normals = plane(600)
    kmeans = KMeans(600, 12, CPU, exhaustive=exhaustive)
    kmeans.run(points_of(positions, normals, 12**-0.5), 5, 0)
    items, starts, medoids = kmeans.groups.items.numpy(), kmeans.groups.starts.numpy(), kmeans.medoids.numpy()
    assert starts[12] == 600  # nobody is left out
    for cluster in range(12):
        members = items[starts[cluster] : starts[cluster + 1]]
        assert medoids[cluster] in members
        # One more round would move the mean a little: the medoid is near it, far nearer than a random member.
        offsets = np.linalg.norm(positions[members] - positions[members].mean(axis=0), axis=1)
        assert np.linalg.norm(positions[medoids[cluster]] - positions[members].mean(axis=0)) <= np.median(offsets)


def test_grid_and_exhaustive_search_agree() -> None:
    positions, normals = plane(800, 3)
    assignments = []
    for exhaustive in (True, False):
        kmeans = KMeans(800, 16, CPU, exhaustive=exhaustive)
        kmeans.run(points_of(positions, normals, 0.25), 4, 1)
        groups = np.zeros(800, int)
        items, starts = kmeans.groups.items.numpy(), kmeans.groups.starts.numpy()
        for cluster in range(16):
            groups[items[starts[cluster] : starts[cluster + 1]]] = cluster
        assignments.append(groups)
    assert np.array_equal(*assignments)


def test_k_means_lowers_the_spread_as_lloyds_algorithm_does() -> None:
    positions, normals = plane(2000, 5)

    def spread(iterations: int) -> float:
        kmeans = KMeans(2000, 20, CPU, exhaustive=True)
        kmeans.run(points_of(positions, normals, 0.2), iterations, 0)
        items, starts = kmeans.groups.items.numpy(), kmeans.groups.starts.numpy()
        groups = [positions[items[starts[c] : starts[c + 1]]] for c in range(20)]
        return float(sum(((group - group.mean(axis=0)) ** 2).sum() for group in groups if len(group)))

    assert spread(10) < 0.8 * spread(0)


def test_opposite_normals_never_share_a_cluster() -> None:
    positions, normals = plane(500)
    both = np.concatenate([positions, positions]), np.concatenate([normals, -normals])
    kmeans = KMeans(1000, 10, CPU)
    kmeans.run(points_of(*both, 0.4), 4, 0)
    items, starts = kmeans.groups.items.numpy(), kmeans.groups.starts.numpy()
    for cluster in range(10):
        sides = both[1][items[starts[cluster] : starts[cluster + 1]], 1]
        assert len(set(sides)) <= 1


def test_more_clusters_than_points_leaves_the_rest_unused() -> None:
    positions, normals = plane(5)
    kmeans = KMeans(8, 8, CPU)
    padded = np.concatenate([positions, np.zeros((3, 3))]), np.concatenate([normals, np.zeros((3, 3))])
    kmeans.run(points_of(*padded, 0.05, count=5), 3, 0)
    medoids = kmeans.medoids.numpy()
    assert sorted(medoids[medoids >= 0]) == [0, 1, 2, 3, 4]
    assert (kmeans.grid.data.spacing.numpy()[medoids < 0] == 0.0).all()


def test_one_cluster_and_no_points() -> None:
    positions, normals = plane(50)
    kmeans = KMeans(50, 1, CPU, exhaustive=True)
    kmeans.run(points_of(positions, normals, 1.0), 2, 0)
    assert kmeans.groups.starts.numpy().tolist() == [0, 50]
    kmeans.run(points_of(positions, normals, 1.0, count=0), 2, 0)
    assert kmeans.medoids.numpy().tolist() == [-1]


def test_the_same_seed_gives_the_same_bits() -> None:
    positions, normals = plane(3000, 9)
    outcomes = []
    for _ in range(3):
        kmeans = KMeans(3000, 64, CPU)
        kmeans.run(points_of(positions, normals, 0.125), 5, 7)
        outcomes.append((kmeans.medoids.numpy().tobytes(), kmeans.grid.data.position.numpy().tobytes()))
    assert outcomes[0] == outcomes[1] == outcomes[2]
