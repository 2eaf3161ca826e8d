import numpy as np
import pytest
import warp as wp
from scenes import box, column, grey, resident_of

from gpu.resident import ResidentScene
from gpu.vpl import Vpls, allocate_vpls
from gpu.vpl_clusters import cluster_vpls, unclustered


@pytest.fixture(scope="module")
def resident() -> ResidentScene:
    return resident_of(box(), [grey(0.5, 1.0)])


def square_of_vpls(count: int) -> Vpls:
    """VPLs spread evenly over a square of area 0.36 that faces up."""
    side = int(count**0.5)
    grid = (np.arange(side) + 0.5) / side * 0.6 - 0.3
    x, z = np.meshgrid(grid, grid)
    vpls = allocate_vpls(side * side, wp.get_device("cpu"))
    vpls.position = column(np.stack([x.ravel(), np.zeros(side * side), z.ravel()], axis=1), wp.vec3)
    vpls.normal = column(np.tile([0.0, 1.0, 0.0], (side * side, 1)), wp.vec3)
    rng = np.random.default_rng(0)
    vpls.flux = column(rng.uniform(0.5, 1.5, (side * side, 3)), wp.vec3)
    return vpls


def test_clusters_keep_all_flux_and_partition_the_vpls(resident: ResidentScene) -> None:
    vpls = square_of_vpls(4096)
    clusters = cluster_vpls(resident, vpls, 40, 0)
    starts = clusters.starts.numpy()
    assert clusters.count <= 40
    assert (np.diff(starts) > 0).all()
    assert starts[0] == 0
    assert starts[-1] == vpls.count
    assert clusters.flux.numpy().sum(axis=0) == pytest.approx(vpls.flux.numpy().sum(axis=0), rel=1e-5)
    members = clusters.members.flux.numpy()
    assert sorted(map(tuple, members)) == sorted(map(tuple, vpls.flux.numpy()))
    for c in range(clusters.count):
        assert clusters.flux.numpy()[c] == pytest.approx(members[starts[c] : starts[c + 1]].sum(axis=0), rel=1e-5)
        assert clusters.position.numpy()[c] in clusters.members.position.numpy()[starts[c] : starts[c + 1]]


def test_disks_of_an_even_square_cover_its_area(resident: ResidentScene) -> None:
    clusters = cluster_vpls(resident, square_of_vpls(10_000), 50, 0)
    assert clusters.area.numpy().sum() == pytest.approx(0.36, rel=0.15)
    assert clusters.cone.numpy() == pytest.approx(1.0)


def test_a_cone_holds_the_normals_of_all_members(resident: ResidentScene) -> None:
    vpls = square_of_vpls(900)
    tilt = np.random.default_rng(3).uniform(-0.2, 0.2, (900, 3)) + np.array([0.0, 1.0, 0.0])
    vpls.normal = column(tilt / np.linalg.norm(tilt, axis=1, keepdims=True), wp.vec3)
    clusters = cluster_vpls(resident, vpls, 12, 0)
    starts, normals = clusters.starts.numpy(), clusters.members.normal.numpy()
    for c in range(clusters.count):
        cosines = normals[starts[c] : starts[c + 1]] @ clusters.normal.numpy()[c]
        assert clusters.cone.numpy()[c] == pytest.approx(min(cosines.min(), 1.0), abs=1e-6)
    assert clusters.cone.numpy().min() < 0.99


def test_unclustered_vpls_share_their_clusters_disk(resident: ResidentScene) -> None:
    clusters = cluster_vpls(resident, square_of_vpls(900), 10, 0)
    singles = unclustered(resident, clusters)
    assert singles.count == 900
    assert singles.area.numpy().sum() == pytest.approx(clusters.area.numpy().sum(), rel=1e-4)
    assert singles.flux.numpy().sum(axis=0) == pytest.approx(clusters.flux.numpy().sum(axis=0), rel=1e-5)
    assert singles.starts.numpy().tolist() == list(range(901))


def test_more_clusters_than_vpls_and_none_at_all(resident: ResidentScene) -> None:
    assert cluster_vpls(resident, square_of_vpls(9), 100, 0).count == 9
    empty = cluster_vpls(resident, allocate_vpls(0, wp.get_device("cpu")), 100, 0)
    for none in (empty, unclustered(resident, empty)):
        assert (none.count, type(none.count)) == (0, int)  # of the struct's own kind it could not be told as JSON
