import numpy as np
import pytest
from pipeline import Pipeline, relative_error
from scenes import slats

from gpu.indirect.exact_gather import gather
from gpu.indirect.irradiance import allocate_indirect


@pytest.fixture
def fuzzy() -> Pipeline:
    device_scene, camera, size = slats((24, 18))
    return Pipeline(device_scene, camera, size, sp_clusters=60, fuzziness=1)


def test_all_light_that_is_seen_is_gathered(fuzzy: Pipeline) -> None:
    expected = np.einsum("svc,sv->sc", fuzzy.unhidden(), fuzzy.seen())
    assert expected.max() > 0.0
    assert np.allclose(fuzzy.exact()[fuzzy.pixels], expected, rtol=1e-4, atol=1e-6 * expected.max())


def test_gather_and_shade_agree_when_every_sp_is_a_cluster_of_its_own(fuzzy: Pipeline) -> None:
    exact = fuzzy.exact()
    assert relative_error(fuzzy.irradiance(), exact) > 1e-3
    fuzzy.know_the_truth()
    assert np.allclose(fuzzy.irradiance(), exact, rtol=1e-3, atol=1e-5 * exact.max())


def test_runs_of_vpl_clusters_add_up(fuzzy: Pipeline) -> None:
    middle = fuzzy.lights.count // 2
    one, other = fuzzy.gathered(fuzzy.lights, 0, middle), fuzzy.gathered(fuzzy.lights, middle)
    assert one.sum() > 0.0
    assert other.sum() > 0.0
    assert np.allclose(one + other, fuzzy.exact(), rtol=1e-5)


def test_many_small_runs_are_not_lost_in_rounding(fuzzy: Pipeline) -> None:
    view, out = fuzzy.view, allocate_indirect(fuzzy.view.pixels, fuzzy.view.device)
    light = fuzzy.gathered(fuzzy.lights, 1, 2)
    much, runs = float(2**26 * light.max()), 100
    out.irradiance.fill_(much)
    for _ in range(runs):
        gather(view.scene, view.gbuffer, view.shading_points, fuzzy.lights, 1, 2, out)
    grown = out.irradiance.numpy().astype(np.float64) - out.lost.numpy() - np.float32(much)
    assert grown == pytest.approx(runs * light, rel=1e-3, abs=1e-3 * light.max())
