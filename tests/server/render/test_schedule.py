from collections import Counter

from server.render.schedule import PATIENCE_SECONDS, QueueEntry, Schedule, Urgency

MOVING, STILL, REFINING = Urgency


class Clock:
    def __init__(self) -> None:
        self.seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


def scheduled(clock: Clock | None = None) -> Schedule:
    return Schedule(clock or Clock())


def turn(schedule: Schedule) -> QueueEntry:
    entry = schedule.next()
    assert entry is not None
    return entry


def compete(schedule: Schedule, costs: dict[int, float], seconds: float) -> Counter[int]:
    """Device time that each client gets when all want more all the time and a turn of theirs costs that much."""
    used: Counter[float] = Counter()
    for client in costs:
        schedule.join(client, MOVING)
    while used.total() < seconds:
        entry = turn(schedule)
        schedule.join(entry.client, MOVING)  # the next one is wanted already
        used[entry.client] += costs[entry.client]
        schedule.charge(entry, costs[entry.client])
    return used


def test_nobody_waits() -> None:
    assert scheduled().next() is None


def test_the_most_urgent_goes_first() -> None:
    schedule = scheduled()
    for client, urgency in enumerate((REFINING, STILL, MOVING)):
        schedule.join(client, urgency)
    assert [turn(schedule).urgency for _ in range(3)] == [MOVING, STILL, REFINING]


def test_first_come_first_served_among_equals() -> None:
    schedule = scheduled()
    for client in (3, 1, 2):
        schedule.join(client, MOVING)
    assert [turn(schedule).client for _ in range(3)] == [3, 1, 2]


def test_device_time_is_shared_not_turns() -> None:
    used = compete(scheduled(), {1: 0.1, 2: 0.01, 3: 0.02}, seconds=30.0)
    assert max(used.values()) - min(used.values()) < 0.3


def test_idleness_earns_no_credit() -> None:
    schedule = scheduled()
    compete(schedule, {1: 0.1, 2: 0.1}, seconds=100.0)  # while 3 is away
    used: Counter[int] = Counter()
    schedule.join(3, MOVING)
    for _ in range(60):
        entry = turn(schedule)
        used[entry.client] += 1
        schedule.join(entry.client, MOVING)
        schedule.charge(entry, 0.1)
    assert max(used.values()) - min(used.values()) <= 1


def test_what_was_used_while_alone_is_not_held_against_one() -> None:
    schedule = scheduled()
    for _ in range(100):
        schedule.join(1, MOVING)
        schedule.charge(turn(schedule), 1.0)
    schedule.join(1, MOVING)
    schedule.join(2, MOVING)
    assert [turn(schedule).client for _ in range(2)] == [1, 2]


def test_a_turn_given_away_costs_nothing() -> None:
    schedule = scheduled()
    schedule.join(1, MOVING)
    turn(schedule)
    for client in (1, 2):
        schedule.join(client, MOVING)
    assert turn(schedule).client == 1


def test_one_who_leaves_has_no_turn() -> None:
    schedule = scheduled()
    first, second = schedule.join(1, MOVING), schedule.join(1, MOVING)
    schedule.leave(first)
    assert turn(schedule) is second
    schedule.leave(second)  # too late, and harmless
    assert schedule.next() is None


def test_stills_are_not_kept_out_for_ever_by_those_who_walk() -> None:
    clock = Clock()
    schedule = scheduled(clock)
    schedule.join(0, STILL)
    schedule.join(1, MOVING)
    assert turn(schedule).urgency is MOVING
    clock.seconds += PATIENCE_SECONDS
    schedule.join(1, MOVING)
    assert turn(schedule).urgency is STILL


def test_clients_that_left_are_forgotten() -> None:
    schedule = scheduled()
    schedule.join(0, MOVING)  # somebody always waits
    for client in range(1, 1000):
        schedule.join(client, MOVING)
        entry = turn(schedule)
        if entry.client == 0:
            schedule.join(0, MOVING)
        schedule.charge(entry, 0.01)
    while schedule.next() is not None:
        pass
    assert sum(len(queue.starts) for queue in schedule._queues.values()) <= 2


def test_stills_do_not_keep_those_out_who_walk() -> None:
    clock = Clock()
    schedule = scheduled(clock)
    for _ in range(20):
        schedule.join(0, STILL)
    clock.seconds += PATIENCE_SECONDS
    turns: Counter[int] = Counter()
    for _ in range(10):
        schedule.join(1, MOVING)
        entry = turn(schedule)
        turns[entry.urgency] += 1
        clock.seconds += PATIENCE_SECONDS / 2
    assert turns == {MOVING: 5, STILL: 5}


def test_the_rest_of_a_turn_comes_before_what_the_client_wants_next() -> None:
    schedule = Schedule(lambda: 0.0)
    first = schedule.join(1, Urgency.MOVING)
    second = schedule.join(1, Urgency.MOVING)
    assert schedule.next() is first
    schedule.charge(first, 0.0)
    schedule.rejoin(first)
    assert [schedule.next(), schedule.next()] == [first, second]


def test_the_rest_of_a_turn_waits_for_others_who_used_less() -> None:
    schedule = Schedule(lambda: 0.0)
    first, other = schedule.join(1, Urgency.MOVING), schedule.join(2, Urgency.MOVING)
    assert schedule.next() is first
    schedule.charge(first, 1.0)
    schedule.rejoin(first)
    assert [schedule.next(), schedule.next()] == [other, first]


def test_those_who_may_have_no_turn_now_are_passed_over_and_stay() -> None:
    clock = Clock()
    schedule = scheduled(clock)
    for client, urgency in ((1, MOVING), (2, MOVING), (0, STILL)):
        schedule.join(client, urgency)
    assert schedule.next(lambda entry: False) is None
    entry = schedule.next(lambda entry: entry.client != 1)
    assert entry is not None
    assert entry.client == 2
    clock.seconds += PATIENCE_SECONDS
    entry = schedule.next(lambda entry: entry.client != 0)  # though the still has waited long
    assert entry is not None
    assert entry.client == 1
    assert turn(schedule).client == 0
