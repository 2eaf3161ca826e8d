import math

import numpy as np
import pytest

from server.wire.frame_header import FrameHeader
from tests.load.figures import Level, bottleneck, crowd_row, fairness, jitter, slope, spread, table, viewer_row
from tests.load.viewer import Log, Seen


def seen(at: float, age: float | None, render: float = 5.0, decoded: float | None = None) -> Seen:
    header = FrameHeader(64, 36, 1, 1, 0, 2.0, render, 1.0, {})
    return Seen(at, header, 1000, age, decoded, None if decoded is None else 2.0)


def log(fps: int, age: float, number: int = 1) -> Log:
    """A viewer who got that many frames of that age each second, for ten seconds."""
    return Log(seen=[seen(index / fps, age) for index in range(10 * fps)], number=number)


def test_percentiles_are_of_all_values() -> None:
    figures = spread(range(101))
    assert figures == {"mean": 50.0, "p50": 50.0, "p95": 95.0, "p99": 99.0}
    assert spread([]) is None


def test_jitter_is_the_mean_change_of_consecutive_ages() -> None:
    assert jitter([10.0, 14.0, 12.0]) == pytest.approx(3.0)
    assert jitter([10.0]) == 0.0


def test_fairness_is_one_when_all_get_the_same_and_one_over_n_when_one_gets_all() -> None:
    assert fairness([7.0, 7.0, 7.0]) == pytest.approx(1.0)
    assert max(fairness(3 * [step / 7.0]) for step in range(1, 200)) == 1.0
    assert fairness([9.0, 0.0, 0.0]) == pytest.approx(1.0 / 3.0)
    assert fairness([0.0, 0.0]) == 1.0


def test_frames_count_from_the_first_time_to_the_last_and_only_those_of_new_poses() -> None:
    walk = log(10, 20.0)
    walk.seen[35] = seen(3.5, None)  # a sharper picture of a view at rest
    row = viewer_row(walk, 2.0, 7.0)
    assert row["frames"] == 50
    assert row["fps"] == pytest.approx(49 / 5)
    assert row["age"]["p95"] == 20.0
    assert row["longest_gap_ms"] == pytest.approx(200.0)
    assert row["bytes_a_second"] == pytest.approx(10_000.0)


def test_a_level_is_missed_by_the_viewer_who_gets_too_little() -> None:
    level = Level(fps=8.0, age=100.0)
    assert level.missed(crowd_row([log(10, 50.0, 1), log(10, 60.0, 2)], 0.0, 10.0, {})) == []
    few, old = log(5, 50.0, 2), log(10, 150.0, 3)
    missed = level.missed(crowd_row([log(10, 50.0, 1), few, old], 0.0, 10.0, {}))
    assert [line.split(":")[0] for line in missed] == ["viewer 2", "viewer 3"]


def test_a_viewer_without_frames_misses_every_level() -> None:
    assert Level().missed(crowd_row([Log(number=1)], 0.0, 10.0, {}))


def test_errors_and_closes_miss_every_level() -> None:
    walk = log(30, 10.0)
    walk.errors["render-failed: why"] += 2
    walk.closed = (1008, "too slow")
    row = crowd_row([walk], 0.0, 10.0, {})
    assert row["errors"] == {"render-failed: why": 2, "closed with 1008: too slow": 1}
    assert len(Level().missed(row)) == 2


def test_a_limit_of_decoding_counts_for_those_who_decode() -> None:
    decoding = Log(seen=[seen(index / 30, 10.0, decoded=40.0) for index in range(300)], number=1)
    row = crowd_row([decoding, log(30, 10.0, 2)], 0.0, 10.0, {})
    assert len(Level(decoded=30.0).missed(row)) == 1
    assert Level(decoded=50.0).missed(row) == []


def test_the_bottleneck_is_what_is_busy_else_what_takes_longest() -> None:
    parts = {"queue": 3.0, "render": 9.0, "network": 1.0}
    assert bottleneck(parts, {"renderer": 0.95, "web process": 0.3}).startswith("renderer (busy 95")
    assert bottleneck(parts, {"renderer": 0.5}).startswith("render (9.0 ms of 13.0")
    assert bottleneck({}, {}) == "no frames"


def test_shares_of_a_crowd_add_up_what_the_renderer_did() -> None:
    row = crowd_row([log(30, 20.0, 1), log(30, 20.0, 2)], 0.0, 10.0, {"harness": 0.1})
    assert row["shares"]["renderer"] == pytest.approx(2 * 30 * 0.005)
    assert row["parts_ms"]["network"] == pytest.approx(20.0 - 2.0 - 5.0 - 1.0)
    assert row["fairness"] == pytest.approx(1.0)
    assert "20" in table([row]).splitlines()[1]


def test_a_slope_is_found_under_noise_and_none_where_there_is_none() -> None:
    seconds = np.arange(600.0)
    noise = np.random.default_rng(0).normal(0.0, 3.0, seconds.size)
    grows, flat = slope(seconds, 0.05 * seconds + noise), slope(seconds, noise)
    assert grows.gain == pytest.approx(0.05, rel=0.1)
    assert grows.significant
    assert not flat.significant


def test_too_few_samples_have_no_slope() -> None:
    assert math.isinf(slope([0.0, 1.0], [0.0, 1.0]).error)
