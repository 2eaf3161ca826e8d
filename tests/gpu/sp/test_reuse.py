"""Clusters that are kept while the camera walks, and their bits."""

import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of, results
from walking import Walk, budget_of, furnished, pose
from walls import CPU, WIDTH, wall

from gpu.clustering.grid import CLUSTERING_PARAMETERS, ClusteringParameters, Grid
from gpu.core.device import allocate, duplicate, launch
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.visibility import Visibility
from gpu.scene.camera import look_at, rotated
from gpu.scene.types import Camera
from gpu.sp.budget import SP_CLUSTER_PARAMETERS, WHOLE_DEFICIT, SpClusterParameters
from gpu.sp.reuse import CORNERS, drop_surplus_kernel, is_visible_at, mark_close_pairs_kernel
from gpu.sp.sp_clusters import ClusterWork, SpClusters

CHOSEN = SP_CLUSTER_PARAMETERS
EYE = (0.0, 0.0, 0.45)


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return furnished()


def test_a_walk_keeps_most_clusters_and_their_bits_are_those_of_a_full_trace(room: DeviceScene) -> None:
    walk = Walk(room)
    walk.step(pose(0), begins=True)
    assert len(walk.fresh) == walk.used.sum()
    begun = walk.used
    for number in range(1, 8):
        walk.step(pose(number))
        walk.assert_served()
        assert 0 < len(walk.fresh) < 0.3 * walk.used.sum()
    assert (walk.kept & begun).sum() > 100
    all_emitters = duplicate(SpClusters, walk.clusters)
    used = np.flatnonzero(walk.used)
    all_emitters.order = wp.array(np.append(used, np.flatnonzero(~walk.used)), dtype=int, device="cpu")
    all_emitters.fresh = wp.array([len(used)], dtype=int, device="cpu")
    whole = Visibility(walk.count, walk.lights.count, walk.view.device)
    whole.trace(walk.view.scene, all_emitters, walk.lights)
    assert np.array_equal(whole.words.numpy()[used], walk.visibility.words.numpy()[used])
    assert 0 < walk.visibility.rays.numpy().sum() < 0.3 * whole.rays.numpy().sum()


def test_new_clusters_are_in_the_order_each_once(room: DeviceScene) -> None:
    walk = Walk(room)
    walk.step(pose(0), begins=True)
    before = walk.clusters.position.numpy().copy()
    walk.step(pose(4))
    assert len(set(walk.fresh)) == len(walk.fresh)
    moved = (walk.clusters.position.numpy() != before).any(axis=1)
    assert set(np.flatnonzero(moved)) <= set(walk.fresh)
    assert moved.sum() > 0.8 * len(walk.fresh) > 0
    pixels = {tuple(p) for p in walk.view.gbuffer.position.numpy()}
    assert all(tuple(p) in pixels for p in walk.clusters.position.numpy()[walk.fresh])


def test_a_view_that_rests_comes_to_rest_and_traces_no_ray(room: DeviceScene) -> None:
    walk = Walk(room)
    walk.step(pose(0), begins=True)
    for _ in range(45):
        walk.step(pose(0))
    accepted_distance = walk.accepted_distance
    words, position = walk.visibility.words.numpy().copy(), walk.clusters.position.numpy().copy()
    kept = walk.used
    walk.step(pose(0))
    assert len(walk.fresh) == 0
    assert np.array_equal(walk.kept, kept)
    assert walk.accepted_distance == accepted_distance
    assert CHOSEN.min_free * walk.count <= walk.count - kept.sum() <= CHOSEN.max_free * walk.count
    assert walk.visibility.rays.numpy().sum() == walk.visibility.shared.numpy().sum() == 0
    assert np.array_equal(walk.visibility.words.numpy(), words)
    assert np.array_equal(walk.clusters.position.numpy(), position)


@pytest.mark.parametrize("target", [(0.0, 0.0, 1.0), (0.5, 0.5, 0.3), (0.0, -0.5, 0.45001)])
def test_a_view_of_something_else_is_served_by_new_clusters(
    room: DeviceScene, target: tuple[float, float, float]
) -> None:
    walk = Walk(room)
    walk.step(pose(0), begins=True)
    walk.step(look_at(EYE, target, yfov_degrees=60.0))
    walk.assert_served()
    assert len(walk.fresh) > 0.5 * walk.count
    # Each new one stands for about as many pixels as k-means gives each of its own.
    assert np.bincount(walk.clusters.cluster.numpy()[0]).max() < 8 * walk.view.pixels / walk.count


