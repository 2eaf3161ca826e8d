import numpy as np
import pytest
import warp as wp
from scenes import box, column, grey, resident_of, results, square_of_vpls

from gpu.core.color import brightness
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.vpl.build import NEAREST_SHARE, cluster_vpls, unclustered
from gpu.vpl.form_factor import disk_transfer, unoccluded_irradiance
from gpu.vpl.vpl_clusters import (
    MOST_GROUPS,
    PER_SUBCLUSTER,
    VplClusters,
    cluster_of,
    is_behind,
    most_groups,
    out_of_reach,
)


@pytest.fixture(scope="module")
def device_scene() -> DeviceScene:
    return resident_of(box(), [grey(0.5, 1.0)])


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


def strewn_vpls(count: int, tilt: float, seed: int) -> Vpls:
    """VPLs on patches here and there, of normals that stray by about `tilt` from those of their patch."""
    rng = np.random.default_rng(seed)
    patches, patch = 40, rng.integers(0, 40, count)
    centre, axis = rng.uniform(-0.5, 0.5, (patches, 3)), rng.normal(size=(patches, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    offset = rng.normal(0.0, 0.05, (count, 3))
    offset -= (offset * axis[patch]).sum(axis=1, keepdims=True) * axis[patch]
    normal = axis[patch] + rng.normal(0.0, tilt, (count, 3))
    vpls = allocate_vpls(count, wp.get_device("cpu"))
    vpls.position = column(centre[patch] + offset, wp.vec3)
    vpls.normal = column(normal / np.linalg.norm(normal, axis=1, keepdims=True), wp.vec3)
    vpls.flux = column(rng.uniform(0.1, 3.0, (count, 3)), wp.vec3)
    return vpls


def test_clusters_keep_all_flux_and_partition_the_vpls(device_scene: DeviceScene) -> None:
    vpls = square_of_vpls(4096)
    clusters = cluster_vpls(device_scene, vpls, 40, 0)
    starts = clusters.starts.numpy()
    assert clusters.count <= 40
    assert (np.diff(starts) > 0).all()
    assert starts[0] == 0
    assert starts[-1] == vpls.count
    assert clusters.disks.numpy()["flux"].sum(axis=0) == pytest.approx(vpls.flux.numpy().sum(axis=0), rel=1e-5)
    members = clusters.members.flux.numpy()
    assert sorted(map(tuple, members)) == sorted(map(tuple, vpls.flux.numpy()))
    for c in range(clusters.count):
        assert clusters.disks.numpy()["flux"][c] == pytest.approx(
            members[starts[c] : starts[c + 1]].sum(axis=0), rel=1e-5
        )
        assert clusters.disks.numpy()["position"][c] in clusters.members.position.numpy()[starts[c] : starts[c + 1]]


def test_disks_of_an_even_square_cover_its_area(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, square_of_vpls(10_000), 50, 0)
    assert clusters.disks.numpy()["area"].sum() == pytest.approx(0.36, rel=0.15)
    assert clusters.normal_cone_cos.numpy() == pytest.approx(1.0)


def test_vpls_alone_have_the_area_up_to_their_neighbours(device_scene: DeviceScene) -> None:
    """A disk of no area would light what is near without bound; what faces the other way is no neighbour."""
    up, down = square_of_vpls(400, seed=3), square_of_vpls(400, height=-1e-4, seed=4)
    vpls = allocate_vpls(800, wp.get_device("cpu"))
    for name, sign in (("position", 1.0), ("flux", 1.0), ("normal", -1.0)):
        one, other = getattr(up, name).numpy(), getattr(down, name).numpy()
        setattr(vpls, name, column(np.concatenate([one, sign * other]), wp.vec3))
    clusters = cluster_vpls(device_scene, vpls, 500, 0)
    disks, counts = clusters.disks.numpy(), np.diff(clusters.starts.numpy())
    position, normal, area = disks["position"], disks["normal"], disks["area"]
    way = np.linalg.norm(position[:, None] - position[None], axis=2)
    way[(normal @ normal.T <= 0.0) | np.eye(len(way), dtype=bool)] = np.inf
    reached = float(NEAREST_SHARE) * np.pi * way.min(axis=1) ** 2
    assert (counts == 1).sum() > 100
    assert area[counts == 1] == pytest.approx(reached[counts == 1], rel=1e-4)
    assert (area[counts < 4] >= 0.999 * reached[counts < 4]).all()
    assert area.sum() == pytest.approx(0.72, rel=0.5)


def test_a_cone_holds_the_normals_of_all_members(device_scene: DeviceScene) -> None:
    vpls = square_of_vpls(900)
    tilt = np.random.default_rng(3).uniform(-0.2, 0.2, (900, 3)) + np.array([0.0, 1.0, 0.0])
    vpls.normal = column(tilt / np.linalg.norm(tilt, axis=1, keepdims=True), wp.vec3)
    clusters = cluster_vpls(device_scene, vpls, 12, 0)
    starts, normals = clusters.starts.numpy(), clusters.members.normal.numpy()
    for c in range(clusters.count):
        cosines = normals[starts[c] : starts[c + 1]] @ clusters.disks.numpy()["normal"][c]
        assert clusters.normal_cone_cos.numpy()[c] == pytest.approx(min(cosines.min(), 1.0), abs=1e-6)
    assert clusters.normal_cone_cos.numpy().min() < 0.99


def test_unclustered_vpls_share_their_clusters_disk(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, square_of_vpls(900), 10, 0)
    singles = unclustered(device_scene, clusters)
    assert singles.count == 900
    assert singles.disks.numpy()["area"].sum() == pytest.approx(clusters.disks.numpy()["area"].sum(), rel=1e-4)
    assert singles.disks.numpy()["flux"].sum(axis=0) == pytest.approx(
        clusters.disks.numpy()["flux"].sum(axis=0), rel=1e-5
    )
    assert singles.starts.numpy().tolist() == list(range(901))


def test_more_clusters_than_vpls_and_none_at_all(device_scene: DeviceScene) -> None:
    assert cluster_vpls(device_scene, square_of_vpls(9), 100, 0).count == 9
    empty = cluster_vpls(device_scene, allocate_vpls(0, wp.get_device("cpu")), 100, 0)
    for none in (empty, unclustered(device_scene, empty)):
        assert (none.count, type(none.count)) == (0, int)  # of the struct's own kind it could not be told as JSON


def test_extents_reach_the_farthest_members(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, strewn_vpls(900, 0.1, 5), 30, 0)
    starts, members = clusters.starts.numpy(), clusters.members.position.numpy()
    for c in range(clusters.count):
        distances = np.linalg.norm(members[starts[c] : starts[c + 1]] - clusters.disks.numpy()["position"][c], axis=1)
        assert clusters.extent.numpy()[c] == pytest.approx(distances.max(), abs=1e-6)


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


def test_twigs_share_their_members_flux_and_their_clusters_area(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, strewn_vpls(900, 0.1, 4), 30, 0)
    starts, subcluster_starts = clusters.starts.numpy(), clusters.subcluster_starts.numpy()
    flux, position = clusters.members.flux.numpy(), clusters.members.position.numpy()
    subclusters, disks, number = clusters.subclusters.numpy(), clusters.disks.numpy(), int(PER_SUBCLUSTER)
    assert np.array_equal(np.diff(subcluster_starts), -(-np.diff(starts) // number))
    for c in range(clusters.count):
        own = subclusters[subcluster_starts[c] : subcluster_starts[c + 1]]
        assert own["area"].sum() == pytest.approx(disks["area"][c], rel=1e-4)
        for k, subcluster in enumerate(own):
            members = slice(starts[c] + number * k, min(starts[c] + number * (k + 1), starts[c + 1]))
            assert subcluster["flux"] == pytest.approx(flux[members].sum(axis=0), rel=1e-5)
            middle = np.average(position[members], axis=0, weights=flux[members].sum(axis=1))
            assert subcluster["position"] == pytest.approx(middle, abs=1e-5)


@pytest.mark.parametrize("count", [1, 9, 4096, 4097, 70_000])
def test_groups_stay_few(device_scene: DeviceScene, count: int) -> None:
    vpls = square_of_vpls(max(count, 9))
    singles = unclustered(device_scene, cluster_vpls(device_scene, vpls, 100, 0))
    assert singles.groups * singles.per_group >= singles.count > (singles.groups - 1) * singles.per_group
    assert singles.groups <= MOST_GROUPS
    assert most_groups(singles.count) >= singles.groups
    assert singles.per_group in (8, 16, 32, 64, 128, 256)


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
