import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.transfer import disk_transfer, unoccluded
from gpu.vpl import Vpls, allocate_vpls
from gpu.vpl_clusters import VplClusters


@wp.kernel
def disk_kernel(first: int, way: wp.array[wp.vec3], area: float, out: wp.array[float]) -> None:
    """One thread a way to a disk that faces down, from a point that faces up."""
    index = first + wp.tid()
    out[index] = disk_transfer(way[index], wp.vec3(0.0, 0.0, 1.0), wp.vec3(0.0, 0.0, -1.0), area)


@wp.kernel
def unoccluded_kernel(first: int, vpls: VplClusters, out: wp.array[wp.vec3]) -> None:
    """One thread a cluster: its irradiance at the origin, which faces up."""
    cluster = first + wp.tid()
    out[cluster] = unoccluded(wp.vec3(0.0, 0.0, 0.0), wp.vec3(0.0, 0.0, 1.0), vpls, cluster)


@pytest.mark.parametrize("height", [0.01, 0.3, 5.0])
def test_on_its_axis_a_disk_transfers_its_form_factor(height: float) -> None:
    area = 0.25
    way = column([[0.0, 0.0, height]], wp.vec3)
    (transferred,) = results(disk_kernel, 1, [way, area], float)
    radius_squared = area / np.pi
    assert transferred * area == pytest.approx(radius_squared / (radius_squared + height**2), rel=1e-5)


def test_transfer_is_bounded_and_one_sided() -> None:
    rng = np.random.default_rng(1)
    ways = rng.normal(size=(1000, 3)) * np.exp(rng.uniform(-20, 2, (1000, 1)))
    transferred = results(disk_kernel, 1000, [column(ways, wp.vec3), 0.5], float)
    assert np.isfinite(transferred).all()
    assert (transferred <= 1.0 / 0.5 + 1e-5).all()
    assert (transferred[ways[:, 2] <= 0.0] == 0.0).all()


def cluster_above(height: float, area: float) -> VplClusters:
    """A cluster of four VPLs around (0, 0, height) that face down."""
    members: Vpls = allocate_vpls(4, wp.get_device("cpu"))
    members.position = column([[x, y, height] for x in (-0.1, 0.1) for y in (-0.1, 0.1)], wp.vec3)
    members.normal = column([[0.0, 0.0, -1.0]] * 4, wp.vec3)
    members.flux = column([[k, 2.0, 3.0] for k in range(1, 5)], wp.vec3)
    clusters = VplClusters()
    clusters.count, clusters.members = 1, members
    clusters.position, clusters.normal = column([[0.0, 0.0, height]], wp.vec3), column([[0.0, 0.0, -1.0]], wp.vec3)
    clusters.flux, clusters.area = column([[10.0, 8.0, 12.0]], wp.vec3), column([area], float)
    clusters.cone, clusters.starts = column([1.0], float), column([0, 4], wp.int32)
    return clusters


def test_far_away_a_cluster_counts_as_one_disk() -> None:
    light = results(unoccluded_kernel, 1, [cluster_above(4.0, 0.04)], wp.vec3).ravel()
    assert light == pytest.approx(np.array([10.0, 8.0, 12.0]) / (np.pi * 16.0 + 0.04), rel=1e-5)


def test_near_by_its_members_count_one_by_one() -> None:
    height, area = 0.1, 0.04
    light = results(unoccluded_kernel, 1, [cluster_above(height, area)], wp.vec3).ravel()
    squared = 0.02 + height**2
    each = height * height / (squared * (np.pi * squared + area / 4))
    assert light == pytest.approx(np.array([10.0, 8.0, 12.0]) * each, rel=1e-4)
