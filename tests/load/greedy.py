"""Pictures that take the device for minutes, beside somebody who walks."""

import asyncio
from itertools import pairwise
from time import perf_counter
from typing import Any

from tests.load.checks import Outcome, Scale, crowd_of
from tests.load.target import Target
from tests.load.viewer import Viewer

LONG: dict[str, dict[str, Any]] = {
    "exact-vpl": {"method": "exact-vpl"},
    "path": {"method": "path", "samples": 4096},
    "fuzzy-vpl": {"samples": 4096},
    "light set": {"vpls": 1_048_576, "vpl_clusters": 16_384},
}


async def long_jobs(target: Target, scale: Scale) -> Outcome:
    """The longest time without a frame, alone and beside each of some jobs, may differ by `scale.gap_seconds`."""
    outcome = Outcome()
    async with crowd_of(target, scale, 1) as (walker, *_), target.http() as http:
        gaps = {"alone": await _longest_gap(walker, scale.phase_seconds)}
        for name, settings in LONG.items():
            answer = await http.post("/api/v1/jobs", json={"size": scale.still, "settings": settings})
            answer.raise_for_status()
            gaps[name] = await _longest_gap(walker, scale.phase_seconds)
            await http.delete(answer.json()["url"])
        outcome.still_there([walker])
    for name, gap in gaps.items():
        outcome.expect(gap <= gaps["alone"] + scale.gap_seconds, f"beside {name} no frame came for {gap:.2f} s")
    outcome.measured = {"gap_seconds": gaps}
    return outcome


async def _longest_gap(viewer: Viewer, seconds: float) -> float:
    """Between two frames, from now on for so long [s]."""
    begun, known = perf_counter(), len(viewer.log.seen)
    await asyncio.sleep(seconds)
    times = [begun, *(frame.at for frame in viewer.log.seen[known:]), perf_counter()]
    return max(later - earlier for earlier, later in pairwise(times))
