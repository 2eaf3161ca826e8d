from server.render.activity import EngineState
from server.render.placement import LOADING, LOADING_SECONDS, Candidate, choose, still_loading

READY, RECOVERING, FAILED = EngineState.READY, EngineState.RECOVERING, EngineState.FAILED


def at(
    clients: int = 0,
    *,
    state: EngineState = READY,
    holds: bool = True,
    room: bool = True,
    loads: bool = False,
    busy: float = 0.0,
) -> Candidate:
    return Candidate(state, holds, room, loads, clients, busy)


def test_who_comes_goes_where_fewest_are_and_then_where_the_device_is_free() -> None:
    assert choose([at(3), at(2), at(4)]) == 1
    assert choose([at(2, busy=0.9), at(2, busy=0.1)]) == 1
    assert choose([at(), at()]) == 0


def test_a_scene_is_where_it_was_loaded_until_that_is_crowded() -> None:
    most = int(LOADING)
    assert choose([at(0, holds=False), at(most - 1)]) == 1
    assert choose([at(0, holds=False), at(most)]) == 1
    assert choose([at(0, holds=False), at(most + 1)]) == 0


def test_where_there_is_no_room_nothing_is_loaded() -> None:
    full = at(0, holds=False, room=False)
    assert choose([full, at(40)]) == 1
    assert choose([full, at(3, holds=False)]) == 1
    assert choose([full, at(7, holds=False, room=False)]) == 0  # which says so


def test_what_loads_another_scene_is_spared_where_that_can_be() -> None:
    loading = at(0, holds=False, loads=True)
    assert choose([loading, at(40)]) == 1
    assert choose([loading, at(40, holds=False)]) == 1
    assert choose([loading, at(40, holds=False, room=False)]) == 0
    assert choose([at(0, loads=True), at(9)]) == 0  # it has this one, or loads it
    assert choose([loading, at(60)], own=1, walks=True) == 1


def test_a_load_is_given_up_after_a_while() -> None:
    sent = {"hall": 0.0, "attic": 9.0, "box": 9.0}
    assert still_loading(sent, ["box"], LOADING_SECONDS - 1.0) == {"hall": 0.0, "attic": 9.0}
    assert still_loading(sent, ["box"], LOADING_SECONDS) == {"attic": 9.0}


def test_who_is_somewhere_stays_there() -> None:
    assert choose([at(0), at(40)], own=1) == 1
    assert choose([at(0), at(0, holds=False, room=False)], own=1) == 1  # started again: it is read there anew


def test_a_walker_leaves_what_is_far_more_crowded() -> None:
    assert choose([at(0), at(1)], own=1, walks=True) == 0  # two are one each then
    assert choose([at(0), at(0)], own=1, walks=True) == 1
    assert choose([at(8), at(10)], own=1, walks=True) == 1
    assert choose([at(8), at(11)], own=1, walks=True) == 0
    assert choose([at(0, holds=False), at(5)], own=1, walks=True) == 1
    assert choose([at(0, holds=False), at(6)], own=1, walks=True) == 0
    assert choose([at(0, holds=False, room=False), at(60)], own=1, walks=True) == 1


def test_who_has_lost_an_engine_goes_to_another_with_room() -> None:
    lost = at(state=RECOVERING, holds=False)
    assert choose([lost, at(9), at(8)], own=0) == 2
    assert choose([lost, at(9, holds=False)], own=0) == 1
    assert choose([lost, at(9, holds=False, room=False)], own=0) == 0  # and waits


def test_an_engine_that_has_failed_is_nobodys() -> None:
    failed = at(state=FAILED, holds=False)
    assert choose([failed, at(9, holds=False, room=False)], own=0) == 1
    assert choose([failed, at(state=RECOVERING)]) == 1
    assert choose([failed, failed], own=1) == 0


def test_before_any_is_ready_clients_are_shared_out_all_the_same() -> None:
    starting = EngineState.STARTING
    assert choose([at(1, state=starting, holds=False), at(0, state=starting, holds=False)]) == 1
