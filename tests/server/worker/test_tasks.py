from collections.abc import Callable
from functools import partial
from itertools import chain, repeat
from threading import Thread

import pytest

from server.worker.tasks import IDLE_POLL_SECONDS, POLL_SECONDS, STINT_SECONDS, CancelledError, Tasks, Turn

OPEN, GIVEN_BACK, ENDED = Turn


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
        assert tasks.start(request, stepping(tasks, said, name)) is GIVEN_BACK
    tasks.ask_back(1)
    assert tasks.poll_seconds is None
    assert tasks.resume(1) is GIVEN_BACK
    assert tasks.resume(2) is ENDED  # nobody asked
    assert tasks.resume(1) is ENDED
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
    assert tasks.start(7, work) is ENDED
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
    assert tasks.start(1, holding("a", "it")) is GIVEN_BACK
    assert tasks.start(2, holding("b", "it")) is OPEN  # has to wait
    assert tasks.start(3, holding("c", "other")) is ENDED
    tasks.ask_back(2)
    assert tasks.ready() == 2
    assert tasks.resume(2) is GIVEN_BACK
    assert said == ["a0", "c0", "c1", "c2", "a1"]
    assert tasks.resume(2) is OPEN  # ends the first
    assert tasks.resume(2) is ENDED
    assert said[5:] == ["a2", "b0", "b1", "b2"]


def test_one_who_waited_goes_on_once_the_other_has_let_go_though_that_has_more_to_do() -> None:
    tasks, said = Tasks(), list[str]()

    def long(name: str) -> Callable[[], None]:
        def work() -> None:
            with tasks.holding("it"):
                stepping(tasks, said, f"{name} holds ", 2)()
            stepping(tasks, said, f"{name} goes on ", 3)()

        return work

    tasks.ask_back(1)
    assert tasks.start(1, long("a")) is GIVEN_BACK
    assert tasks.start(2, long("b")) is OPEN  # has to wait
    tasks.ask_back(2)
    assert tasks.resume(2) is GIVEN_BACK  # a's second step
    tasks.ask_back(1)
    assert tasks.resume(1) is GIVEN_BACK
    assert said == ["a holds 0", "a holds 1", "a goes on 0"]
    assert not tasks.waits(2)
    assert tasks.resume(2) is ENDED
    assert said[3:] == ["b holds 0", "b holds 1", "b goes on 0", "b goes on 1", "b goes on 2"]


def test_one_who_waits_can_be_cancelled_and_what_was_held_is_free_after_an_error() -> None:
    tasks, said = Tasks(), list[str]()

    def work() -> None:
        try:
            with tasks.holding("it"):
                stepping(tasks, said, "a")()
        except CancelledError:
            said.append("cancelled")

    tasks.ask_back(1)
    assert tasks.start(1, work) is GIVEN_BACK
    assert tasks.start(2, work) is OPEN
    tasks.cancel(1)
    assert tasks.resume(2) is OPEN
    assert tasks.resume(2) is ENDED
    assert said == ["a0", "cancelled", "a0", "a1", "a2"]
    tasks.cancel(99)  # there is none


def test_one_can_be_cancelled_before_it_begins() -> None:
    tasks, said = Tasks(), list[str]()
    tasks.cancel(2)
    assert tasks.start(1, stepping(tasks, said, "a")) is ENDED
    with pytest.raises(CancelledError):
        tasks.start(2, stepping(tasks, said, "b"))
    assert said == ["a0", "a1", "a2", "b0"]


def test_what_a_job_raises_reaches_whoever_gave_the_turn() -> None:
    tasks = Tasks()

    def work() -> None:
        raise ValueError("wrong")

    with pytest.raises(ValueError, match="wrong"):
        tasks.start(1, work)
    assert tasks.start(1, lambda: None) is ENDED


class Device:
    """What jobs launched, and what of it is over."""

    def __init__(self, tasks: Tasks) -> None:
        self._tasks = tasks
        self.over: set[str] = set()
        self.said: list[str] = []

    def frame(self, name: str, holds: str | None = None) -> Callable[[], None]:
        """A job that launches a frame, which needs what it `holds`."""

        def work() -> None:
            with self._tasks.holding(holds or name):
                self.said.append(f"{name} begins")
                self._tasks.leave_until(lambda: name in self.over)
                self.said.append(f"{name} ends")

        return work


