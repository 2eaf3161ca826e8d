import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline
from scenes import slats

from gpu.check import CONFIRMED_SHARE, ClusterCheck
from gpu.scene.types import Doubles
from gpu.shade import CHECKS


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    resident, camera, size = slats((48, 36))
    return Pipeline(resident, camera, size, sp_clusters=80)


def stopped_of(fuzzy: Pipeline) -> Doubles:
    """The share of each SP's rays that was stopped, (sp,)."""
    check = ClusterCheck(fuzzy.view.pixels, fuzzy.view.device)
    view = fuzzy.view
    check.run(view.scene, view.gbuffer, view.shading_points, fuzzy.clustering.clusters, fuzzy.visibility,
              fuzzy.lights, view.indirect)  # fmt: skip
    return np.asarray(check.stopped.numpy()[: fuzzy.sp_count], np.float64)


def test_sps_whose_clusters_see_too_much_have_rays_stopped(fuzzy: Pipeline) -> None:
    stopped = stopped_of(fuzzy)
    assert set(np.round(stopped * CHECKS, 6)) <= set(range(CHECKS + 1))
    assert 0.0 < stopped.mean() < 0.3
    fuzzy_light = fuzzy.radiance()[fuzzy.pixels].mean(axis=1)
    exact = fuzzy.exact()[fuzzy.pixels].mean(axis=1)
    excess = (fuzzy_light - exact) / fuzzy_light.mean()
    assert excess[stopped == 1.0].mean() > 3.0 * max(excess[stopped == 0.0].mean(), 0.01)


def test_no_ray_is_stopped_where_the_clusters_tell_the_truth(fuzzy: Pipeline) -> None:
    # Nothing is seen, so nothing can be wrong about what is.
    blind = Pipeline(fuzzy.resident, fuzzy.camera, (16, 12), sp_clusters=20)
    blind.visibility.words.zero_()
    blind.shade()
    assert (stopped_of(blind) == 0.0).all()


def test_where_all_is_believed_seen_only_as_many_as_the_list_holds_are_confirmed(fuzzy: Pipeline) -> None:
    sure = Pipeline(fuzzy.resident, fuzzy.camera, fuzzy.size, sp_clusters=80)
    sure.visibility.words.fill_(wp.uint32(0xFFFFFFFF))
    # The last word's bits beyond the VPL clusters stay clear, as they are when traced.
    words = sure.visibility.words.numpy()
    words[:, -1] = (1 << (sure.lights.count % 32)) - 1
    sure.visibility.words.assign(words)
    sure.shade()
    stopped = stopped_of(sure)
    assert stopped.mean() > stopped_of(fuzzy).mean()
    confirmed = (stopped > 0.0) & (stopped < 1.0)
    assert 0 < confirmed.sum() <= int(sure.view.pixels * CONFIRMED_SHARE)


def test_the_same_frame_gives_the_same_answers(fuzzy: Pipeline) -> None:
    assert np.array_equal(stopped_of(fuzzy), stopped_of(fuzzy))
