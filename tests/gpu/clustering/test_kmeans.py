import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column

from gpu.clustering.kmeans import KMeans
from gpu.clustering.points import Points

# How much more a distance along the normal counts than one along the surface.
STRETCH = 8.0
COS_30 = 0.8660254  # 2022 paper, Eq. 7

CPU = wp.get_device("cpu")
# Added to the distance where normals differ, so that a like normal comes first however far.
APART = 1000.0


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


def hashed(x: int) -> int:
    """lowbias32 on Python integers."""
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        x = ((x ^ (x >> shift)) * factor) & 0xFFFFFFFF
    return x ^ (x >> 16)


def separations(p: NDArray, p_normal: NDArray, q: NDArray, q_normal: NDArray) -> NDArray:
    """The metric between all of (point, 3) and of (cluster, 3)."""
    way = q[None] - p[:, None]
    plane = np.maximum(np.abs((way * p_normal[:, None]).sum(axis=2)), np.abs((way * q_normal[None]).sum(axis=2)))
    distance = np.sqrt((way**2).sum(axis=2) + (STRETCH**2 - 1.0) * plane**2)
    return distance + APART * (p_normal @ q_normal.T <= COS_30)


def algorithm_1(
    p: NDArray, n: NDArray, w: NDArray, clusters: int, iterations: int, seed: int
) -> tuple[NDArray, list[int], int]:
    """Each point's cluster, the medoids, and how often a cluster was seeded again."""
    count = len(p)
    keys = np.arange(count) * clusters // count
    position, normal, seeded = np.zeros((clusters, 3)), np.zeros((clusters, 3)), 0
    for iteration in range(-1, iterations):
        if iteration >= 0:
            keys = separations(p, n, position, normal).argmin(axis=1)
        for k in range(clusters):
            members = keys == k
            if members.any():
                position[k] = np.average(p[members], axis=0, weights=w[members])
                total = (n[members] * w[members, None]).sum(axis=0)
                normal[k] = total / np.linalg.norm(total)
            else:
                point = hashed(k ^ hashed(seed + iteration + 1)) % count
                position[k], normal[k] = p[point], n[point]
                seeded += 1
    distance = separations(p, n, position, normal)
    keys = distance.argmin(axis=1)
    members = np.arange(clusters)[None] == keys[:, None]
    # The medoid is nearest to the mean whatever the normals say.
    plain = distance - APART * (n @ normal.T <= COS_30)
    medoids = np.where(members, plain, np.inf).argmin(axis=0)
    return keys, [int(m) if used else -1 for m, used in zip(medoids, members.any(axis=0), strict=True)], seeded


def keys_of(kmeans: KMeans, count: int) -> NDArray:
    """Each point's cluster, −1 where it has none."""
    keys = np.full(count, -1)
    items, starts = kmeans.groups.items.numpy(), kmeans.groups.starts.numpy()
    for cluster in range(kmeans.most):
        keys[items[starts[cluster] : starts[cluster + 1]]] = cluster
    return keys


def test_it_is_algorithm_1() -> None:
    rng = np.random.default_rng(8)
    positions = rng.uniform(-0.5, 0.5, (400, 3))
    positions = positions[np.argsort(positions[:, 2])].astype(np.float32).astype(np.float64)
    normals = np.eye(3)[rng.integers(0, 3, 400)] * rng.choice([-1.0, 1.0], (400, 1))
    points = points_of(positions, normals, 0.3)
    weights = rng.uniform(0.1, 3.0, 400)
    points.weight = column(weights, float)
    kmeans = KMeans(400, 15, CPU, exhaustive=True)
    kmeans.run(points, 6, 4)
    keys, medoids, _ = algorithm_1(positions, normals, weights, 15, 6, 4)
    assert np.array_equal(keys_of(kmeans, 400), keys)
    assert kmeans.medoids.numpy().tolist() == medoids


def test_a_cluster_that_lost_its_members_starts_again_or_is_dropped() -> None:
    # Three quarters of the points coincide, so that most clusters are seeded on one another.
    positions, normals = plane(400, 6)
    positions[:300] = 0.0
    positions = positions.astype(np.float32).astype(np.float64)
    kmeans = KMeans(400, 12, CPU, exhaustive=True)
    kmeans.run(points_of(positions, normals, 0.3), 4, 2)
    keys, medoids, seeded = algorithm_1(positions, normals, np.ones(400), 12, 4, 2)
    assert seeded > 5
    assert np.array_equal(keys_of(kmeans, 400), keys)
    assert kmeans.medoids.numpy().tolist() == medoids
    dropped = np.array(medoids) < 0
    assert dropped.any()
    assert ((kmeans.grid.data.spacing.numpy() > 0.0) == ~dropped).all()


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
        assert np.allclose(kmeans.grid.data.position.numpy()[cluster], positions[medoids[cluster]])
        # One more round would move the mean a little: the medoid is near it, far nearer than a random member.
        offsets = np.linalg.norm(positions[members] - positions[members].mean(axis=0), axis=1)
        assert np.linalg.norm(positions[medoids[cluster]] - positions[members].mean(axis=0)) <= np.median(offsets)


def test_grid_and_exhaustive_search_agree() -> None:
    points = points_of(*plane(800, 3), 0.25)
    start = KMeans(800, 16, CPU)
    start.run(points, 1, 1)
    assignments = []
    for exhaustive in (True, False):
        kmeans = KMeans(800, 16, CPU, exhaustive=exhaustive)
        for name in ("position", "normal", "spacing"):
            wp.copy(getattr(kmeans.grid.data, name), getattr(start.grid.data, name))
        # Of the same means: a grid's are not searched again.
        kmeans.refine(points, 4 if exhaustive else 5, 1)
        assignments.append(keys_of(kmeans, 800))
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