def test_others_have_the_host_while_frames_are_on_the_device() -> None:
    tasks = Tasks()
    device = Device(tasks)
    assert [tasks.start(request, device.frame(name)) for request, name in ((1, "a"), (2, "b"))] == [OPEN, OPEN]
    assert tasks.ready() is None
    assert tasks.resume(1) is OPEN  # it is not over
    device.over.add("b")
    assert tasks.ready() == 2
    assert tasks.resume(2) is ENDED
    device.over |= {"a", "c"}
    assert tasks.start(3, device.frame("c")) is ENDED  # there is nothing to wait for
    assert tasks.resume(1) is ENDED
    assert tasks.poll_seconds is None
    assert device.said == ["a begins", "b begins", "b ends", "c begins", "c ends", "a ends"]


def test_one_who_needs_what_a_frame_on_the_device_has_waits_for_its_end_and_nobody_else_does() -> None:
    tasks = Tasks()
    device = Device(tasks)
    device.over.add("c")
    assert tasks.start(1, device.frame("a", "it")) is OPEN
    assert tasks.start(2, device.frame("b", "it")) is OPEN
    assert [tasks.waits(request) for request in (1, 2)] == [False, True]
    assert tasks.start(3, device.frame("c")) is ENDED
    assert tasks.ready() is None
    device.over |= {"a", "b"}
    assert tasks.ready() == 1
    assert tasks.resume(1) is ENDED
    assert tasks.ready() == 2
    assert tasks.resume(2) is ENDED


def test_a_frame_on_the_device_is_finished_though_it_is_asked_back_or_cancelled() -> None:
    tasks = Tasks()
    device = Device(tasks)
    assert tasks.start(1, device.frame("a")) is OPEN
    tasks.ask_back(1)
    tasks.cancel(1)
    assert tasks.ready() is None
    device.over.add("a")
    assert tasks.resume(1) is ENDED
    assert device.said == ["a begins", "a ends"]


def test_long_work_leaves_the_host_to_frames_that_are_over_and_to_who_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("server.worker.tasks.perf_counter", lambda: now[0])
    tasks, said, comes = Tasks(turn_seconds=1.0), list[str](), [False]
    tasks.others_wait = lambda: comes[0]
    device = Device(tasks)

    def slices() -> None:
        for number in range(4):
            said.append(f"slice {number}")
            now[0] += 2.0 * STINT_SECONDS if number else 0.5 * STINT_SECONDS
            comes[0] = number == 2
            if tasks.due():
                tasks.give()

    assert tasks.start(1, device.frame("a")) is OPEN
    device.over.add("a")
    assert tasks.start(2, slices) is OPEN
    assert said == ["slice 0", "slice 1"]  # it has its time first
    assert tasks.ready() == 1
    assert tasks.resume(1) is ENDED
    assert tasks.ready() == 2
    assert tasks.resume(2) is OPEN
    assert said[2:] == ["slice 2"]
    assert tasks.resume(2) is ENDED


def test_open_turns_go_on_in_turn() -> None:
    tasks, said = Tasks(), list[int]()
    tasks.others_wait = lambda: True
    for request in (1, 2):
        tasks.start(request, partial(leaving, tasks, said, request))
    while (request := tasks.ready()) is not None:
        tasks.resume(request)
    assert said == [1, 2, 1, 2, 1, 2]


def leaving(tasks: Tasks, said: list[int], name: int) -> None:
    """A job that leaves the host twice."""
    for _ in range(2):
        said.append(name)
        tasks.leave_until(chain((False,), repeat(True)).__next__)
    said.append(name)


def test_one_who_waits_for_no_device_gives_its_turn_back_when_asked_or_cancelled() -> None:
    tasks, over, said = Tasks(turn_seconds=60.0), [False], list[str]()

    def work() -> None:
        while not over[0]:
            tasks.leave_until(lambda: over[0], idle=True)
            said.append("looks")
            if tasks.due(idle=True):
                tasks.give()

    assert tasks.start(1, work) is OPEN
    assert tasks.start(2, partial(leaving, tasks, [], 2)) is OPEN
    assert tasks.poll_seconds == POLL_SECONDS
    while tasks.ready() is not None:
        tasks.resume(2)
    assert (tasks.poll_seconds, tasks.ready(), said) == (IDLE_POLL_SECONDS, None, [])
    tasks.ask_back(1)
    assert tasks.ready() == 1
    assert tasks.resume(1) is GIVEN_BACK
    assert tasks.resume(1) is OPEN
    assert tasks.ready() is None
    tasks.cancel(1)
    assert tasks.ready() == 1
    with pytest.raises(CancelledError):
        tasks.resume(1)
    assert said == ["looks", "looks"]
