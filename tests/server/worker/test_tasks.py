from collections.abc import Callable
from threading import Thread

import pytest

from server.worker.tasks import CancelledError, Tasks


def stepping(tasks: Tasks, said: list[str], name: str, steps: int = 3) -> Callable[[], None]:
    """A job of some steps that is interrupted after each, if that is due."""

    def work() -> None:
        for step in range(steps):
            said.append(f"{name}{step}")
            if tasks.due():
                tasks.give()

    return work


def test_a_job_goes_on_where_it_was_interrupted() -> None:
    tasks, said = Tasks(), list[str]()
    for request, name in ((1, "a"), (2, "b")):
        tasks.ask_back(request)
        assert not tasks.start(request, stepping(tasks, said, name))
    tasks.ask_back(1)
    assert not tasks.resume(1)
    assert tasks.resume(2)  # nobody asked
    assert tasks.resume(1)
    assert said == ["a0", "b0", "a1", "b1", "b2", "a2"]


def test_a_job_has_its_time_before_it_is_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("server.worker.tasks.perf_counter", lambda: now[0])
    tasks, due = Tasks(turn_seconds=1.0), list[bool]()

    def work() -> None:
        for seconds in (0.5, 0.4, 0.2):
            now[0] += seconds
            due.append(tasks.due())

    tasks.ask_back(7)
    assert tasks.start(7, work)
    assert due == [False, False, True]
    assert not tasks.due()  # nothing runs


def test_other_threads_interrupt_nothing() -> None:
    tasks, due = Tasks(), list[bool]()

    def work() -> None:
        thread = Thread(target=lambda: due.append(tasks.due()))
        thread.start()
        thread.join()
        due.append(tasks.due())

    tasks.ask_back(1)
    tasks.start(1, work)
    assert due == [False, True]


def test_what_one_holds_another_waits_for_and_lends_its_turns() -> None:
    tasks, said = Tasks(), list[str]()

    def holding(name: str, what: str) -> Callable[[], None]:
        def work() -> None:
            with tasks.holding(what):
                stepping(tasks, said, name)()

        return work

    tasks.ask_back(1)
    assert not tasks.start(1, holding("a", "it"))
    assert not tasks.start(2, holding("b", "it"))  # has to wait
    assert tasks.start(3, holding("c", "other"))
    tasks.ask_back(2)
    assert not tasks.resume(2)
    assert said == ["a0", "c0", "c1", "c2", "a1"]
    assert not tasks.resume(2)  # ends the first
    assert tasks.resume(2)
    assert said[5:] == ["a2", "b0", "b1", "b2"]


def test_one_who_waits_can_be_cancelled_and_what_was_held_is_free_after_an_error() -> None:
    tasks, said = Tasks(), list[str]()

    def work() -> None:
        try:
            with tasks.holding("it"):
                stepping(tasks, said, "a")()
        except CancelledError:
            said.append("cancelled")

    tasks.ask_back(1)
    assert not tasks.start(1, work)
    assert not tasks.start(2, work)
    tasks.cancel(1)
    assert not tasks.resume(2)
    assert tasks.resume(2)
    assert said == ["a0", "cancelled", "a0", "a1", "a2"]
    tasks.cancel(99)  # there is none


def test_what_a_job_raises_reaches_whoever_gave_the_turn() -> None:
    tasks = Tasks()

    def work() -> None:
        raise ValueError("wrong")

    with pytest.raises(ValueError, match="wrong"):
        tasks.start(1, work)
    assert tasks.start(1, lambda: None)
