"""Ends a worker that says nothing for too long, and has an idle one show that it lives."""

import asyncio
import logging
from time import monotonic

from server.render.jobs_under_way import JobsUnderWay
from server.render.worker_link import WorkerLink

FIRST_WORD_SECONDS = 60.0  # until a worker says its first word: it has to import what takes messages
START_SECONDS = 600.0  # that a worker may say nothing after that: it imports what renders, and may compile all of it
OVERDUE_SECONDS = 5.0  # without a word, after which a turn takes too long for others
TURN_SECONDS = 30.0  # after which it does so in any case
HEARTBEAT_SECONDS = 5.0  # between two words from a worker without a job
MOST_TURN_SECONDS = 300.0  # of a turn, whatever it says, unless it may be silent for longer: others wait for it
LONG_TURN_SECONDS = 1.0  # after which a turn is asked back, whoever waits: so the worker says that it lives
WATCH_SECONDS = 0.2  # between two looks at how long a worker has been silent
log = logging.getLogger("lumenwalk.engine")


class Watch:
    """Over one worker, from its start on."""

    def __init__(self, link: WorkerLink, jobs: JobsUnderWay) -> None:
        self._link, self._jobs = link, jobs
        self._last_heard = monotonic()  # when the worker last said something, or was told to start [s]
        self._spoken = False  # the worker has said something
        self.hung = False  # the worker was killed because it said nothing

    def heard(self) -> None:
        """The worker has said something."""
        self._last_heard, self._spoken = monotonic(), True

    @property
    def overdue(self) -> str:
        """What keeps the worker from others for too long, in words, if anything does."""
        began, now = self._jobs.running.began, monotonic()
        if self._jobs.taken and began is None:
            return ""
        turn = now - began if began is not None else 0.0
        silence = now - max(self._last_heard, began or 0.0)
        if silence > OVERDUE_SECONDS:
            return f"the renderer has said nothing for {silence:.0f} s"
        return f"one job has had the renderer for {turn:.0f} s" if turn > TURN_SECONDS else ""

    async def keep(self) -> None:
        """Kill a worker that hangs, which whoever reads its messages then hears."""
        while True:
            due = monotonic() + WATCH_SECONDS
            await asyncio.sleep(WATCH_SECONDS)
            began, now = self._jobs.running.began, monotonic()
            self._last_heard = min(max(self._last_heard, began or 0.0) + now - due, now)  # but for what it slept longer
            silence = now - self._last_heard
            if self._jobs.taken and began is None:
                if silence >= HEARTBEAT_SECONDS:
                    self._jobs.queue_heartbeat()
                continue
            starting = START_SECONDS if self._spoken else FIRST_WORD_SECONDS
            if silence >= (starting if began is None else self._jobs.running.patience):
                log.error("worker %d has said nothing for %.1f s: it hangs and is killed", self._link.pid, silence)
            elif began is not None and now - began >= max(MOST_TURN_SECONDS, self._jobs.hang_seconds):
                log.error("worker %d has been at one job for %.0f s: it is killed", self._link.pid, now - began)
            else:
                self._jobs.ask_back_since(now - LONG_TURN_SECONDS)
                continue
            self.hung = True
            self._link.kill()
