import numpy as np
import pytest
from frame_view import FrameView
from scenes import box, grey, quad, resident_of, slats

from gpu.device_scene.upload import DeviceScene
from gpu.scene.camera import look_at, rotated
from gpu.scene.types import Camera
from gpu.sp.sp_clustering import SpClustering
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT


def clustered(count: int, fuzziness: int, by_distance: bool = True) -> tuple[SpClustering, FrameView]:
    """The slats' SPs in clusters."""
    device_scene, camera, size = slats()
    return clustering_of(device_scene, camera, size, count, fuzziness, by_distance)


def clustering_of(
    device_scene: DeviceScene, camera: Camera, size: tuple[int, int], count: int, fuzziness: int, by_distance: bool
) -> tuple[SpClustering, FrameView]:
    view = FrameView(device_scene, size, lambertian=True)
    view.set_camera(camera)
    view.find_shading_points()
    clustering = SpClustering(view.shading_points, count, fuzziness, by_distance=by_distance)
    clustering.run(view.gbuffer, 0)
    return clustering, view


@pytest.mark.parametrize(("count", "fuzziness"), [(1, 1), (1, 6), (60, 1), (60, 6), (400, 8), (100_000, 6)])
def test_every_sp_has_used_clusters_whose_weights_add_up_to_one(count: int, fuzziness: int) -> None:
    clustering, view = clustered(count, fuzziness)
    sps = view.shading_points.count.numpy()[0]
    cluster, weight = clustering.clusters.cluster.numpy()[:, :sps], clustering.clusters.weight.numpy()[:, :sps]
    assert ((cluster >= 0) & (cluster < clustering.count)).all()
    assert weight.sum(axis=0) == pytest.approx(1.0, abs=1e-5)
    assert (weight >= 0.0).all()
    used = clustering.clusters.used.numpy()
    assert used[cluster[weight > 0.0]].all()
    assert (clustering.deficit.numpy()[:sps] < int(UNASSIGNED_DEFICIT)).all()


def test_weights_fall_with_distance_or_are_equal() -> None:
    clustering, view = clustered(200, 4)
    sps = view.shading_points.count.numpy()[0]
    weight = clustering.clusters.weight.numpy()[:, :sps]
    assert (np.diff(weight, axis=0) <= 1e-6).all()  # the nearest cluster comes first
    equal = clustered(200, 4, by_distance=False)[0].clusters.weight.numpy()[:, :sps]
    full = (equal > 0.0).all(axis=0)
    assert full.mean() > 0.9
    assert equal[:, full] == pytest.approx(0.25)


@pytest.mark.parametrize("by_distance", [False, True])
@pytest.mark.parametrize("fuzziness", [1, 4, 6])
def test_on_a_plane_it_is_algorithm_2(fuzziness: int, by_distance: bool) -> None:
    plane = resident_of([quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))], [grey(0.5)])
    above = Camera("plan", look_at((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)).to_world, 0.5, orthographic=True)
    clustering, view = clustering_of(plane, above, (40, 40), 80, fuzziness, by_distance)
    sps, clusters = view.shading_points.pixels.numpy(), clustering.clusters
    own = np.flatnonzero(clusters.used.numpy()[:60])  # a quarter is kept back for SPs that these serve badly
    positions = view.gbuffer.position.numpy()[sps].astype(np.float64)
    distances = np.linalg.norm(positions[:, None] - clusters.position.numpy()[own][None], axis=2)
    order = np.argsort(distances, axis=1)[:, :fuzziness]
    nearest = np.take_along_axis(distances, order, axis=1)
    spacing = 1.0 / 60**0.5
    # The 27 cells about an SP hold all that is nearer than a cell, which is a quarter here.
    sure = (nearest[:, -1] < 0.25) & (nearest[:, 0] < spacing)
    assert sure.mean() > 0.9
    weights = 1.0 / np.maximum(nearest, 1e-3 * spacing) if by_distance else np.ones_like(nearest)
    weights /= weights.sum(axis=1, keepdims=True)
    assert np.allclose(clusters.weight.numpy().T[sure], weights[sure], rtol=1e-3)
    taken = np.linalg.norm(positions[:, None] - clusters.position.numpy()[clusters.cluster.numpy().T], axis=2)
    assert np.allclose(taken[sure], nearest[sure], atol=1e-6)


def test_surfaces_that_meet_at_a_corner_share_no_clusters() -> None:
    room = resident_of(box(), [grey(0.5)])
    clustering, view = clustering_of(room, look_at((0.4, 0.4, 0.4), (-0.5, -0.5, -0.5), yfov_degrees=80.0), (40, 30),
                                     200, 6, by_distance=True)  # fmt: skip
    normal = view.gbuffer.normal.numpy()[view.shading_points.pixels.numpy()]
    members = clustering.clusters.geometric_normal.numpy()[clustering.clusters.cluster.numpy()]
    counts = (clustering.clusters.weight.numpy() > 0.0) & (clustering.deficit.numpy() == 0)
    assert counts.mean() > 0.5
    assert (normal[None] * members).sum(axis=2)[counts] == pytest.approx(1.0, abs=1e-5)


