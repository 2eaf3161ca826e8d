from collections.abc import Callable
from dataclasses import dataclass, field

import pytest
from harness import wait_for

from server.worker.reporter import AGAIN_SECONDS, Reporter

QUIET_SECONDS = 0.5


@dataclass
class Timer:
    """One that fires when the clock is told to pass its time."""

    due: float
    work: Callable[[], None]
    daemon: bool = False
    waits: bool = False

    def start(self) -> None:
        self.waits = True

    def cancel(self) -> None:
        self.waits = False


@dataclass
class Clock:
    """Time that passes when it is told to."""

    now: float = 100.0
    timers: list[Timer] = field(default_factory=list)

    def timer(self, seconds: float, work: Callable[[], None]) -> Timer:
        self.timers.append(Timer(self.now + seconds, work))
        return self.timers[-1]

    def pass_(self, seconds: float) -> None:
        self.now += seconds
        for timer in self.timers:
            if timer.waits and timer.due <= self.now:
                timer.waits = False
                timer.work()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr("server.worker.reporter.monotonic", lambda: clock.now)
    monkeypatch.setattr("server.worker.reporter.Timer", clock.timer)
    return clock


@pytest.fixture
def said() -> list[tuple[str, float]]:
    return []


@pytest.fixture
def report(clock: Clock, said: list[tuple[str, float]]) -> Reporter:
    return Reporter(lambda *words: said.append(words), QUIET_SECONDS)


def test_quick_work_says_nothing(clock: Clock, report: Reporter, said: list[tuple[str, float]]) -> None:
    report("reading", 0.0)
    report.end()
    clock.pass_(10.0)
    assert said == []


def test_a_timer_that_fires_as_the_work_ends_says_nothing(
    clock: Clock, report: Reporter, said: list[tuple[str, float]]
) -> None:
    report("reading", 0.0)
    report.end()
    clock.timers[0].work()  # it was past being cancelled
    assert said == []


def test_what_goes_on_when_the_quiet_time_is_over_is_said_then(
    clock: Clock, report: Reporter, said: list[tuple[str, float]]
) -> None:
    report("reading", 0.5)
    report("compiling", 2.0)
    clock.pass_(0.9 * QUIET_SECONDS)
    assert said == []
    clock.pass_(0.2 * QUIET_SECONDS)
    assert said == [("compiling", 1.0)]
    clock.pass_(AGAIN_SECONDS)
    report("tracing", 0.5)
    assert said[1:] == [("tracing", 0.5)]


def test_what_was_said_when_the_quiet_time_was_over_is_not_said_again(
    clock: Clock, report: Reporter, said: list[tuple[str, float]]
) -> None:
    report("reading", 0.5)
    clock.now += 2.0 * QUIET_SECONDS  # the next words come before the timer does
    report("compiling", 1.0)
    clock.pass_(10.0)
    assert said == [("compiling", 1.0)]
    clock.timers[0].work()  # it was past being cancelled
    assert said == [("compiling", 1.0)]


def test_words_come_not_too_often_and_the_last_ones_come(
    clock: Clock, report: Reporter, said: list[tuple[str, float]]
) -> None:
    clock.pass_(QUIET_SECONDS)
    for step in range(1000):
        report("tracing", step / 1000)
        clock.pass_(0.001)
    assert len(said) == pytest.approx(1.0 / AGAIN_SECONDS, abs=1)
    clock.pass_(AGAIN_SECONDS)
    assert said[-1] == ("tracing", 0.999)


def test_real_timers_fire(said: list[tuple[str, float]]) -> None:
    report = Reporter(lambda *words: said.append(words), 0.01)
    report("reading", 0.5)
    wait_for(lambda: said == [("reading", 0.5)])
    report.end()
