"""The renderer dies, the device breaks, the service is told to end: what viewers then see."""

import asyncio
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from time import perf_counter
from typing import Any

import httpx

from tests.load import probe
from tests.load.checks import NEXT_FRAME_SECONDS, Outcome, Scale, crowd_of, goes_on
from tests.load.crowd import wait_for
from tests.load.rest import Answers, Stills, ask
from tests.load.target import Target
from tests.load.viewer import Log

DRAIN_SECONDS = 10.0
FAULT_SEEN_SECONDS, FAULT_OVER_SECONDS = 5.0, 15.0
RESTART = 1012
ENDED = (0, -signal.SIGTERM)  # uvicorn sends itself the signal again when all is done, as shells want it


async def worker_killed(target: Target, scale: Scale) -> Outcome:
    """SIGKILL to the renderer, again and again: each time the next frames come soon, and no socket is lost."""
    outcome, waits = Outcome(), []
    pid = _pid(target)
    async with crowd_of(target, scale, 3) as viewers:
        for number in range(1, scale.kills + 1):
            workers = probe.workers_of(pid)
            if not workers:
                outcome.expect(False, f"kill {number}: there is no renderer")
                break
            os.kill(min(workers), signal.SIGKILL)
            killed = perf_counter()
            await wait_for(lambda old=workers: bool(probe.workers_of(pid) - old), NEXT_FRAME_SECONDS)  # type: ignore[misc]
            started = perf_counter()  # what comes later is not of the one that was killed
            left = NEXT_FRAME_SECONDS - (started - killed)
            back = await wait_for(lambda since=started: all(one.log.last > since for one in viewers), left)  # type: ignore[misc]
            if back is None:
                outcome.expect(False, f"kill {number}: no frame for everyone within {NEXT_FRAME_SECONDS:.0f} s")
                break
            waits.append(perf_counter() - killed)
        outcome.still_there(viewers)
    outcome.measured = {"kills": len(waits), "worst_seconds": max(waits, default=None), "seconds": waits}
    return outcome


async def illegal_access(target: Target, scale: Scale) -> Outcome:
    """A fault that breaks the device for the renderer: /readyz says so soon, and soon all is well again."""
    outcome = Outcome()
    async with crowd_of(target, scale, 2) as viewers, target.http() as http:
        await viewers[0].change(settings={"seed": scale.fault_seed})
        began = perf_counter()
        seen = await _until(http, lambda told: told["code"] == 503 or told["restarts"] > 0, FAULT_SEEN_SECONDS)
        await viewers[0].change(settings={})
        left = FAULT_OVER_SECONDS - (perf_counter() - began)
        over = await _until(http, lambda told: told["code"] == 200, left)
        ready = perf_counter()
        await goes_on(viewers, outcome)
    outcome.measured = {"seen_seconds": seen, "over_seconds": None if over is None else ready - began}
    outcome.expect(seen is not None, f"/readyz did not say 503 within {FAULT_SEEN_SECONDS:.0f} s")
    outcome.expect(over is not None, f"/readyz did not say 200 again within {FAULT_OVER_SECONDS:.0f} s")
    return outcome


async def terminated(target: Target, scale: Scale) -> Outcome:
    """SIGTERM: viewers are told and closed with 1012, a still under way is finished, and the process ends in time."""
    outcome, answers = Outcome(), Answers()
    assert target.process is not None
    async with crowd_of(target, scale, 3) as viewers, target.http() as http:
        still = asyncio.create_task(ask(http, Stills(size=scale.size), answers))
        while not still.done() and not (await probe.scrape(http)).get("lumenwalk_stills_waiting"):
            await asyncio.sleep(0.01)
        target.process.send_signal(signal.SIGTERM)
        began = perf_counter()
        with suppress(TimeoutError):
            await asyncio.wait_for(target.process.wait(), DRAIN_SECONDS)
        seconds = perf_counter() - began
        outcome.expect(target.process.returncode is not None, f"it did not end within {DRAIN_SECONDS:.0f} s")
        await asyncio.wait([still], timeout=1.0)
        logs: list[Log] = [viewer.log for viewer in viewers]
    outcome.measured = {
        "seconds": seconds,
        "status": target.process.returncode,
        "closed": [log.closed for log in logs],
        "stills": dict(answers.statuses),
    }
    outcome.expect(target.process.returncode in (*ENDED, None), f"its exit status was {target.process.returncode}")
    outcome.expect(all(log.closed and log.closed[0] == RESTART for log in logs), "not all were closed with 1012")
    outcome.expect(all("stopping" in log.states for log in logs), "not all were told")
    outcome.expect(answers.statuses == {200: 1}, f"the still under way: {answers.statuses}, {answers.errors}")
    return outcome


async def web_killed(target: Target, scale: Scale) -> Outcome:
    """SIGKILL to the web process: its renderers, which nobody needs any more, end by themselves."""
    outcome = Outcome()
    assert target.process is not None
    async with crowd_of(target, scale, 3):
        workers = probe.workers_of(target.process.pid)
        killed = perf_counter()
        target.process.kill()
        ended = await wait_for(lambda: not any(map(probe.rss_bytes, workers)), DRAIN_SECONDS)
        seconds = perf_counter() - killed
        await target.process.wait()
    outcome.measured = {"workers": len(workers), "seconds": seconds}
    outcome.expect(bool(workers), "there was no renderer")
    outcome.expect(ended is not None, f"not all renderers ended within {DRAIN_SECONDS:.0f} s")
    return outcome


def _pid(target: Target) -> int:
    assert target.process is not None, "faults are for a service that was started here"
    return target.process.pid


async def _until(http: httpx.AsyncClient, holds: Callable[[dict[str, Any]], bool], seconds: float) -> float | None:
    """How long it took until this held of what /readyz says; None: it did not in time."""
    began = perf_counter()
    while perf_counter() - began < seconds:
        if holds(await probe.state(http)):
            return perf_counter() - began
        await asyncio.sleep(0.01)
    return None
