from collections.abc import Callable
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any, cast

import pytest

from gpu.scene.edits import LightEdit, SceneEdits
from server.wire.worker import SceneRef
from server.worker.loaded_scene import LoadedScene
from server.worker.scene_states import MOST_STATES, SceneStates

BOX = SceneRef("box", "cornell-box")


def edits_of(number: int) -> SceneEdits:
    return SceneEdits(lights={"light": LightEdit(intensity=float(number))})


class Shown:
    """States in use, and what was made new, changed and dropped; of scenes that only know their edits."""

    def __init__(self) -> None:
        self.made, self.changed, self.dropped = 0, 0, 0
        self.states = SceneStates(self._drop)

    def _drop(self, state: LoadedScene) -> None:
        self.dropped += 1

    def _make(self, edits: SceneEdits, *, fits: bool) -> Callable[[LoadedScene | None], LoadedScene]:
        def make(before: LoadedScene | None) -> LoadedScene:
            if before is None or not fits:
                self.made += 1
                return cast("LoadedScene", SimpleNamespace(edits=edits))
            self.changed += 1
            before.edits = edits
            return before

        return make

    def using(self, viewer: int, number: int, *, fits: bool = True, own: bool = False) -> Any:
        edits = edits_of(number)
        return self.states.using(BOX, edits, viewer, self._make(edits, fits=fits), own=own)

    def show(self, viewer: int, number: int, *, fits: bool = True, own: bool = False) -> LoadedScene:
        with self.using(viewer, number, fits=fits, own=own) as state:
            assert state.edits == edits_of(number)
        return cast("LoadedScene", state)


@pytest.fixture
def shown() -> Shown:
    return Shown()


def test_stale_states_are_made_anew_once_no_frame_is_under_way(shown: Shown) -> None:
    kept, stale = shown.show(1, 1), shown.show(2, 2)
    with shown.using(2, 2):
        shown.states.renew(BOX, lambda state: state is stale)
        assert shown.dropped == 0
    shown.states.renew(SceneRef("other", "cornell-box"), lambda state: True)
    shown.states.renew(BOX, lambda state: state is stale)
    assert shown.dropped == 1
    assert shown.show(1, 1) is kept
    assert shown.show(2, 2) is not stale


def test_what_one_viewer_edits_goes_on_in_its_arrays(shown: Shown) -> None:
    assert len({id(shown.show(1, number)) for number in range(5)}) == 1
    assert (shown.made, shown.changed, len(shown.states)) == (1, 4, 1)


def test_two_with_edits_of_their_own_do_not_disturb_each_other(shown: Shown) -> None:
    first, second = shown.show(1, 0), shown.show(2, 100)
    for number in range(1, 4):
        assert shown.show(1, number) is first
        assert shown.show(1, number) is first
        assert shown.show(2, 100 + number) is second
    assert shown.made == len(shown.states) == 2


def test_states_come_and_go_while_kernels_of_a_stale_one_are_loaded(shown: Shown) -> None:
    stale = shown.show(1, 1, own=True)

    def loads(state: LoadedScene) -> bool:
        shown.show(2, 2, own=True)
        shown.states.leave(1)
        return state is stale

    shown.states.renew(BOX, loads)
    assert (shown.dropped, len(shown.states)) == (1, 1)


def test_those_who_see_the_same_edits_take_turns_of_two_states(shown: Shown) -> None:
    for number in range(6):
        assert shown.show(1, number) is shown.show(2, number)
    assert shown.made == len(shown.states) == 2


def test_the_state_used_longest_ago_gives_way(shown: Shown) -> None:
    for viewer in range(MOST_STATES + 2):
        shown.show(viewer, viewer)
    assert len(shown.states) == MOST_STATES
    assert (shown.made, shown.changed) == (MOST_STATES, 2)


def test_a_state_that_cannot_become_another_is_dropped(shown: Shown) -> None:
    first = shown.show(1, 0)
    assert shown.show(1, 1, fits=False) is not first
    assert (shown.dropped, len(shown.states)) == (1, 1)


def test_one_whose_change_fails_is_dropped(shown: Shown) -> None:
    def fail(before: LoadedScene | None) -> LoadedScene:
        raise RuntimeError("no memory")

    shown.show(1, 0)
    with pytest.raises(RuntimeError, match="no memory"), shown.states.using(BOX, edits_of(1), 1, fail):
        pass
    assert (shown.dropped, len(shown.states)) == (1, 0)


def test_a_frame_under_way_keeps_its_state_as_it_is(shown: Shown) -> None:
    with ExitStack() as frames:
        under_way = [frames.enter_context(shown.using(1, number)) for number in range(MOST_STATES + 1)]
        assert [state.edits for state in under_way] == [*map(edits_of, range(MOST_STATES + 1))]
    assert (shown.changed, shown.dropped, len(shown.states)) == (0, 1, MOST_STATES)


def test_what_a_viewer_leaves_is_free_for_others(shown: Shown) -> None:
    first = shown.show(1, 0)
    shown.states.leave(1)
    assert shown.show(2, 1) is first


def test_closed_scenes_leave_nothing(shown: Shown) -> None:
    shown.show(1, 0)
    shown.states.close(SceneRef("other", "cornell-box"))
    assert len(shown.states) == 1
    shown.show(2, 1)
    shown.states.clear()
    assert (shown.dropped, len(shown.states)) == (2, 0)


def test_each_viewer_with_edits_of_its_own_has_a_state_that_goes_with_them(shown: Shown) -> None:
    viewers = range(1, 6)
    states = [shown.show(viewer, 100 * viewer, own=True) for viewer in viewers]
    for viewer, state in zip(viewers, states, strict=True):
        assert shown.show(viewer, 100 * viewer + 1, own=True) is state
    assert (shown.made, shown.dropped, len(shown.states)) == (5, 0, 5)
    assert shown.show(1, 301) is not states[2]
    shown.states.leave(2)
    assert (shown.dropped, len(shown.states)) == (2, 4)
