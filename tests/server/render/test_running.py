from heapq import heappop, heappush

from server.render.running import (
    SHORT_TURN_SECONDS,
    WHOLE_FRAME_SECONDS,
    WHOLE_FRAME_SECONDS_ON_CUDA,
    RunningTurn,
    RunningTurns,
)
from server.render.schedule import QueueEntry, Schedule, Urgency
from server.wire.worker import HEARTBEAT, STILLS, CloseScene, SceneRef

MOVING, STILL, REFINING = Urgency
JOB = CloseScene(SceneRef("", ""))


def entry(client: int, urgency: Urgency = MOVING) -> QueueEntry:
    return QueueEntry(client, urgency, 0.0)


def turns(lanes: int, *entries: QueueEntry) -> RunningTurns:
    running = RunningTurns()
    running.lanes = lanes
    for number, it in enumerate(entries, 1):
        running.begin(RunningTurn(number, it, JOB, began=float(number), patience=10.0 * number))
    return running


def asked(running: RunningTurns, *waiting: QueueEntry) -> list[int]:
    """The clients that are to give their turns back."""
    return [turn.entry.client for turn in running.to_ask_back(waiting)]


def test_there_are_as_many_at_once_as_lanes() -> None:
    assert turns(1).admit(entry(1))
    assert not turns(1, entry(1)).admit(entry(2))
    running = turns(2, entry(1))
    assert running.admit(entry(2))
    assert running.admit(entry(STILLS, STILL))
    running.begin(RunningTurn(2, entry(2), JOB, 0.0, 1.0))
    assert not running.admit(entry(3))
    running.end(next(iter(running)))
    assert running.admit(entry(3))
    assert len(running) == 1


def test_one_is_alone_where_that_is_wanted() -> None:
    running = turns(3)
    running.alone = True
    assert running.admit(entry(1))
    running = turns(3, entry(1), entry(2))
    running.alone = True
    assert running.full
    assert not running.admit(entry(3))


def test_a_client_has_one_at_a_time() -> None:
    running = turns(3, entry(1), entry(STILLS, STILL))
    assert not running.admit(entry(1, STILL))
    assert not running.admit(entry(STILLS, STILL))
    assert running.admit(entry(2))


def test_nothing_refines_beside_what_is_more_urgent() -> None:
    assert not turns(3, entry(1)).admit(entry(2, REFINING))
    assert turns(3, entry(1, REFINING)).admit(entry(2, REFINING))
    running = turns(3, entry(1, REFINING), entry(2))
    assert asked(running) == [1]
    next(iter(running)).asked_back = True
    assert asked(running) == []


def test_turns_are_asked_back_for_whom_there_is_no_room() -> None:
    assert asked(turns(3, entry(1), entry(2)), entry(3)) == []
    running = turns(2, entry(1), entry(2))
    assert asked(running, entry(1)) == [2]  # its own come one after the other
    assert asked(running, entry(3)) == [1, 2]
    assert asked(running, entry(3, REFINING)) == []
    assert asked(running, entry(STILLS, STILL)) == [1, 2]
    assert asked(turns(2, entry(STILLS, STILL)), entry(STILLS, STILL)) == [STILLS]


def test_short_turns_and_frames_of_those_who_move_may_end_first() -> None:
    still, moving = turns(2, entry(STILLS, STILL), entry(1))
    assert still.free_at(cuda=False) == still.free_at(cuda=True) == 1.0 + SHORT_TURN_SECONDS
    assert moving.free_at(cuda=False) == 2.0 + WHOLE_FRAME_SECONDS
    assert moving.free_at(cuda=True) == 2.0 + WHOLE_FRAME_SECONDS_ON_CUDA


def test_the_first_and_the_most_patient_of_them_count() -> None:
    running = turns(3, entry(1), entry(HEARTBEAT, REFINING))
    assert (running.began, running.patience) == (1.0, 20.0)
    assert [turn.is_heartbeat for turn in running] == [False, True]
    assert (turns(3).began, turns(3).patience, turns(3).get(1)) == (None, 0.0, None)
    assert running.get(2) is [*running][1]


def test_lanes_are_shared_fairly_whatever_turns_cost() -> None:
    """Nine clients on eight lanes, one of whom has long turns; each wants the next at once."""
    schedule, running, now = Schedule(lambda: 0.0), turns(8), 0.0
    costs = dict.fromkeys(range(1, 9), 0.01) | {9: 0.1}
    used = dict.fromkeys(costs, 0.0)
    for client in costs:
        schedule.join(client, MOVING)
    request, ends = 0, list[tuple[float, int]]()
    while now < 20.0:
        while (it := schedule.next(running.admit)) is not None:
            request += 1
            running.begin(RunningTurn(request, it, JOB, now, 1.0))
            heappush(ends, (now + costs[it.client], request))
        now, ended = heappop(ends)
        turn = running.get(ended)
        assert turn is not None
        running.end(turn)
        client = turn.entry.client
        schedule.charge(turn.entry, costs[client])
        used[client] += costs[client]
        schedule.join(client, MOVING)
    assert min(used.values()) > 0.9 * sum(used.values()) / len(used)
