import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from scenes import column, results, square_of_vpls, strewn_vpls

from gpu.core.color import brightness
from gpu.device_scene.upload import DeviceScene
from gpu.vpl.build import unclustered
from gpu.vpl.form_factor import disk_transfer, unoccluded_irradiance
from gpu.vpl.vpl_clusters import (
    VplClusters,
    cluster_of,
    is_behind,
    out_of_reach,
)


@wp.kernel
def reach_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], clusters: VplClusters,
                 out: wp.array[int]) -> None:  # fmt: skip
    """One thread a point at a group of clusters: 1 where those are out of its reach."""
    index = first + wp.tid()
    point = index // clusters.groups
    out[index] = int(out_of_reach(position[point], normal[point], clusters, index % clusters.groups))


@wp.kernel
def behind_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], clusters: VplClusters,
                  out: wp.array[int]) -> None:  # fmt: skip
    """One thread a point at a cluster: 1 where that is behind the point's surface."""
    index = first + wp.tid()
    point = index // clusters.count
    out[index] = int(is_behind(position[point], normal[point], clusters, index % clusters.count))


@wp.kernel
def light_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], clusters: VplClusters,
                 out: wp.array[float]) -> None:  # fmt: skip
    """One thread a point at a member: its light there, were nothing in between."""
    index = first + wp.tid()
    count = clusters.members.count
    point = index // count
    member = index % count
    way = clusters.members.position[member] - position[point]
    out[index] = disk_transfer(way, normal[point], clusters.members.normal[member], 1.0)


@wp.kernel
def cluster_light_kernel(first: int, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], clusters: VplClusters,
                         out: wp.array[float]) -> None:  # fmt: skip
    """One thread a point at a cluster: its light there, were nothing in between."""
    index = first + wp.tid()
    point = index // clusters.count
    out[index] = brightness(unoccluded_irradiance(position[point], normal[point], clusters, index % clusters.count))


@wp.kernel
def cluster_kernel(first: int, clusters: VplClusters, out: wp.array[int]) -> None:
    """One thread a member: its cluster."""
    member = first + wp.tid()
    out[member] = cluster_of(clusters, member)


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_no_member_of_what_is_behind_a_surface_is_in_front_of_it(device_scene: DeviceScene, tilt: float) -> None:
    rng = np.random.default_rng(9)
    normals = rng.normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = rng.uniform(-0.6, 0.6, (400, 3))
    clusters = cluster_vpls(device_scene, strewn_vpls(1000, tilt, 7), 200, 0)
    inputs = [column(points, wp.vec3), column(normals, wp.vec3), clusters]
    behind = results(behind_kernel, 400 * clusters.count, inputs, wp.int32).reshape(400, -1).astype(bool)
    way = clusters.members.position.numpy()[None] - points[:, None]
    height = np.maximum.reduceat((way * normals[:, None]).sum(axis=2), clusters.starts.numpy()[:-1], axis=1)
    assert (height[behind] < 1e-5).all()
    assert behind.sum() > 0.85 * (height < 0.0).sum()


def test_clusters_of_a_points_own_plane_are_behind_it(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, square_of_vpls(900), 30, 0)
    points = clusters.members.position.numpy()[:50]
    inputs = [column(points, wp.vec3), column(np.tile([0.0, 1.0, 0.0], (50, 1)), wp.vec3), clusters]
    assert results(behind_kernel, 50 * clusters.count, inputs, wp.int32).all()


def test_every_member_is_found_in_its_cluster(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, strewn_vpls(900, 0.1, 6), 30, 0)
    expected = np.repeat(np.arange(clusters.count), np.diff(clusters.starts.numpy()))
    assert np.array_equal(results(cluster_kernel, 900, [clusters], wp.int32), expected)
    singles = unclustered(device_scene, clusters)
    assert np.array_equal(results(cluster_kernel, 900, [singles], wp.int32), np.arange(900))


@pytest.mark.parametrize("tilt", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("single", [False, True])
def test_nothing_that_lights_a_point_is_out_of_its_reach(device_scene: DeviceScene, tilt: float, single: bool) -> None:
    rng = np.random.default_rng(8)
    normals = rng.normal(size=(600, 3))
    # Some points lie among the VPLs, some far away.
    points = rng.uniform(-1.0, 1.0, (600, 3)) * rng.choice([0.5, 3.0], (600, 1))
    inputs = [column(points, wp.vec3), column(normals / np.linalg.norm(normals, axis=1, keepdims=True), wp.vec3)]
    clusters = cluster_vpls(device_scene, strewn_vpls(1000, tilt, 7), 300, 0)
    if single:
        clusters = unclustered(device_scene, clusters)
    groups, per_group = clusters.groups, clusters.per_group
    culled = results(reach_kernel, 600 * groups, [*inputs, clusters], wp.int32).reshape(600, groups).astype(bool)
    light = results(light_kernel, 600 * 1000, [*inputs, clusters], float).reshape(600, 1000)
    first = clusters.starts.numpy()[per_group * np.arange(groups)]
    lit = np.add.reduceat(light, first, axis=1) > 0.0
    assert not (culled & lit).any()
    # Neither is any light that clusters are given, but for what disks reach beyond their members.
    count = clusters.count
    given = results(cluster_light_kernel, 600 * count, [*inputs, clusters], float).reshape(600, count)
    given = np.add.reduceat(given, per_group * np.arange(groups), axis=1)
    assert (given * culled).sum() <= 1e-4 * given.sum()
    # Most of what could be left out is, where normals of neighbours are alike.
    assert culled.sum() > (0.05 if tilt == 1.0 else 0.5) * (~lit).sum()
