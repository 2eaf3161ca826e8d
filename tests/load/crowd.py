"""Many viewers at once, measured together between a warm-up and an end."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from time import perf_counter, process_time

from tests.load import probe
from tests.load.figures import Row, crowd_row
from tests.load.target import Target
from tests.load.viewer import Plan, Viewer

FIRST_FRAME_SECONDS = 300.0  # a scene may have to be loaded, and kernels compiled for its settings
ARRIVAL_SECONDS = 0.02  # between two viewers that come
# Counters of /metrics [s] whose growth says for which share of the time something was busy.
BUSY = {"web process": "process_cpu_seconds_total", "device": "lumenwalk_device_busy_seconds_total"}


def plans(plan: Plan, count: int, decoding: int = 0) -> list[Plan]:
    """The same for each viewer but for the seed; the first `decoding` of them decode pictures."""
    return [replace(plan, seed=plan.seed + number, decode=number < decoding) for number in range(count)]


@asynccontextmanager
async def walking(target: Target, plan: Plan, url: str | None = None) -> AsyncIterator[Viewer]:
    """A viewer that walks while the context lasts; `url`: of a relay to reach the target by."""
    async with target.socket(url) as socket:
        viewer = Viewer(socket, plan)
        run = asyncio.create_task(viewer.run())
        try:
            yield viewer
        finally:
            run.cancel()
            await asyncio.wait([run])
    if not run.cancelled():
        run.result()  # raises what the viewer itself did wrong


async def wait_for(condition: Callable[[], bool], seconds: float) -> float | None:
    """How long [s] it took until the condition held; None if it did not in time."""
    began = perf_counter()
    while not condition():
        if perf_counter() - began > seconds:
            return None
        await asyncio.sleep(0.005)
    return perf_counter() - began


async def measure(target: Target, wanted: Sequence[Plan], seconds: float, warm_up: float = 3.0) -> Row:
    """Let a crowd walk: from `warm_up` seconds after each viewer's first frame it is measured; returns its row."""
    async with AsyncExitStack() as crowd, target.http() as http:
        viewers = []
        for plan in wanted:
            viewers.append(await crowd.enter_async_context(walking(target, plan)))
            await asyncio.sleep(ARRIVAL_SECONDS)
        await wait_for(lambda: all(one.log.seen or one.log.closed for one in viewers), FIRST_FRAME_SECONDS)
        await asyncio.sleep(warm_up)
        before, since, used = await probe.scrape(http), perf_counter(), process_time()
        await asyncio.sleep(seconds)
        after, until, used = await probe.scrape(http), perf_counter(), process_time() - used
        shares = {"harness": used / (until - since)}
        for what, name in BUSY.items():
            if name in after:
                shares[what] = (after[name] - before.get(name, 0.0)) / (until - since)
        return crowd_row([one.log for one in viewers], since, until, shares)
