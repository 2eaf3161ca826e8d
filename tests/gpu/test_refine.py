import numpy as np
import pytest
from pipeline import Pipeline, relative_error
from scenes import column, slats

from gpu.check import ClusterCheck
from gpu.dispute import WorstPoints
from gpu.refine import WORDS_AT_ONCE, Refinement


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    resident, camera, size = slats((48, 36))
    return Pipeline(resident, camera, size, sp_clusters=80)


def worst_of(fuzzy: Pipeline, capacity: int) -> WorstPoints:
    """The SPs that a frame would refine."""
    view, device = fuzzy.view, fuzzy.view.device
    check = ClusterCheck(view.pixels, device)
    check.run(view.scene, view.gbuffer, view.shading_points, fuzzy.clustering.clusters, fuzzy.visibility,
              fuzzy.lights, view.indirect)  # fmt: skip
    points = WorstPoints(view.pixels, capacity, 0.25, device)
    points.find(view.shading_points, fuzzy.clustering.need, view.indirect, check.stopped)
    return points


def refine(fuzzy: Pipeline, points: WorstPoints) -> None:
    view = fuzzy.view
    Refinement(len(points.pixels), view.device).run(view.scene, view.gbuffer, points, fuzzy.lights, view.indirect)


def test_rays_of_their_own_lower_the_error_of_the_worst_and_leave_the_others(fuzzy: Pipeline) -> None:
    exact, before = fuzzy.exact(), fuzzy.radiance()
    points = worst_of(fuzzy, 400)
    refined = points.pixels.numpy()[: points.count.numpy()[0]]
    assert len(refined) > 100
    refine(fuzzy, points)
    after = fuzzy.radiance()
    fuzzy.shade()
    # The mean of the whole picture is what dark means, so those that were refined are compared inside it.
    floor = 0.01 * exact.mean() ** 2
    error = [np.mean((x[refined] - exact[refined]) ** 2 / (exact[refined] ** 2 + floor)) for x in (before, after)]
    assert error[1] < 0.5 * error[0]
    assert relative_error(after, exact) < 0.8 * relative_error(before, exact)
    others = np.setdiff1d(np.arange(fuzzy.view.pixels), refined)
    assert np.array_equal(after[others], before[others])


def test_rays_keep_the_expectation(fuzzy: Pipeline) -> None:
    points = WorstPoints(fuzzy.view.pixels, fuzzy.view.pixels, 0.25, fuzzy.view.device)
    points.pixels, points.count = fuzzy.view.shading_points.pixels, fuzzy.view.shading_points.count
    refine(fuzzy, points)
    picture, exact = fuzzy.radiance(), fuzzy.exact()
    fuzzy.shade()
    assert picture.mean() == pytest.approx(exact.mean(), rel=0.03)


def test_more_vpl_clusters_than_are_traced_at_a_time(fuzzy: Pipeline) -> None:
    many = Pipeline(fuzzy.resident, fuzzy.camera, (8, 6), 10, vpls=4000, vpl_clusters=32 * WORDS_AT_ONCE + 500)
    assert many.lights.count > 32 * WORDS_AT_ONCE
    points = WorstPoints(48, 48, 0.25, many.view.device)
    points.pixels, points.count = many.view.shading_points.pixels, many.view.shading_points.count
    refine(many, points)
    picture, exact = many.radiance(), many.exact()
    assert np.allclose(picture.mean(), exact.mean(), rtol=0.05)


def test_nobody_to_refine_changes_nothing(fuzzy: Pipeline) -> None:
    points = WorstPoints(fuzzy.view.pixels, 10, 0.25, fuzzy.view.device)
    points.count = column([0], int)
    before = fuzzy.radiance()
    refine(fuzzy, points)
    assert np.array_equal(fuzzy.radiance(), before)
