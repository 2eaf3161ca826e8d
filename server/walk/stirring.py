"""What a viewer's task waits for: looked at whenever something stirs, so that the task is woken once, when it is so."""

import asyncio
from collections.abc import Callable


class Stirring:
    """Lets one task wait until a condition holds, without a turn of its own for all that happens meanwhile.

    again: the seconds after which to look without anything stirring; 0: not at all.
    """

    def __init__(self, again: Callable[[], float]) -> None:
        self._again = again
        self._condition: Callable[[], bool] = lambda: False
        self._woken: asyncio.Future[None] | None = None
        self._timer: asyncio.TimerHandle | None = None

    async def until(self, condition: Callable[[], bool]) -> None:
        """Wait until it holds."""
        while not condition():  # it may have changed again before this task's turn
            self._condition, self._woken = condition, asyncio.get_running_loop().create_future()
            self._look_later()
            try:
                await self._woken
            finally:
                self._woken = None

    def stir(self) -> None:
        """Something has changed that the condition may depend on."""
        if self._woken is None or self._woken.done():
            return
        if self._condition():
            self._woken.set_result(None)
        else:
            self._look_later()

    def _look_later(self) -> None:
        if self._timer is None and (seconds := self._again()) > 0.0:
            self._timer = asyncio.get_running_loop().call_later(seconds, self._look)

    def _look(self) -> None:
        self._timer = None
        self.stir()
