import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from scenes import column, square_of_vpls, strewn_vpls

from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import allocate_vpls
from gpu.vpl.build import unclustered
from gpu.vpl.vpl_clusters import (
    MOST_GROUPS,
    PER_SUBCLUSTER,
    most_groups,
)


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
    reached = 0.45 * np.pi * way.min(axis=1) ** 2
    assert (counts == 1).sum() > 100
    assert area[counts == 1] == pytest.approx(reached[counts == 1], rel=1e-4)
    few = (counts > 0) & (counts < 4)
    assert (area[few] >= 0.999 * reached[few]).all()
    assert area.sum() == pytest.approx(0.72, rel=0.5)


def test_four_members_tell_the_area_that_they_stand_for(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, square_of_vpls(900, seed=3), 180, 0)
    starts, position = clusters.starts.numpy(), clusters.members.position.numpy().astype(np.float64)
    area = clusters.disks.numpy()["area"]
    told = np.diff(starts) >= 4
    for c in np.flatnonzero(told):
        members = slice(starts[c], starts[c + 1])
        variance = position[members].var(axis=0).sum()
        assert area[c] == pytest.approx(2.0 * np.pi * variance, rel=1e-3)
    assert (np.diff(starts)[told] < 8).sum() > 20


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


def test_each_vpl_has_its_fluxs_share_of_the_disk(device_scene: DeviceScene) -> None:
    """Of few VPLs among many that carry most of the flux, each stands for more of the surface."""
    vpls = square_of_vpls(900)
    flux = vpls.flux.numpy()
    flux[::90] *= 40.0
    vpls.flux = column(flux, wp.vec3)
    clusters = cluster_vpls(device_scene, vpls, 10, 0)
    starts, area = clusters.starts.numpy(), clusters.disks.numpy()["area"]
    members = clusters.members.flux.numpy().sum(axis=1)
    for c in range(clusters.count):
        own = slice(starts[c], starts[c + 1])
        expected = area[c] * members[own] / members[own].sum()
        assert clusters.member_area.numpy()[own] == pytest.approx(expected, rel=1e-4)


def test_extents_reach_the_farthest_members(device_scene: DeviceScene) -> None:
    clusters = cluster_vpls(device_scene, strewn_vpls(900, 0.1, 5), 30, 0)
    starts, members = clusters.starts.numpy(), clusters.members.position.numpy()
    for c in range(clusters.count):
        distances = np.linalg.norm(members[starts[c] : starts[c + 1]] - clusters.disks.numpy()["position"][c], axis=1)
        assert clusters.extent.numpy()[c] == pytest.approx(distances.max(), abs=1e-6)


def test_subclusters_share_their_members_flux_and_their_clusters_area(device_scene: DeviceScene) -> None:
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
