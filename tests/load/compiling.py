"""How long viewers get no frame while kernels are compiled: `python -m tests.load.compiling [DEVICE] [general]` prints
a line of JSON a step, of a service with no kernels kept, or after `lumenwalk warm --general`.

A viewer walks through the Cornell box. Another comes to the living-room, and walks, too; then its oak becomes a mirror,
which needs other kernels. Longest times without a frame [s]: of the one (walker), and of the other (visitor).
"""

import asyncio
import json
import os
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory
from time import perf_counter

from tests.load.target import Target, serving
from tests.load.viewer import Log, Plan, Viewer

LOOK, WATCHED = 0.05, 20.0  # between two looks; that frames are counted for after an edit [s]
LIVING_ROOM = "living-room"
EDIT = {"materials": {"oak": {"metallic": 1.0, "roughness": 0.0}}}
SIZE = (640, 360)


def longest_gap(times: list[float], begun: float, ended: float) -> float:
    """The longest time without a frame between two times, of frames that came at `times` [s]."""
    within = [begun, *(time for time in times if begun < time < ended), ended]
    return max(b - a for a, b in pairwise(within))


async def until(over: Callable[[], bool]) -> None:
    """Wait for that."""
    while not over():
        await asyncio.sleep(LOOK)


@asynccontextmanager
async def walking(target: Target, scene: str) -> AsyncIterator[Log]:
    """What a viewer who walks through a scene notes meanwhile."""
    async with target.socket() as socket:
        viewer = Viewer(socket, Plan(size=SIZE, scene=scene))
        walk = asyncio.create_task(viewer.run())
        try:
            yield viewer.log
        finally:
            walk.cancel()
            await asyncio.wait([walk])


async def measure(target: Target) -> dict[str, dict[str, float]]:
    """The longest times without a frame, by step and viewer."""
    found = {}
    async with walking(target, "cornell-box") as walker:
        await until(lambda: len(walker.seen) > 1)
        begun = perf_counter()
        async with walking(target, LIVING_ROOM) as visitor:

            def longest(since: float) -> dict[str, float]:
                logs, now = {"walker": walker, "visitor": visitor}, perf_counter()
                gaps = {who: longest_gap([it.at for it in log.seen], since, now) for who, log in logs.items()}
                return {who: round(gap, 3) for who, gap in gaps.items()}

            await until(lambda: len(visitor.seen) > 0)
            found["another scene"] = longest(begun)
            await asyncio.sleep(WATCHED)
            begun = perf_counter()
            async with target.http() as http:
                (await http.patch(f"/api/v1/scenes/{LIVING_ROOM}", json=EDIT)).raise_for_status()
            await asyncio.sleep(WATCHED)
            found["an edit"] = longest(begun)
    return found


async def main(device: str, *, general: bool) -> None:
    """Print a line for each step."""
    with TemporaryDirectory() as kept:
        os.environ["WARP_CACHE_PATH"] = kept
        if general:
            command = "import sys; from server.cli.main import main; sys.exit(main())"
            run([sys.executable, "-c", command, "warm", "--general", f"--device={device}", "cornell-box"], check=True)
        async with serving([f"--device={device}", "--scene=cornell-box"], log=Path(kept) / "log") as target:
            for step, longest in (await measure(target)).items():
                print(json.dumps({"general": general, "step": step, "without_a_frame_s": longest}), flush=True)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1] if len(sys.argv) > 1 else "cuda:0", general="general" in sys.argv[2:]))
