from itertools import combinations

import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline, relative_error
from scenes import box, column, grey, quad, resident_of, slats

from gpu.correction.outliers import OutlierPoints
from gpu.correction.visibility_correction import PASS_SEED, RUN, Correction, correction_kernel
from gpu.gbuffer.point_list import PointList
from gpu.indirect.irradiance import CHECKS
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles

SEEDS = 100
SIZE = (16, 12)


def point_lights(fuzziness: int = 6, *, far_field_sums: bool = False) -> Pipeline:
    """Every VPL a cluster of its own: then light of members and of clusters is the same."""
    device_scene, camera, _ = slats()
    counts = {"sp_clusters": 80 if far_field_sums else 30, "vpls": 250, "vpl_clusters": 1000}
    return Pipeline(device_scene, camera, SIZE, fuzziness=fuzziness, far_field_sums=far_field_sums, **counts)


def corrections(fuzzy: Pipeline, seeds: int) -> Doubles:
    """What the SPs' rays correct, by each seed, (seed, pixel, 3)."""
    correction = Correction(fuzzy.view.pixels, fuzzy.view.device)
    found = []
    for seed in range(seeds):
        fuzzy.shade(seed)
        fuzzy.correct(correction, seed)
        found.append(correction.own.numpy().astype(np.float64))
    fuzzy.shade()
    return np.stack(found)


@pytest.fixture(scope="module")
def clustered() -> Pipeline:
    device_scene, camera, _ = slats()
    return Pipeline(device_scene, camera, (24, 18), sp_clusters=60)


def variance_of(fuzzy: Pipeline) -> Doubles:
    """Of the brightness that the rays of each SP correct by its one seed, (sp,), from what they are drawn by."""
    amount, doubts, wrong = fuzzy.unhidden().mean(axis=2), fuzzy.doubts(), fuzzy.seen() - fuzzy.shares()
    whole = (amount * doubts).sum(axis=1, keepdims=True)
    square = (whole * amount * wrong**2 / doubts).sum(axis=1)
    return np.maximum(square - (amount * wrong).sum(axis=1) ** 2, 0.0) / CHECKS


@pytest.mark.parametrize("far_field_sums", [False, True])
@pytest.mark.parametrize("beliefs", ["traced", "nonsense", "nothing", "all_emitters"])
def test_the_mean_of_corrections_is_what_clusters_are_wrong_by(beliefs: str, far_field_sums: bool) -> None:
    fuzzy = point_lights(far_field_sums=far_field_sums)
    shape = (fuzzy.clustering.count, fuzzy.lights.count)
    if beliefs == "nonsense":
        fuzzy.believe(np.random.default_rng(0).integers(0, 2, shape))
    elif beliefs != "traced":
        fuzzy.believe(np.full(shape, int(beliefs == "all_emitters")))
    wrong = (fuzzy.unhidden().mean(axis=2) * (fuzzy.seen() - fuzzy.shares())).sum(axis=1)
    if not far_field_sums:
        assert wrong == pytest.approx((fuzzy.exact() - fuzzy.irradiance())[fuzzy.pixels].mean(axis=1), abs=1e-4)
    found = corrections(fuzzy, SEEDS)[:, fuzzy.pixels].mean(axis=2)
    off = found.mean(axis=0) - wrong
    error = np.sqrt(variance_of(fuzzy) / SEEDS)
    whole = found.sum(axis=1).std(ddof=1) / np.sqrt(SEEDS)
    # What is found is much more than noise, or nothing would be tested; by SPs, and by the whole picture.
    assert np.abs(wrong).sum() > 10.0 * whole
    assert abs(off.sum()) < 4.0 * whole
    exact = error <= 1e-6 * error.max()
    assert np.abs(off[exact]).max(initial=0.0) < 1e-3 * error.max()
    # Far targets are drawn by what representatives know of them, which is near what SPs would know.
    assert 0.7 < np.mean((off[~exact] / error[~exact]) ** 2) < (1.8 if far_field_sums else 1.4)
    assert (fuzzy.view.indirect.far_importance.numpy() > 0.0).any() == far_field_sums


