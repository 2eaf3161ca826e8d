import asyncio
from collections import Counter

import pytest

from tests.load.figures import slope
from tests.load.soak import Record, Soak, soak, soak_row
from tests.load.target import Target
from tests.load.viewer import Plan

MINUTES = 8
HOUR = Soak(Plan(), 60.0 * MINUTES)


def record(gain: float, jump: float = 0.0) -> Record:
    """Memory that grows by `gain` MB a minute, and by `jump` MB in the first minute."""
    seconds = range(60 * MINUTES)
    samples = [
        {
            "seconds": float(at),
            "viewers": 3.0,
            "web_mb": 100.0 + gain * at / 60 + jump * min(at / 60, 1) + (at % 7) / 10,
        }
        for at in seconds
    ]
    return Record(samples=samples)


def test_memory_that_grows_is_found_and_what_caches_take_at_first_is_not() -> None:
    assert soak_row(record(0.0, jump=50.0), HOUR)["missed"] == []
    row = soak_row(record(3.0), HOUR)
    assert row["growth"]["web_mb"]["mb_a_minute"] == pytest.approx(3.0, rel=0.05)
    assert [line.split(" ")[0] for line in row["missed"]] == ["web"]


def test_growth_below_the_bound_is_let_pass() -> None:
    assert slope([0, 1, 2, 3, 4, 5, 6], [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]).significant
    assert soak_row(record(0.5), HOUR)["missed"] == []


def test_any_error_fails_a_soak() -> None:
    wrong = record(0.0)
    wrong.errors = Counter({"render-failed: why": 2})
    assert soak_row(wrong, HOUR)["missed"] == ["2 × render-failed: why"]


def test_a_short_soak_of_a_service_has_no_error(target: Target) -> None:
    row = asyncio.run(soak(target, Soak(Plan(size=(96, 54)), seconds=9.0, viewers=3, rest_rate=2.0, growth=1e6)))
    assert row["missed"] == []
    assert row["visits"] >= 3
    assert row["frames"] > 20
    assert set(row["stills"]) == {"200"}
    assert len(row["samples"]) >= 4
