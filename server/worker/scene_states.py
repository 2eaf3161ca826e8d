"""Scenes with edits that are on the device besides the scenes themselves, few of each, for many who look.

Whoever has new edits mostly has the state before them changed in its arrays, so that all that renderers have made of it
goes on. What others still look at stays as it is.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from gpu.scene.edits import SceneEdits
from server.wire.worker import SceneRef
from server.worker.loaded_scene import LoadedScene

# Of a scene that is edited, besides that of its file: what one viewer changes, and what another does or a job goes on
# with. Frames under way may need more for as long as they take.
MOST_STATES = 2
# A scene with these edits, made of a state that nobody needs any more if there is one that can become it.
EVERYONE = None  # in place of a viewer whose states they are
MakeState = Callable[[LoadedScene | None], LoadedScene]


@dataclass
class _State:
    """A scene with edits; users: who looked at it last, by viewer; frames: that are under way."""

    loaded: LoadedScene
    users: set[int] = field(default_factory=set)
    frames: int = 0


class SceneStates:
    """The states of scenes; dropped(state) is called for each that goes."""

    def __init__(self, dropped: Callable[[LoadedScene], None]) -> None:
        self._dropped = dropped
        # By whose they are, in the order of their last use.
        self._states: dict[tuple[SceneRef, int | None], list[_State]] = {}

    @contextmanager
    def using(
        self, ref: SceneRef, edits: SceneEdits, viewer: int, make: MakeState, *, own: bool = False
    ) -> Iterator[LoadedScene]:
        """A scene with `edits` for a frame of a viewer, which no other frame changes meanwhile.

        own: nobody else sees them, so that it has states of its own, which go once it sees what others see.
        """
        if not own:
            self._close(ref, viewer)
        states = self._states.setdefault((ref, viewer if own else EVERYONE), [])
        for other in states:
            other.users.discard(viewer)
        state = next((one for one in states if one.loaded.edits == edits), None) or self._made(states, viewer, make)
        states[:] = [*(one for one in states if one is not state), state]
        state.users.add(viewer)
        state.frames += 1
        try:
            yield state.loaded
        finally:
            state.frames -= 1
            self._trim(states)

    def _trim(self, states: list[_State]) -> None:
        """Free those beyond MOST_STATES that no frame is under way of."""
        for idle in [one for one in states if one.frames == 0][: max(len(states) - MOST_STATES, 0)]:
            states.remove(idle)
            self._dropped(idle.loaded)

    def _made(self, states: list[_State], viewer: int, make: MakeState) -> _State:
        idle = [one for one in states if one.frames == 0]
        gives_way = next((one for one in idle if not one.users), None)
        if gives_way is None and len(states) >= MOST_STATES and idle:
            gives_way = idle[0]
        if gives_way is None:
            return _State(make(None))
        states.remove(gives_way)  # what it is after an error is not known
        before = gives_way.loaded
        loaded = None
        try:
            loaded = make(before)
        finally:
            if loaded is not before:
                self._dropped(before)
        return _State(loaded)

    def renew(self, ref: SceneRef, stale: Callable[[LoadedScene], bool]) -> None:
        """Free those of a scene that are stale and that no frame is under way of, so that they are made anew.

        While `stale` finds out, others may free some, and states of other scenes come and go.
        """
        of_scene = [states for (scene, _), states in self._states.items() if scene == ref]
        for states in of_scene:
            for state in [one for one in states if one.frames == 0]:
                if stale(state.loaded) and state in states:
                    states.remove(state)
                    self._dropped(state.loaded)

    def leave(self, viewer: int) -> None:
        """Have a viewer look at none, and free its own."""
        for ref, owner in [*self._states]:
            if owner == viewer:
                self._close(ref, owner)
        for states in self._states.values():
            for state in states:
                state.users.discard(viewer)

    def close(self, ref: SceneRef) -> None:
        """Free those of a scene."""
        for scene, owner in [*self._states]:
            if scene == ref:
                self._close(ref, owner)

    def _close(self, ref: SceneRef, owner: int | None) -> None:
        states = self._states.pop((ref, owner), [])
        while states:
            self._dropped(states.pop().loaded)

    def clear(self) -> None:
        """Free all of them."""
        for ref, owner in [*self._states]:
            self._close(ref, owner)

    def __len__(self) -> int:
        return sum(map(len, self._states.values()))
