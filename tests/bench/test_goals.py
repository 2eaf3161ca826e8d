import pytest

from tests.bench.goals import Goal, goals
from tests.bench.store import Row


def sweep_row(scene: str, *, energy: float = 1.0, mse: float = 1e-4, stage_ms: float = 2.0, **settings: int) -> Row:
    spread = {"median": stage_ms, "p5": stage_ms, "p95": stage_ms}
    total = {"rel_mse": 0.01, "mse": 1e-3, "flip": 0.1, "energy": energy, "nonfinite": 0}
    return {
        "scene": scene,
        "groups": ["paper"] if settings else ["default"],
        "settings": {"method": "fuzzy-vpl", "clustering": "both", **settings},
        "frame_ms": {key: 4.0 * value for key, value in spread.items()},
        "stages": {"gbuffer": spread, "shade": spread, "refine": spread, "display": spread},
        "errors": {"total": total, "clustering": {**total, "mse": mse}},
    }


def by_name(rows: dict[str, list[Row]]) -> dict[str, Goal]:
    return {goal.what: goal for goal in goals(rows)}


def test_nothing_measured_meets_nothing() -> None:
    assert {goal.verdict for goal in goals({})} == {"not measured"}


def test_indirect_light_is_not_charged_for_primary_rays_and_display() -> None:
    rows = [sweep_row("room"), sweep_row("hall", stage_ms=4.0)]
    found = by_name({"sweep": rows})
    alone = found["time of indirect light's stages, of frames that begin from nothing"]
    assert alone.values == {"room": 4.0, "hall": 8.0}
    assert alone.missed() == [("hall", 8.0)]
    assert found["time of indirect light's stages, in motion"].verdict == "not measured"
    rows[1]["motion"] = sweep_row("hall", stage_ms=1.0)
    found = by_name({"sweep": rows})
    assert found["time of indirect light's stages, in motion"].values == {"hall": 2.0}
    assert found["time of frames in motion, with primary rays and display"].values == {"hall": 4.0}
    assert found["total relMSE in motion, each"].values == {"hall": 0.01}


def test_one_scene_that_misses_misses_the_goal() -> None:
    goal = Goal("error", 1.0, {"good": 0.5, "bad": 2.0, "worse": 3.0})
    assert goal.verdict == "missed"
    assert goal.missed() == [("worse", 3.0), ("bad", 2.0)]
    assert goal.worst() == ("worse", 3.0)
    assert goal.reached() == ["good"]
    assert goal.excess(2.0) == pytest.approx(2.0)
    assert Goal("error", 1.0, {"good": 1.0}).verdict == "met"


@pytest.mark.parametrize(("value", "verdict"), [(0.96, "missed"), (0.97, "met"), (1.03, "met"), (1.04, "missed")])
def test_energy_has_two_ends(value: float, verdict: str) -> None:
    found = by_name({"sweep": [sweep_row("room", energy=value)]})
    assert found["energy, mean over the reference's"].verdict == verdict


def test_each_of_the_papers_settings_has_its_own_error() -> None:
    rows = [sweep_row("room", mse=2e-3, sp_clusters=1000, vpl_clusters=750)]
    rows.append(sweep_row("room", mse=2e-3, sp_clusters=30_000, vpl_clusters=4000))
    verdicts = [goal.verdict for goal in goals({"sweep": rows}) if "paper" in goal.what]
    assert verdicts == ["met", "not measured", "missed"]


def test_a_target_is_held_when_nine_frames_of_ten_are_within_a_tenth_of_it() -> None:
    rows = [
        {"scene": "room", "target": {"ms": 6.0}, "held": {"within": 0.95, "mean": 1.0}},
        {"scene": "room", "target": {"ms": 20.0}, "held": {"within": 0.5, "mean": 0.95}},
        {"scene": "room", "target": {"error": 1e-3}, "held": {"within": 1.0, "mean": 1.05}},
        {"scene": "hall", "target": {"error": 1e-3}, "held": {"within": 0.3, "mean": 0.85}},
    ]
    found = by_name({"targets": rows})
    assert found["share of frames within 10 % of a wanted time"].missed() == [("room 20", 0.5)]
    assert found["share of frames within 10 % of a wanted error"].missed() == [("hall 0.001", 0.3)]
    assert found["mean time of a walk over the wanted one"].verdict == "met"
    assert found["mean error of a walk over the wanted one"].missed() == [("hall 0.001", 0.85)]


def test_a_view_that_rests_is_judged_by_its_last_picture_within_a_second() -> None:
    points = [
        {
            "seconds": s,
            "frames": 1,
            "errors": {"rel_mse": e, "energy": 1.0 + e},
            "rel_mse_beyond_noise": e - 0.002,
            "tile_change": 2.0 * e,
        }
        for s, e in ((0.1, 0.1), (0.9, 0.006), (1.1, 0.003))
    ]
    found = by_name({"still": [{"scene": "room", "points": points}]})
    assert found["relMSE of a view that rests, all light, within 1 s"].missed() == [("room", 0.006)]
    assert found["relMSE of a view that rests, within 1 s, beyond the reference's own noise"].values == {"room": 0.004}
    assert found["energy of a view that rests, within 1 s"].missed() == [("room", 1.006)]
    after = found["relMSE of a view that rests, within 10 s, beyond the reference's own noise"]
    assert after.missed() == [("room", pytest.approx(0.001))]
    change = found["change of any of 8×8 tiles from the first frame of a view that rests to the last"]
    assert change.verdict == "met"
    assert (
        by_name({"still": [{"scene": "slow", "points": points[2:]}]})[
            "relMSE of a view that rests, all light, within 1 s"
        ].verdict
        == "not measured"
    )
