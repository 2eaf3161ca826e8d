from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import partial
from os import cpu_count
from threading import Event, current_thread

import pytest

from gpu.core.sharing import DeviceSharing

CORES = cpu_count() or 1


class Count:
    """Turns that are always due, and what happens in those of others."""

    def __init__(self, sharing: DeviceSharing) -> None:
        self._sharing = sharing
        self.given = self.in_flight = 0
        self.held: list[Hashable] = []

    def due(self, *, idle: bool = False) -> bool:
        return True

    def give(self) -> None:
        self.given += 1
        if self.given == 1:  # somebody else's turn, who gives it away, too
            self._sharing.pause()

    def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
        self.in_flight = self._sharing.in_flight
        while not over():
            pass

    @contextmanager
    def holding(self, what: Hashable) -> Iterator[None]:
        self.held.append(what)
        self._sharing.pause()  # what another one holds, whose work goes on first
        yield
        self.held.remove(what)


def test_nobody_is_asked_alone() -> None:
    sharing = DeviceSharing()
    assert not sharing.active
    assert not sharing.due
    sharing.pause()


def test_the_device_is_given_away_where_that_is_due_and_kept_where_it_must_be() -> None:
    sharing = DeviceSharing()
    turns = Count(sharing)
    sharing.begin(turns)
    with sharing.keep():
        assert not sharing.active
        assert not sharing.due
        sharing.pause()
    assert turns.given == 0
    assert sharing.active
    sharing.pause()
    assert turns.given == 2
    sharing.begin(None)
    assert not sharing.active


def test_own_time_stands_still_in_turns_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("gpu.core.sharing.perf_counter", lambda: now[0])
    sharing = DeviceSharing()

    class Nested:
        def due(self, *, idle: bool = False) -> bool:
            return True

        def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
            pass

        def give(self) -> None:
            begun = sharing.own_time()
            now[0] += 5.0
            if now[0] < 20.0:
                sharing.pause()
            assert sharing.own_time() - begun == 5.0  # whoever has the turn counts what is its own

    sharing.begin(Nested())
    begun = sharing.own_time()
    now[0] += 1.0
    sharing.pause()
    assert now[0] > 20.0
    assert sharing.own_time() - begun == 1.0


def test_work_beside_the_device_lets_others_have_it_until_it_is_done() -> None:
    sharing, given = DeviceSharing(), Event()

    class Idle:
        def due(self, *, idle: bool = False) -> bool:
            return idle

        def give(self) -> None:
            given.set()

        def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
            pass

    assert sharing.beside(current_thread) is current_thread()  # nobody else wants it
    sharing.begin(Idle())
    assert sharing.beside(lambda: given.wait(60.0))
    assert sharing.beside(current_thread) is not current_thread()
    with sharing.keep():
        assert sharing.beside(current_thread) is current_thread()
    with pytest.raises(ZeroDivisionError):
        sharing.beside(lambda: 1 // 0)


def test_one_who_is_interrupted_leaves_what_is_done_beside_the_device_to_end_by_itself() -> None:
    sharing, over = DeviceSharing(), Event()
    begun, ended = list[int](), list[int]()

    class Interrupting(Count):
        def give(self) -> None:
            raise InterruptedError

        def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
            pass

    def work(number: int) -> None:
        begun.append(number)
        over.wait(10.0)
        ended.append(number)

    sharing.begin(Interrupting(sharing))
    try:
        for number in range(2 * CORES):
            with pytest.raises(InterruptedError):
                sharing.beside(partial(work, number))
        assert ended == []
        assert len(begun) <= CORES  # so there is an end to what is left
    finally:
        over.set()


def test_one_has_what_another_holds_once_that_has_had_its_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("gpu.core.sharing.perf_counter", lambda: now[0])
    sharing = DeviceSharing()
    turns = Count(sharing)
    with sharing.holding("it"):  # alone
        assert turns.held == []
    sharing.begin(turns)
    monkeypatch.setattr(turns, "give", lambda: now.append(now.pop() + 5.0))
    with sharing.holding("it"):
        assert turns.held == ["it"]
        assert (now[0], sharing.own_time()) == (5.0, 0.0)
    assert turns.held == []


def test_others_have_the_host_until_what_was_launched_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("gpu.core.sharing.perf_counter", lambda: now[0])
    sharing, looks = DeviceSharing(), list[int]()

    def is_over() -> bool:
        looks.append(len(looks))
        now[0] += 1.0
        if len(looks) == 1:
            sharing.pause()  # another one's, which is away for a while
        return len(looks) == 3

    sharing.leave_until(is_over)  # alone, nobody looks
    turns = Count(sharing)
    sharing.begin(turns)
    with sharing.keep():
        sharing.leave_until(is_over)
    assert turns.in_flight == len(looks) == 0
    sharing.leave_until(is_over)
    assert (len(looks), turns.in_flight, sharing.in_flight) == (3, 1, 0)
    assert sharing.own_time() == 3.0


def test_a_failure_on_the_device_leaves_nothing_in_flight() -> None:
    sharing = DeviceSharing()
    sharing.begin(Count(sharing))
    with pytest.raises(ZeroDivisionError):
        sharing.leave_until(lambda: bool(1 // 0))
    assert sharing.in_flight == 0
