"""Which of several engines renders for a client: where its scene is, then where fewest want the device. No I/O here."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from server.render.activity import EngineState

# So many clients more have the engines with a scene before another one loads it, too: reading it and what it takes of
# memory are worth a few viewers' waiting.
LOADING = 4.0
# A walker goes from one engine to another, and loses what its walk has left there, where so many times as many others
# want the first one.
UNEVEN = 1.25
LOADING_SECONDS = 60.0  # after which a scene that was to be loaded counts as given up
Scene = TypeVar("Scene")


@dataclass(frozen=True)
class Candidate:
    """An engine as a client finds it.

    holds: has the client's scene, or loads it; has_room: can load it; loads: is at another one now; clients: others
    that wanted a turn lately; busy: share of the time, lately, in which its device worked, from 0 to 1.
    """

    state: EngineState
    holds: bool
    has_room: bool
    loads: bool
    clients: int
    busy: float

    @property
    def crowd(self) -> float:
        """What speaks against it, in clients."""
        return self.clients + (0.0 if self.holds else LOADING)


def choose(candidates: Sequence[Candidate], own: int | None = None, *, walks: bool = False) -> int:
    """The number of the engine that a client goes to; own: of the one where it is, which it leaves when that cannot
    render, or, if it `walks`, when it is far more crowded than another.

    One that loads another scene is spared where there is one that does not: an engine that comes back empty is the
    least crowded of all, and who is sent there waits for each scene before its own.
    """
    ready = [number for number, it in enumerate(candidates) if it.state is EngineState.READY]
    able = [number for number in ready if candidates[number].holds or candidates[number].has_room]
    fit = [number for number in able if candidates[number].holds or not candidates[number].loads] or able
    if own is not None and own in ready:
        best = min(fit, key=lambda number: _order(candidates[number]), default=own)
        leaves = walks and candidates[own].clients > UNEVEN * candidates[best].crowd
        return best if leaves else own
    hopeful = [number for number, it in enumerate(candidates) if it.state is not EngineState.FAILED]
    if own is not None and own in hopeful and not fit:  # what has no room elsewhere waits for its own
        return own
    return min(fit or ready or hopeful or range(len(candidates)), key=lambda number: _order(candidates[number]))


def _order(candidate: Candidate) -> tuple[float, bool, float]:
    """Smaller goes first."""
    return candidate.crowd, not candidate.holds, candidate.busy


def still_loading(sent: Mapping[Scene, float], there: Collection[Scene], now: float) -> dict[Scene, float]:
    """Of the scenes that an engine was to load, with the time of each [s], those that are not there, nor given up."""
    return {scene: at for scene, at in sent.items() if scene not in there and at > now - LOADING_SECONDS}