def test_a_single_sp_is_a_cluster_of_its_own() -> None:
    speck = resident_of([quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))], [grey(0.5)])
    far = look_at((0.0, 0.0, 21.0), (0.3, 0.3, 0.0), yfov_degrees=45.0)
    clustering, view = clustering_of(speck, far, (9, 9), 30, 6, by_distance=True)
    assert view.shading_points.count.numpy()[0] == 1
    pixel = view.shading_points.pixels.numpy()[0]
    cluster, weight = clustering.clusters.cluster.numpy()[:, 0], clustering.clusters.weight.numpy()[:, 0]
    assert weight.tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert np.array_equal(clustering.clusters.position.numpy()[cluster[0]], view.gbuffer.position.numpy()[pixel])
    assert clustering.clusters.used.numpy().sum() == 1


def test_order_lists_every_cluster_in_use_once() -> None:
    clusters = clustered(100, 6)[0].clusters
    used = np.flatnonzero(clusters.used.numpy())
    assert sorted(clusters.order.numpy()[: clusters.fresh.numpy()[0]]) == used.tolist()


def test_representatives_are_shading_points_of_their_own() -> None:
    clustering, view = clustered(100, 6)
    used = clustering.clusters.used.numpy().astype(bool)
    positions = {tuple(p) for p in view.gbuffer.position.numpy()}
    assert all(tuple(p) in positions for p in clustering.clusters.position.numpy()[used])


def test_k_means_looks_at_four_sps_a_cluster() -> None:
    clustering, view = clustered(80, 6)
    assert view.shading_points.count.numpy()[0] > 1000
    assert clustering._samples.points.count.numpy()[0] == 4 * 60
    clustering.use(40)
    clustering.run(view.gbuffer, 0)
    assert clustering._samples.points.count.numpy()[0] == 4 * 30


def test_badly_served_sps_get_clusters_of_their_own() -> None:
    clustering, _ = clustered(120, 6)
    extra = clustering.clusters.used.numpy()[-int(120 * 0.25) :]
    assert extra.sum() > 10


def test_the_same_seed_gives_the_same_bits() -> None:
    first, second = (clustered(150, 6)[0].clusters for _ in range(2))
    assert first.cluster.numpy().tobytes() == second.cluster.numpy().tobytes()
    assert first.weight.numpy().tobytes() == second.weight.numpy().tobytes()
    assert first.order.numpy().tobytes() == second.order.numpy().tobytes()


def test_a_view_of_nothing_has_no_clusters() -> None:
    device_scene, camera, size = slats()
    away = camera.to_world.copy()
    away[:3, 3] = (0.0, 0.0, 50.0)
    away[:3, 2] *= -1.0
    away[:3, 0] *= -1.0
    outside = Camera("away", away, camera.half_height)
    clustering, view = clustering_of(device_scene, outside, size, 50, 6, by_distance=True)
    assert view.shading_points.count.numpy()[0] == 0
    assert not clustering.clusters.used.numpy().any()


@pytest.mark.parametrize("count", [1, 30, 90])
def test_room_for_more_clusters_changes_none(count: int) -> None:
    (alone, _), (roomy, view) = clustered(count, 6), clustered(90, 6)
    roomy.use(count)
    roomy.run(view.gbuffer, 0)
    assert roomy.count == count
    assert roomy.clusters.used.numpy().sum() == alone.clusters.used.numpy().sum() > 0
    for name in ("position", "normal", "geometric_normal", "spacing", "used"):
        assert (
            getattr(roomy.clusters, name).numpy()[:count].tobytes() == getattr(alone.clusters, name).numpy().tobytes()
        )
    for name in ("cluster", "weight"):
        assert getattr(roomy.clusters, name).numpy().tobytes() == getattr(alone.clusters, name).numpy().tobytes()


def test_each_viewer_has_the_clusters_it_gets_alone() -> None:
    """Their frames come in turn, of different views and counts."""
    device_scene, camera, size = slats()

    def walk(viewers: int) -> list[tuple[bytes, ...]]:
        view = FrameView(device_scene, size, lambertian=True)
        first = SpClustering(view.shading_points, 90, 6, by_distance=True)
        others = [first.for_another_viewer() for _ in range(viewers - 1)]
        seen = []
        for number in range(3):
            for other, clustering in enumerate([first, *others]):
                clustering.use(90 - 30 * other)
                view.set_camera(rotated(camera, 3.0 * number - 20.0 * other))
                view.find_shading_points()
                if number:
                    clustering.go_on(view.gbuffer, view.camera, size)
                else:
                    clustering.run(view.gbuffer, 0)
                if other == 0:
                    clusters = clustering.clusters
                    arrays = clusters.cluster, clusters.weight, clusters.used, clustering.deficit
                    seen.append(tuple(array.numpy().tobytes() for array in arrays))
        return seen

    assert walk(1) == walk(2) == walk(3)


def test_clusters_that_are_kept_are_listed_as_new_where_light_is() -> None:
    device_scene, camera, size = slats()
    view = FrameView(device_scene, size, lambertian=True)
    clustering = SpClustering(view.shading_points, 90, 6, by_distance=True)
    view.set_camera(camera)
    view.find_shading_points()
    clustering.run(view.gbuffer, 0)
    fresh = []
    for relit in (False, True):
        clustering.go_on(view.gbuffer, view.camera, size, relit=relit)
        fresh.append(int(clustering.clusters.fresh.numpy()[0]))
    used = np.flatnonzero(clustering.clusters.used.numpy())
    assert fresh[0] < 0.5 * len(used)
    assert sorted(clustering.clusters.order.numpy()[: fresh[1]]) == used.tolist()
