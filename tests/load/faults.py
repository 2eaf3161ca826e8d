"""What the service must survive, and the run of it all against a service of its own."""

from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path

from gpu.errors import UserError
from tests.load import breaks, greedy, hostile, uninvited
from tests.load.checks import Check, Outcome, Scale
from tests.load.target import Target, serving

CHECKS: dict[str, Check] = {
    "worker-killed": breaks.worker_killed,
    "illegal-access": breaks.illegal_access,
    "slow-reader": hostile.slow_reader,
    "stalled-readers": hostile.stalled_readers,
    "too-many": hostile.too_many,
    "oversized": hostile.oversized,
    "flood": hostile.flood,
    "strangers": hostile.strangers,
    "besieged": uninvited.besieged,
    "knocked": uninvited.knocked,
    "long-jobs": greedy.long_jobs,
    "terminated": breaks.terminated,
    "web-killed": breaks.web_killed,
}


def chosen(names: Sequence[str]) -> list[str]:
    """All checks when none is named; UserError for one that there is not."""
    if unknown := set(names) - set(CHECKS):
        raise UserError(f"no check {', '.join(sorted(unknown))}; there are {', '.join(CHECKS)}")
    return list(names or CHECKS)


def service(
    scale: Scale, worker: str, flags: Sequence[str] = (), log: Path | None = None
) -> AbstractAsyncContextManager[Target]:
    """One to check, with `worker`, a program, in the renderer's place."""
    own = ["--max-viewers", str(scale.viewers), "--max-render-seconds", "1e9"]
    return serving([*own, *flags], worker, log)


async def check(name: str, scale: Scale, worker: str, flags: Sequence[str] = (), log: Path | None = None) -> Outcome:
    """One check against a service that is started for it."""
    async with service(scale, worker, flags, log) as target:
        return await CHECKS[name](target, scale)
