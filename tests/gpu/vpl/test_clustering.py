import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from scenes import square_of_vpls, strewn_vpls

from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import allocate_vpls
from gpu.vpl.build import VplClusterParameters, unclustered
from gpu.vpl.clustering import VplClustering
from gpu.vpl.group_lights import GroupLights


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


def test_clusters_are_those_of_four_iterations(device_scene: DeviceScene) -> None:
    vpls = strewn_vpls(20_000, 0.1, 7)

    def made(**changes: int) -> bytes:
        chosen = parameters(VplClusterParameters, **changes)
        return bytes(cluster_vpls(device_scene, vpls, 200, 0, chosen).disks.numpy().tobytes())

    usual = cluster_vpls(device_scene, vpls, 200, 0).disks.numpy().tobytes()
    assert usual == made(iterations=4)
    assert usual not in (made(iterations=3), made(iterations=6))


def test_more_clusters_than_vpls_and_none_at_all(device_scene: DeviceScene) -> None:
    assert cluster_vpls(device_scene, square_of_vpls(9), 100, 0).count == 9
    empty = cluster_vpls(device_scene, allocate_vpls(0, wp.get_device("cpu")), 100, 0)
    for none in (empty, unclustered(device_scene, empty)):
        assert (none.count, type(none.count)) == (0, int)  # of the struct's own kind it could not be told as JSON


def test_room_for_more_changes_no_bits(device_scene: DeviceScene) -> None:
    """VPLs beyond the first of them, and clusters beyond those that they are, are none."""
    vpls, device = strewn_vpls(900, 0.1, 5), wp.get_device("cpu")
    wide, count = strewn_vpls(1200, 0.1, 6), wp.array([900], dtype=int, device="cpu")
    for name in ("position", "normal", "flux", "bounce"):
        wp.copy(getattr(wide, name), getattr(vpls, name), count=900)
    lights = GroupLights(1200, 60, device)
    VplClustering(wide, count, 60, device).run(lights, 3)
    exact, roomy = cluster_vpls(device_scene, vpls, 60, 3), lights.vpls
    assert roomy.starts.numpy()[-1] == 900
    assert roomy.disks.numpy().tobytes() == exact.disks.numpy().tobytes()
    assert roomy.member_area.numpy()[:900].tobytes() == exact.member_area.numpy().tobytes()
    few = GroupLights(900, 1000, device)
    VplClustering(vpls, wp.array([900], dtype=int, device="cpu"), 1000, device).run(few, 3)
    assert few.vpls.disks.numpy()[:900].tobytes() == cluster_vpls(device_scene, vpls, 1000, 3).disks.numpy().tobytes()
    assert (few.vpls.disks.numpy()["flux"][900:] == 0.0).all()
