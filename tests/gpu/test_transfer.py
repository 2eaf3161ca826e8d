import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.device import allocate, launch
from gpu.transfer import UNFOLD_SHARE, disk_area, disk_irradiance, disk_transfer, unoccluded
from gpu.vpl import Vpls, allocate_vpls
from gpu.vpl_clusters import Disk, VplClusters, disk_at, disk_of, set_twigs


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


@wp.kernel
def disk_kernel_of(first: int, position: wp.vec3, normal: wp.vec3, area: float, cone: float,
                   out: wp.array[Disk]) -> None:  # fmt: skip
    """One thread: the disk of a cluster."""
    out[first + wp.tid()] = disk_of(position, normal, wp.vec3(10.0, 8.0, 12.0), area, cone)


@wp.kernel
def area_kernel(first: int, vpls: VplClusters, squared: wp.array[float], out: wp.array[float]) -> None:
    """One thread a squared distance: the area of the disks of cluster 0 there."""
    index = first + wp.tid()
    out[index] = disk_area(vpls, 0, squared[index])


@wp.kernel
def tilted_kernel(first: int, vpls: VplClusters, normals: wp.array[wp.vec3], out: wp.array[wp.vec3]) -> None:
    """One thread a normal: the irradiance from cluster 0 at the origin with that normal."""
    index = first + wp.tid()
    out[index] = disk_irradiance(wp.vec3(0.0, 0.0, 0.0), normals[index], disk_at(vpls.disks, 0))


def cluster_above(
    height: float, area: float, cone: float = 1.0, normal: tuple[float, float, float] = (0.0, 0.0, -1.0)
) -> VplClusters:
    """A cluster of four VPLs around (0, 0, height) that face down, of a cone of normals given by its cosine."""
    device = wp.get_device("cpu")
    members: Vpls = allocate_vpls(4, device)
    members.position = column([[x, y, height] for x in (-0.1, 0.1) for y in (-0.1, 0.1)], wp.vec3)
    members.normal = column([[0.0, 0.0, -1.0]] * 4, wp.vec3)
    members.flux = column([[k, 2.0, 3.0] for k in range(1, 5)], wp.vec3)
    clusters: VplClusters = allocate(VplClusters, 1, device)
    clusters.count, clusters.members = 1, members
    launch(disk_kernel_of, 1, [wp.vec3(0.0, 0.0, height), wp.vec3(*normal), area, cone, clusters.disks], device)
    clusters.cone, clusters.extent = column([cone], float), column([0.15], float)
    clusters.starts = column([0, 4], wp.int32)
    set_twigs(clusters, clusters.starts.numpy(), device)
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


def test_disks_near_by_are_those_of_the_members() -> None:
    area = 0.4
    limit = area / float(UNFOLD_SHARE)
    areas = results(area_kernel, 3, [cluster_above(1.0, area), column([1.01 * limit, 0.99 * limit, 0.0], float)], float)
    assert areas == pytest.approx([area, area / 4.0, area / 4.0])


def mean_of_disk(height: float, area: float, tilt: float, samples: int = 200_000) -> float:
    """Mean of max(cosθ, 0)·d over an even disk at a height, for a receiver that is tilted from facing it."""
    rng = np.random.default_rng(0)
    radius, angle = np.sqrt(rng.uniform(0.0, area / np.pi, samples)), rng.uniform(0.0, 2.0 * np.pi, samples)
    facing = height * np.cos(tilt) + radius * np.cos(angle) * np.sin(tilt)
    return float(np.maximum(facing, 0.0).mean())


@pytest.mark.parametrize("degrees", [0.0, 40.0, 75.0, 85.0, 90.0, 95.0, 120.0])
def test_a_disk_on_the_horizon_lights_with_what_is_above_it(degrees: float) -> None:
    height, area, tilt = 1.0, 0.3, np.radians(degrees)
    normal = column([[np.sin(tilt), 0.0, np.cos(tilt)]], wp.vec3)
    light = results(tilted_kernel, 1, [cluster_above(height, area), normal], wp.vec3).reshape(3)
    expected = mean_of_disk(height, area, tilt) * height / (height**2 * (np.pi * height**2 + area))
    # An even spread stands for the disk's.
    assert light == pytest.approx(np.array([10.0, 8.0, 12.0]) * expected, rel=0.02, abs=0.002)
    assert (light[0] > 0.0) == (degrees <= 95.0)


def test_members_whose_normals_stray_light_what_their_cluster_faces_away_from() -> None:
    up = column([[0.0, 0.0, 1.0]], wp.vec3)
    for turn, reaches in ((0.0, False), (0.3, False), (0.8, True)):
        # It leans away from the origin, by 100° from the way there.
        away = np.radians(100.0)
        cluster = cluster_above(1.0, 0.0, np.cos(turn), (np.sin(away), 0.0, -np.cos(away)))
        light = results(tilted_kernel, 1, [cluster, up], wp.vec3)
        assert (light.sum() > 0.0) == reaches
