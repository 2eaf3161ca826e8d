"""What fault checks have in common: their scale, their outcome, and the viewers who must not notice."""

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from time import perf_counter

from tests.load.crowd import wait_for, walking
from tests.load.figures import Row
from tests.load.target import Target
from tests.load.viewer import Plan, Viewer

START_SECONDS = 120.0  # for the first frame of a viewer
NEXT_FRAME_SECONDS = 10.0


@dataclass(frozen=True)
class Scale:
    """How much of each: the full numbers, or few, for tests on a busy machine, which assert no timings.

    fault_seed: render settings of this seed meet an illegal access; viewers: that the service lets in; walkers: that
    walk at least in each check with walkers; phase_seconds, phases: of the slow reader, whose neighbours' p99 age may
    move by `change`, a share; refused_ms: until one too many is turned away; size: of frames; still: of jobs, beside
    which a walker may be without frames for `gap_seconds` more than alone.
    """

    fault_seed: int
    kills: int = 20
    viewers: int = 32
    walkers: int = 0
    phase_seconds: float = 20.0
    phases: int = 3
    change: float = 0.1
    refused_ms: float = 100.0
    flood_seconds: float = 5.0
    size: tuple[int, int] = (640, 360)
    still: tuple[int, int] = (7680, 4320)
    gap_seconds: float = 0.1


@dataclass
class Outcome:
    """What a check has measured, and its failures in words."""

    measured: Row = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)

    def expect(self, holds: bool, otherwise: str) -> None:
        """Note a failure unless it holds."""
        if not holds:
            self.failures.append(otherwise)

    def still_there(self, viewers: list[Viewer]) -> None:
        """Note those who have lost their connection."""
        for viewer in viewers:
            self.expect(viewer.log.closed is None, f"viewer {viewer.log.number} was closed: {viewer.log.closed}")


Check = Callable[[Target, Scale], Awaitable[Outcome]]


def quick(fault_seed: int) -> Scale:
    """Small numbers."""
    inf = float("inf")
    return Scale(
        fault_seed,
        3,
        viewers=8,
        phase_seconds=2.0,
        phases=1,
        change=inf,
        refused_ms=inf,
        flood_seconds=3.0,
        size=(160, 90),
        still=(16, 9),
        gap_seconds=inf,
    )


@asynccontextmanager
async def crowd_of(target: Target, scale: Scale, count: int) -> AsyncIterator[list[Viewer]]:
    """So many viewers, or as many as the scale wants, who walk and have seen their first frames."""
    async with AsyncExitStack() as stack:
        plans = [Plan(scale.size, seed=seed) for seed in range(max(count, scale.walkers))]
        viewers = [await stack.enter_async_context(walking(target, plan)) for plan in plans]
        if await wait_for(lambda: all(viewer.log.seen for viewer in viewers), START_SECONDS) is None:
            raise TimeoutError(f"no first frames within {START_SECONDS:.0f} s: {[viewer.log for viewer in viewers]}")
        yield viewers


async def goes_on(viewers: list[Viewer], outcome: Outcome) -> None:
    since = perf_counter()
    frames = await wait_for(lambda: all(viewer.log.last > since for viewer in viewers), NEXT_FRAME_SECONDS)
    outcome.expect(frames is not None, "the others get no frames any more")
    outcome.still_there(viewers)
