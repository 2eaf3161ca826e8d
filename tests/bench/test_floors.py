import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest
import warp as wp

from gpu.device_scene.data import NO_HIT
from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.load import load_scene
from gpu.settings import Component, RenderSettings
from tests.bench.floor_model import STAGES, floors
from tests.bench.floors import amounts, launches_counted
from tests.bench.rates import byte_rate, facing_pairs, fma_rate, launch_rate, ray_rates, seconds_of, spread_out
from tests.bench.timing import measure_frames

RATES = {"bytes": 1e12, "fmas": 1e13, "launches": 1e6, "any_hit_rays": 1e9, "primary_rays": 1e9}


class Ones(dict[str, float]):
    """Counts that are all 1."""

    def __missing__(self, name: str) -> float:
        return 1.0


def twice(rates: Mapping[str, float], name: str) -> dict[str, float]:
    return {**rates, name: 2.0 * rates[name]}


def test_a_floor_is_its_largest_term_and_its_launches() -> None:
    counts = Ones(rays=2e6, sp_clusters=1000, vpl_clusters=1000)
    stage = floors(["visibility"], counts, RATES, {"visibility": 500})["visibility"]
    assert stage["terms"][0]["what"] == "rays between representatives"
    assert stage["terms"][0]["ms"] == pytest.approx(2.0)
    assert stage["launch_ms"] == pytest.approx(0.5)
    assert stage["floor_ms"] == pytest.approx(2.5)


def test_terms_fall_with_the_rates_that_they_name() -> None:
    before = floors(STAGES, Ones(), RATES, {})
    for name in ("bytes", "fmas", "any_hit_rays", "primary_rays"):
        after = floors(STAGES, Ones(), twice(RATES, name), {})
        for stage in STAGES:
            old, new = ({term["what"]: term for term in run[stage]["terms"]} for run in (before, after))
            for what, term in old.items():
                share = 0.5 if term["rate"] == name else 1.0
                assert new[what]["ms"] == pytest.approx(share * term["ms"])


def test_no_rate_is_no_floor() -> None:
    rates = {**RATES, "any_hit_rays": 0.0}
    assert floors(["correct"], Ones(), rates, {})["correct"]["terms"][-1]["ms"] == 0.0


def test_facing_pairs_are_those_that_both_face() -> None:
    # A floor's point and one on the ceiling's upper side; lamps above and below, all but the last shining down.
    sps = np.array([[[0, 0, 0], [0, 3, 0]], [[0, 1, 0], [0, 1, 0]]], np.float32)
    vpls = np.array([[[0, 2, 0], [0, -1, 0], [1, 4, 0], [1, 4, 0]], [[0, -1, 0]] * 3 + [[0, 1, 0]]], np.float32)
    assert facing_pairs(sps, vpls).tolist() == [0, 4, 5]


def test_chosen_pixels_have_a_surface_and_are_spread() -> None:
    face = np.arange(64, dtype=np.int32)
    face[:32] = NO_HIT
    chosen = spread_out(face, (8, 8), 8)
    assert len({*chosen.tolist()}) == 8
    assert (face[chosen] >= 0).all()
    assert len(spread_out(np.full(64, NO_HIT, np.int32), (8, 8), 8)) == 0


def test_what_a_frame_does_not_count_has_no_floor() -> None:
    counts = {"pixels": 1e6, "sps": 1e5}
    assert set(floors(STAGES, counts, RATES, {})) == {"gbuffer", "history", "near", "interpolate", "keep", "display"}


def test_terms_of_one_rate_add_up_and_those_of_others_hide() -> None:
    counts = Ones(sps=1e6, sp_clusters=1e5, vpl_clusters=1e4, near_pairs=1e7, facing=0.5)
    stage = floors(["shade", "unheard of"], counts, RATES, {})
    assert set(stage) == {"shade"}
    terms = stage["shade"]["terms"]
    assert stage["shade"]["floor_ms"] == pytest.approx(sum(term["ms"] for term in terms if term["rate"] == "fmas"))
    assert stage["shade"]["bound"] == "fmas"


def test_a_frame_has_launches_by_stage_and_amounts() -> None:
    device_scene = DeviceScene(load_scene("cornell-box"), "cpu")
    few = {"sp_clusters": 16, "vpl_clusters": 8, "vpls": 64}
    settings = RenderSettings(component=Component.INDIRECT, lambertian=True, antialias=False, **few)
    renderer = Renderer(device_scene, (16, 12), settings)
    with launches_counted() as launches:
        renderer.render(device_scene.scene.cameras[0])
    measured = measure_frames(renderer, device_scene.scene.cameras[0], 2, 2)
    counts = amounts(measured, settings)
    assert 0 < counts["sps"] <= 16 * 12
    assert 0.0 < counts["facing"] < 1.0
    assert {"gbuffer", "cluster", "visibility", "shade"} <= set(launches)
    assert set(floors(measured.stages, counts, RATES, launches)) == set(STAGES) == set(measured.stages)
    assert launches["cluster"] > launches["shade"] >= 1
    assert all(rate > 0.0 for rate in ray_rates(device_scene, (16, 12), settings))


def test_a_rate_is_of_the_median_after_a_first_run(monkeypatch: pytest.MonkeyPatch) -> None:
    naps, now = iter([9.0, 0.0, 2.0, 2.0, 2.0, 9.0]), [0.0]

    def work() -> None:
        now[0] += next(naps)

    monkeypatch.setattr("tests.bench.rates.perf_counter", lambda: now[0])
    assert seconds_of(work, wp.get_device("cpu"), repeats=5) == 2.0
    assert next(naps, None) is None


@pytest.mark.parametrize("measure", [byte_rate, fma_rate, launch_rate])
def test_a_machine_has_rates(measure: Callable[[wp.Device], float]) -> None:
    assert 0.0 < measure(wp.get_device("cpu")) < math.inf