def test_an_empty_view_keeps_nothing_and_the_next_begins_anew() -> None:
    plane = resident_of([quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))], [grey(0.5, 1.0)])
    walk = Walk(plane)
    there = look_at((0.0, 0.0, 0.5), (0.0, 0.0, 0.0))
    walk.step(there, begins=True)
    walk.step(look_at((0.0, 0.0, 0.5), (0.0, 0.0, 1.0)))
    assert not walk.used.any()
    walk.step(there)
    walk.assert_served()
    assert len(walk.fresh) == walk.used.sum() > 100


def test_what_is_hidden_now_is_dropped() -> None:
    wall = quad((-0.5, -0.5, -0.3), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    screen = quad((0.0, -0.5, 0.0), (0.2, 0.0, 0.0), (0.0, 1.0, 0.0))
    walk = Walk(resident_of([wall, screen], [grey(0.5)]))
    unit = walk.device_scene.scene.placement

    def behind(eye: Camera) -> np.ndarray:
        """Clusters of the wall that the screen's middle hides from there."""
        points = walk.clusters.position.numpy() / unit.scale + unit.centre
        origin = eye.to_world[:3, 3]
        at = origin + (points - origin) * ((0.0 - origin[2]) / (points[:, 2] - origin[2]))[:, None]
        return np.asarray((points[:, 2] < -0.1) & (np.abs(at[:, 0] - 0.1) < 0.07) & walk.used)

    here, there = (look_at((x, 0.0, 1.0), (0.0, 0.0, -0.3), yfov_degrees=50.0) for x in (-0.6, -0.3))
    walk.step(here, begins=True)
    assert not behind(here).any()
    assert behind(there).sum() > 5
    walk.step(there)
    assert not behind(there).any()
    assert walk.kept.sum() > 0.5 * walk.used.sum()


def test_clusters_of_folds_as_narrow_as_a_pixel_are_kept() -> None:
    """The pixel of most shows the other side of a fold in the next frame."""
    width = 0.01
    folds = []
    for number in range(100):
        depth = width if number % 2 else 0.0
        folds.append(quad((-0.5 + width * number, -0.5, depth), (width, 0.0, width - 2.0 * depth), (0.0, 1.0, 0.0)))
    walk = Walk(resident_of(folds, [grey(0.5, 1.0)]))
    walk.step(look_at((0.0, 0.0, 0.6), (0.0, 0.0, 0.0), yfov_degrees=45.0), begins=True)
    walk.step(look_at((0.003, 0.0, 0.6), (0.003, 0.0, 0.0), yfov_degrees=45.0))
    assert walk.kept.sum() > 0.9 * walk.used.sum()


def test_a_walk_keeps_few_clusters_free_for_what_comes_into_view(room: DeviceScene) -> None:
    """With one distance for all scenes, either flat surfaces take all or many are in no use."""
    walk = Walk(room)
    distances, used = [], []
    for number in range(60):
        walk.step(pose(abs(number % 40 - 20)), begins=number == 0)
        distances.append(walk.accepted_distance)
        used.append(walk.used.mean())
    assert distances[0] == pytest.approx(CHOSEN.accepted_distance)
    assert CHOSEN.min_accepted < min(distances) < max(distances) < CHOSEN.max_accepted
    assert 0.94 < np.mean(used[-15:]) < 0.99
    deficit = walk.clustering.deficit.numpy()[: walk.view.pixels]
    assert (deficit < WHOLE_DEFICIT).mean() > 0.99


def test_a_side_that_comes_into_view_has_clusters_of_its_own() -> None:
    """A camera turns from an open box and back: where kept clusters take up all, a block gets light of other sides."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = [quad((0.05, -0.5, 0.1), (0.3, 0.0, 0.1), (0.0, 0.6, 0.0), 2),
             quad((0.05, -0.5, -0.2), (0.0, 0.0, 0.3), (0.0, 0.6, 0.0), 2),
             quad((0.35, -0.5, 0.2), (-0.1, 0.0, -0.3), (0.0, 0.6, 0.0), 2)]  # fmt: skip
    walls = [quad((-0.5, -0.5, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), 2),
             quad((-0.5, 0.5, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 2),
             quad((-0.5, -0.5, -0.5), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 2),
             quad((-0.5, -0.5, 0.5), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0), 2)]  # fmt: skip
    walk = Walk(resident_of([lamp, *block, *walls], [grey(0.7), grey(0.0, 5.0), grey(0.4)]), size=(128, 128), count=120)
    unlike, seen = 0, 0
    for number in range(72):
        angle = 2.0 * np.pi * number / 96.0
        eye = (0.0, 0.0, 1.9 - 0.175 * (1.0 - np.cos(angle)))
        walk.step(rotated(look_at(eye, (0.0, 0.0, 0.0), yfov_degrees=40.0), 20.0 * np.sin(angle)), begins=number == 0)
        count = int(walk.view.shading_points.count.numpy()[0])
        normals = walk.view.gbuffer.normal.numpy()[walk.view.shading_points.pixels.numpy()[:count]]
        nearest = walk.clusters.normal.numpy()[walk.clusters.cluster.numpy()[0, :count]]
        unlike += int(((normals * nearest).sum(axis=1) < 0.5).sum())
        seen += count
    assert unlike < 6e-4 * seen


def test_a_walk_that_begins_anew_forgets_the_distance_of_the_last(room: DeviceScene) -> None:
    walk = Walk(room)
    places = []
    for _ in range(2):
        for number in range(4):
            walk.step(pose(number), begins=number == 0)
        assert walk.accepted_distance != pytest.approx(CHOSEN.accepted_distance)
        places.append(walk.clusters.position.numpy()[walk.used])
    assert np.array_equal(*places)


def test_a_surface_that_moves_away_loses_clusters_until_none_crowd() -> None:
    plane = resident_of([quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))], [grey(0.5, 1.0)])
    walk = Walk(plane)

    def plan(half: float) -> Camera:
        return Camera("plan", look_at((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)).to_world, half, orthographic=True)

    walk.step(plan(0.1), begins=True)
    for number in range(1, 13):
        walk.step(plan(0.1 * 1.1**number))
        walk.assert_served()
    points = walk.clusters.position.numpy()[walk.used].astype(np.float64)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    np.fill_diagonal(distances, 1.0)
    crowded = distances.min(axis=1) < 0.9 * CHOSEN.crowded * walk.accepted_distance * walk.spacing()[walk.used]
    assert crowded.mean() < 0.05
    # Kept ones are no more than there were, on a third of each side: without thinning they would be packed there.
    inner = (np.abs(points[:, :2]) < 0.1).all(axis=1)
    assert inner.sum() < 0.35 * walk.count
    deficit = walk.clustering.deficit.numpy()[: walk.view.pixels]
    assert (deficit < WHOLE_DEFICIT).mean() > 0.95


@pytest.mark.parametrize(("share", "goes"), [(0.91, 1), (0.95, 0)])
def test_of_two_nearer_than_where_new_ones_come_one_goes(share: float, goes: int) -> None:
    """share: of the distance from all others at which an SP gets a cluster of its own."""
    grid, work = Grid(2, CPU), allocate(ClusterWork, 2, CPU)
    grid.data.position.assign(np.float32([[0.0, 0.0, 0.0], [share * 0.75 * 0.1, 0.0, 0.0]]))
    grid.data.normal.assign(np.float32([[0.0, 1.0, 0.0]] * 2))
    grid.data.spacing.fill_(0.1)
    grid.build()
    work.spacing.fill_(0.1)
    inputs = [budget_of(2, 0.75), CHOSEN.crowded, grid.data, work]
    launch(mark_close_pairs_kernel, 2 * CORNERS, inputs, CPU)
    assert work.crowded.numpy().sum() == goes


@wp.kernel
def visible_kernel(first: int, gbuffer: GBuffer, pixel: int, positions: wp.array[wp.vec3], normal: wp.vec3,
                   chosen: SpClusterParameters, alike: ClusteringParameters, out: wp.array[int]) -> None:  # fmt: skip
    """One thread a place: whether the pixel shows it, with clusters ten spacings of pixels apart."""
    index = first + wp.tid()
    out[index] = int(is_visible_at(gbuffer, pixel, positions[index], normal, 10.0, chosen.same_place, alike))


@pytest.mark.parametrize(("turned", "shown"), [(False, [1, 1, 1, 0]), (True, [1, 1, 0, 0])])
def test_a_place_is_shown_by_its_surface_and_whatever_its_normal_by_its_own_pixel(
    turned: bool, shown: list[int]
) -> None:
    gbuffer, pixel = wall(), 20 * WIDTH + 20
    places = gbuffer.position.numpy()[pixel] + np.array([[0.0], [1.4], [1.6], [10.5]]) * [1.0, 0.0, 0.0]
    normal = wp.vec3(1.0, 0.0, 0.0) if turned else wp.vec3(0.0, 0.0, 1.0)
    inputs = [gbuffer, pixel, column(places, wp.vec3), normal, CHOSEN, CLUSTERING_PARAMETERS]
    assert results(visible_kernel, 4, inputs, wp.int32).tolist() == shown


@pytest.mark.parametrize("most", [False, True])
@pytest.mark.parametrize("wanted", [100, 72, 70, 69, 35, 1])
def test_where_too_many_are_in_use_evenly_many_of_all_stay_and_leave_room(wanted: int, most: bool) -> None:
    """most: the accepted distance can grow no more."""
    spacing = np.where(np.arange(100) % 10 < 7, 1.0, 0.0)
    left = column(spacing, float)
    budget = budget_of(wanted, CHOSEN.max_accepted if most else CHOSEN.accepted_distance)
    inputs = [0, budget, CHOSEN, column(np.cumsum(spacing == 0.0), wp.int32), left]
    wp.launch(drop_surplus_kernel, 100, inputs, device="cpu")
    stay = left.numpy() > 0.0
    stays = {100: 70, 72: 68 if most else 70, 70: 66 if most else 70, 69: 65, 35: 33, 1: 1}
    assert stay.sum() == stays[wanted]
    assert not stay[spacing == 0.0].any()
    assert np.ptp(stay.reshape(10, 10).sum(axis=1)) <= 1


@pytest.mark.parametrize("count", [200, 120])
def test_what_comes_into_view_as_clusters_fall_has_its_own(room: DeviceScene, count: int) -> None:
    """A camera turns to the right. Without room in that frame, what it turns to has the light of other surfaces."""
    walk = Walk(room, size=(96, 72))
    for number in range(12):
        walk.step(rotated(pose(0.0), -0.05 * number), begins=number == 0)
    walk.clustering.use(count)
    walk.step(rotated(pose(0.0), -9.0))
    assert walk.used.sum() <= count
    assert 0 < len(walk.fresh) <= 1 + int(CHOSEN.max_new * count)
    assert np.flatnonzero(walk.used).max() < walk.clustering._kept.budget.extent.numpy()[0]
    sps = walk.view.shading_points.pixels.numpy()[: int(walk.view.shading_points.count.numpy()[0])]
    nearest = walk.clusters.cluster.numpy()[0, : len(sps)]
    ways = walk.view.gbuffer.position.numpy()[sps] - walk.clusters.position.numpy()[nearest]
    new = sps % walk.size[0] > 84
    assert np.percentile((np.linalg.norm(ways, axis=1) / walk.spacing()[nearest])[new], 90) < 1.1


@pytest.mark.parametrize("at_once", [False, True])
def test_more_clusters_come_in_turn_or_at_once(room: DeviceScene, at_once: bool) -> None:
    walk = Walk(room, most=900)
    walk.step(pose(0.0), begins=True)
    walk.clustering.use(900, at_once=at_once)
    walk.step(pose(0.0))
    walk.assert_served()
    in_turn = 1 + int(CHOSEN.max_new * 900)
    assert len(walk.fresh) > 4 * in_turn if at_once else len(walk.fresh) <= in_turn


@pytest.mark.parametrize("count", [450, 150])
def test_a_walk_goes_on_with_more_or_fewer_clusters(room: DeviceScene, count: int) -> None:
    walk = Walk(room, most=600)
    walk.step(pose(0.0), begins=True)
    walk.step(pose(0.0))
    before, known = walk.used.sum(), {row.tobytes() for row in walk.clusters.position.numpy()[walk.used]}
    walk.clustering.use(count)
    numbers, new = [], []
    for step in range(14):
        walk.step(pose(0.1 * step))
        walk.assert_served()
        numbers.append(walk.used.sum())
        new.append(len(walk.fresh))
        if step == 0:
            kept = {row.tobytes() for row in walk.clusters.position.numpy()[walk.kept]}
            assert kept <= known
            assert len(kept) > 0.8 * before * min(1.0, count / 300)
            words = walk.visibility.words.numpy().copy()
            walk.clusters.order.assign(np.arange(walk.most))
            walk.clusters.fresh.fill_(walk.most)
            walk.visibility.trace(walk.view.scene, walk.clusters, walk.lights)
            assert np.array_equal(walk.visibility.words.numpy()[walk.used], words[walk.used])
    assert max(new[:3]) <= 1 + int(CHOSEN.max_new * count)
    assert max(numbers) <= count
    assert numbers[-1] > 0.8 * count
    assert (new[0] < numbers[-1] - before) == (count > before)
