import pytest

from server.worker.turn_clock import TurnClock


def test_time_is_shared_among_the_turns_under_way(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [10.0]
    monkeypatch.setattr("server.worker.turn_clock.perf_counter", lambda: now[0])
    clock = TurnClock()
    clock.begin(1)
    now[0] += 1.0
    clock.begin(2)
    now[0] += 4.0
    clock.begin(1)  # goes on
    assert clock.end(2) == 2.0
    now[0] += 0.5
    assert clock.end(1) == 3.5
    now[0] += 9.0  # nobody's
    clock.begin(3)
    assert clock.end(3) == clock.end(4) == 0.0


def test_one_who_waits_for_another_uses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("server.worker.turn_clock.perf_counter", lambda: now[0])
    clock = TurnClock()
    clock.begin(1)
    clock.begin(2)
    clock.wait(2)
    now[0] += 1.0
    assert clock.end(1) == 1.0
    clock.begin(2)
    now[0] += 2.0
    clock.wait(2)
    assert clock.end(2) == 2.0
