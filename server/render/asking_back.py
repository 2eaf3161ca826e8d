"""When turns are asked back that others wait for."""

import asyncio
from collections.abc import Callable, Iterable
from math import inf
from time import monotonic

from server.render.running import RunningTurn, RunningTurns
from server.render.schedule import QueueEntry
from server.render.standing import Standing


class AskingBack:
    """Looks at turns when others come to wait, and again when a turn is no short one any more."""

    def __init__(
        self,
        running: RunningTurns,
        waiting: Callable[[], Iterable[QueueEntry]],
        ask: Callable[[RunningTurn], None],
        standing: Standing,
    ) -> None:
        """waiting: those who wait for a turn; ask: asks one back; standing: of the engine whose turns they are."""
        self._running, self._waiting, self._ask, self._standing = running, waiting, ask, standing
        self._later: asyncio.Handle | None = None
        self._later_at = inf  # and when [s]; handles of loops other than asyncio's own do not tell
        self._all_short_until = inf  # before which no turn that was not asked back can be [s]

    def begun(self, turn: RunningTurn) -> None:
        """A turn has begun."""
        free = turn.free_at(cuda=self._standing.cuda)
        self._all_short_until = min(self._all_short_until, free)
        self._look_again_at(free)
        self.look()

    def look(self) -> None:
        """Ask turns back that others wait for, but for short ones: who waits for those is seen when they are so no
        more, by when most have ended.
        """
        cuda, now = self._standing.cuda, monotonic()
        if now < self._all_short_until:
            return
        due = min((turn.free_at(cuda=cuda) for turn in self._running if not turn.asked_back), default=inf)
        self._all_short_until = due
        if due <= now:
            wanted = self._running.to_ask_back(self._waiting())
            for turn in wanted:
                if turn.free_at(cuda=cuda) <= now:
                    self._ask(turn)
            due = min((turn.free_at(cuda=cuda) for turn in wanted if not turn.asked_back), default=inf)
        self._look_again_at(due)

    def _look_again_at(self, due: float) -> None:
        """See at that time [s], or before, which turns are to be asked back."""
        if due < self._later_at:
            if self._later is not None:
                self._later.cancel()
            self._later_at, self._later = due, asyncio.get_running_loop().call_at(due, self._look_again)

    def _look_again(self) -> None:
        self._later_at, self._later = inf, None
        self.look()