def test_rays_of_neighbours_take_other_parts_of_their_light() -> None:
    """So that less is left of their noise together than of as many rays at random."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    device_scene = resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])
    camera = look_at((0.0, 0.0, 0.45), (0.0, -0.2, -0.5))
    room = Pipeline(device_scene, camera, SIZE, sp_clusters=100, vpls=250, vpl_clusters=1000, far_field_sums=True)
    # All is seen, which clusters believe of one half of the lights.
    shape = room.clustering.count, room.lights.count
    room.believe(np.broadcast_to(np.arange(shape[1]) < shape[1] // 2, shape))
    found = corrections(room, SEEDS)[:, room.pixels].mean(axis=2)
    far, near = (
        array.numpy()[: room.sp_count]
        for array in (room.view.indirect.far_importance, room.view.indirect.near_importance)
    )
    mostly_far = far > 4.0 * near
    assert mostly_far.sum() > 20
    found, at_random = found[:, mostly_far], variance_of(room)[mostly_far].sum()
    assert found.var(axis=0, ddof=1).sum() < 0.85 * at_random
    assert found.sum(axis=1).var(ddof=1) < 0.7 * at_random


def test_where_clusters_tell_the_truth_nothing_is_corrected() -> None:
    fuzzy = point_lights(fuzziness=1)
    assert (corrections(fuzzy, 1) != 0.0).any()
    fuzzy.know_the_truth()
    assert (corrections(fuzzy, 3) == 0.0).all()


def test_pictures_of_vpl_clusters_come_near_those_of_all_their_members(clustered: Pipeline) -> None:
    exact, fuzzy = clustered.of_members(), clustered.irradiance()
    corrected = fuzzy + corrections(clustered, 400).mean(axis=0)
    assert relative_error(corrected, exact) < 0.1 * relative_error(fuzzy, exact)
    assert corrected.mean() == pytest.approx(exact.mean(), rel=0.02)


def test_a_correction_has_less_noise_than_the_light_it_corrects() -> None:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    device_scene = resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])
    camera = look_at((0.0, 0.0, 0.45), (0.0, -0.2, -0.5))
    room = Pipeline(device_scene, camera, (24, 18), sp_clusters=100)
    noise = corrections(room, 100).std(axis=0)[room.pixels]
    room.believe(np.zeros((room.clustering.count, room.lights.count)))
    assert (noise**2).mean() < 0.3 * (corrections(room, 100).std(axis=0)[room.pixels] ** 2).mean()


def test_several_passes_give_the_mean_of_as_many_corrections(clustered: Pipeline) -> None:
    correction = Correction(clustered.view.pixels, clustered.view.device)

    def corrected(seed: int, passes: int) -> Doubles:
        clustered.correct(correction, seed, range(passes))
        return correction.own.numpy()[clustered.pixels].astype(np.float64)

    one, other = corrected(3, 1), corrected(3 + int(PASS_SEED), 1)
    assert not np.allclose(one, other)
    assert np.allclose(corrected(3, 2), (one + other) / 2.0, rtol=1e-5, atol=1e-7 * np.abs(one).max())


def test_a_second_look_at_some_takes_as_many_rays_into_their_mean_and_leaves_the_others(clustered: Pipeline) -> None:
    view, correction = clustered.view, Correction(clustered.view.pixels, clustered.view.device)
    sps, some = view.shading_points, np.arange(5, clustered.sp_count, 7)
    points = OutlierPoints(view.pixels, view.pixels, view.device)
    listed = points.points = PointList()
    listed.numbers, listed.pixels = column(some, int), column(sps.pixels.numpy()[some], int)
    listed.count, points.capacity = column([len(some)], int), len(some)
    clustered.correct(correction, 3, range(2))
    both = correction.own.numpy().copy()
    clustered.correct(correction, 3)
    once = correction.own.numpy().copy()
    clustered.correct(correction, 3, range(1, 2), points)
    looked = np.isin(np.arange(view.pixels), clustered.pixels[some])
    assert (once != both)[looked].any()
    assert np.array_equal(correction.own.numpy(), np.where(looked[:, None], both, once))


@pytest.mark.parametrize("passes", [1, 2])
def test_what_is_settled_sends_rays_at_a_second_look_only(clustered: Pipeline, passes: int) -> None:
    view, correction = clustered.view, Correction(clustered.view.pixels, clustered.view.device)
    settled = np.arange(view.pixels) % 3 == 0

    def corrected(numbers: range, *, some: bool) -> Doubles:
        clustered.correct(correction, 3, numbers, settled=column(settled, int) if some else None)
        return correction.own.numpy().astype(np.float64)

    first, all_ = range(passes), range(passes + 1)
    once, again = corrected(first, some=False), corrected(all_, some=False)
    assert np.array_equal(corrected(first, some=True), np.where(settled[:, None], 0.0, once))
    own = again - once * passes / (passes + 1)
    wanted = np.where(settled[:, None], own, again)
    looked = corrected(range(passes, passes + 1), some=True)
    assert np.allclose(looked, wanted, rtol=1e-4, atol=1e-6 * np.abs(once).max())


@pytest.mark.parametrize("passes", [1.0, 1.5, 2.25, 4.0])
def test_sps_have_as_many_passes_in_the_mean_as_are_wanted(clustered: Pipeline, passes: float) -> None:
    correction = Correction(clustered.view.pixels, clustered.view.device, 4)

    def corrected(count: int, *, as_wanted: bool = False) -> Doubles:
        clustered.correct(correction, 3, range(count), as_wanted=as_wanted)
        return correction.own.numpy()[clustered.pixels].astype(np.float64)

    correction.use(passes)
    means = np.stack([corrected(count) for count in range(1, 5)])
    found = corrected(4, as_wanted=True)
    lit = np.all([np.any(means[one] != means[other], axis=1) for one, other in combinations(range(4), 2)], axis=0)
    assert lit.mean() > 0.3
    same = np.all(found == means, axis=2)
    assert np.all(same[:, lit].sum(axis=0) == 1)
    number = 1 + same.argmax(axis=0)
    assert set(number[lit]) == {int(passes), int(np.ceil(passes))}
    assert number[lit].mean() == pytest.approx(passes, abs=0.1)
    # SPs whose rays a warp traces have the same number.
    runs = np.arange(clustered.sp_count) // int(RUN)
    assert all(len(set(number[lit & (runs == run)])) <= 1 for run in set(runs))


@pytest.mark.parametrize(("passes", "run"), [(1.0, 1), (1.06, 2), (2.0, 2), (4.0, 4)])
def test_passes_that_no_sp_has_are_not_run(
    clustered: Pipeline, monkeypatch: pytest.MonkeyPatch, passes: float, run: int
) -> None:
    correction, launched = Correction(clustered.view.pixels, clustered.view.device, 4), []
    correction.use(passes)
    monkeypatch.setattr("gpu.correction.visibility_correction.launch", lambda kernel, *_: launched.append(kernel))
    clustered.correct(correction, 3, range(4), as_wanted=True)
    assert launched.count(correction_kernel) == run
    launched.clear()
    clustered.correct(correction, 3, range(4))
    assert launched.count(correction_kernel) == 4


@pytest.mark.parametrize(("frames", "least"), [(0, 0.3), (2, 0.1)])
def test_a_bounded_correction_leaves_some_light_and_less_by_the_rays_of_more_frames(
    clustered: Pipeline, frames: int, least: float
) -> None:
    """Where no neighbour shares them, few rays that all end by chance would leave black specks."""
    view, rng = clustered.view, np.random.default_rng(0)
    told, lacks = rng.uniform(0.5, 2.0, (view.pixels, 3)), rng.uniform(-4.0, 1.0, (view.pixels, 3))
    bounded = column(lacks, wp.vec3)
    known = column(np.full(view.pixels, frames), int)
    Correction(view.pixels, view.device).bound(view.shading_points, column(told, wp.vec3), known, bounded)
    wanted = np.maximum(told + lacks, least * told) - told
    shaded = np.isin(np.arange(view.pixels), clustered.pixels)[:, None]
    assert bounded.numpy() == pytest.approx(np.where(shaded, wanted, lacks), rel=1e-5, abs=1e-6)


def test_the_same_seed_gives_the_same_bits_and_another_other_rays(clustered: Pipeline) -> None:
    first, second = corrections(clustered, 2), corrections(clustered, 2)
    assert first.tobytes() == second.tobytes()
    assert (first[0] != first[1]).any()
