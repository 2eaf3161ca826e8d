"""Who has no token: silent connections, bodies of one-byte chunks, new connections all the time, beside who walks."""

import asyncio
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from time import perf_counter

import numpy as np

from tests.load import probe
from tests.load.checks import Outcome, Scale, crowd_of
from tests.load.target import HERE, Target
from tests.load.viewer import Viewer

SILENT, CHUNKED, KNOCKING, ASKING = 1100, 4, 16, 16
SETTLE_SECONDS = 3.0  # until all are there, or gone
PROBE_SECONDS = 0.1  # between two questions whether the service is ready, each over a connection of its own


async def besieged(target: Target, scale: Scale) -> Outcome:
    """1,100 silent connections and four senders of one-byte chunks: a walker keeps its frames, and /readyz answers."""
    return await _beside(target, scale, (SILENT, CHUNKED, 0, 0))


async def knocked(target: Target, scale: Scale) -> Outcome:
    """Beside those, sixteen who connect and leave, and sixteen who ask for the page, as fast as they can."""
    return await _beside(target, scale, (SILENT, CHUNKED, KNOCKING, ASKING))


async def _beside(target: Target, scale: Scale, intruders: Sequence[int]) -> Outcome:
    """Frames a second alone and beside intruders by turns, so that what else the machine does meets both."""
    outcome = Outcome()
    fps: dict[str, list[float]] = {"alone": [], "beside": []}
    ready_ms: dict[str, list[float]] = {"alone": [], "beside": []}
    cores: dict[str, list[float]] = {"alone": [], "beside": []}
    async with crowd_of(target, scale, 1) as viewers:
        for _ in range(scale.phases):
            for name, counts in (("alone", (0, 0, 0, 0)), ("beside", intruders)):
                async with _intruding(target, counts):
                    await asyncio.sleep(min(SETTLE_SECONDS, 0.2 * scale.phase_seconds))
                    frames, waits, core = await _watched(target, viewers[0], scale.phase_seconds)
                fps[name].append(frames)
                ready_ms[name] += waits
                cores[name].append(core)
        outcome.still_there(viewers)
    kept = float(np.median(fps["beside"]) / np.median(fps["alone"]))
    p95 = {name: float(np.percentile(waits, 95)) for name, waits in ready_ms.items()}
    outcome.measured = {"fps": fps, "kept": kept, "ready_p95_ms": p95, "web_cores": cores}
    outcome.expect(kept >= 1.0 - scale.change, f"the walker kept {100 * kept:.0f} % of its frames")
    outcome.expect(p95["beside"] <= scale.refused_ms, f"/readyz took {p95['beside']:.0f} ms (95 %)")
    return outcome


async def _watched(target: Target, viewer: Viewer, seconds: float) -> tuple[float, list[float], float]:
    """Frames a second of a viewer, how long /readyz took each time [ms], and what of a core the web process took."""
    assert target.process is not None
    used, since, waits = probe.cpu_seconds(target.process.pid), perf_counter(), []
    while perf_counter() < since + seconds:
        began = perf_counter()
        await _ask_whether_ready(*target.address)
        waits.append(1e3 * (perf_counter() - began))
        await asyncio.sleep(PROBE_SECONDS)
    until = perf_counter()
    used = probe.cpu_seconds(target.process.pid) - used
    frames = sum(since < one.at <= until for one in viewer.log.seen)
    return frames / (until - since), waits, used / (until - since)


async def _ask_whether_ready(host: str, port: int) -> None:
    reader, writer = await asyncio.open_connection(host, port)
    try:
        writer.write(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        await reader.read()
    finally:
        writer.close()


@asynccontextmanager
async def _intruding(target: Target, counts: Sequence[int]) -> AsyncIterator[None]:
    host, port = target.address
    command = (sys.executable, "-m", "tests.load.intruders", host, str(port), *map(str, counts))
    process = await asyncio.create_subprocess_exec(*command, stdin=asyncio.subprocess.PIPE, cwd=HERE)
    try:
        yield
    finally:
        assert process.stdin is not None
        process.stdin.close()
        await process.wait()
