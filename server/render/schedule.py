"""Who has the device next: the most urgent first, and among those, whoever has had it least lately. No I/O here."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from time import monotonic

# A still that waited this long goes first, one in as long: neither may keep those out for ever who walk, nor they it.
PATIENCE_SECONDS = 1.0


class Urgency(IntEnum):
    """What is rendered first; lower goes first."""

    MOVING = 0  # frames of a view that moves
    STILL = 1  # the first frame of a rest; stills; reading scenes
    REFINING = 2  # more frames of a view that is shown already; jobs


@dataclass(eq=False, frozen=True)
class QueueEntry:
    """One place in the queue."""

    client: int
    urgency: Urgency
    since: float  # [s]


@dataclass
class _Queue:
    """Those who wait with one urgency, and the virtual times [s of device time] of clients ahead of the queue's own."""

    waiting: list[QueueEntry] = field(default_factory=list)
    now: float = 0.0
    starts: dict[int, float] = field(default_factory=dict)

    def start(self, client: int) -> float:
        return self.starts.get(client, self.now)


class Schedule:
    """Places in the queue, and the device time that was used from them.

    Within one urgency this is start-time fair queueing (Goyal, Vin, Cheng 1996) with the cost of a turn charged after
    it. The virtual time is that of the client served last, and whoever comes starts there: idleness earns no credit,
    and what was used before it is forgotten, so nothing is kept of clients that have left.
    """

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self._now = now
        self._let_in = -PATIENCE_SECONDS  # when a still went first for its patience
        self._queues = {urgency: _Queue() for urgency in Urgency}

    def join(self, client: int, urgency: Urgency) -> QueueEntry:
        """Queue up; a client may have several places."""
        place = QueueEntry(client, urgency, self._now())
        self._queues[urgency].waiting.append(place)
        return place

    def leave(self, place: QueueEntry) -> None:
        """Give up a place; does nothing when its turn has come already."""
        waiting = self._queues[place.urgency].waiting
        if place in waiting:
            waiting.remove(place)

    def next(self) -> QueueEntry | None:
        """The place whose turn it is, taken out of the queue; None when nobody waits."""
        stills = self._queues[Urgency.STILL]
        if stills.waiting and self._now() - max(stills.waiting[0].since, self._let_in) >= PATIENCE_SECONDS:
            self._let_in = self._now()
            return self._take(stills, stills.waiting[0])
        for queue in self._queues.values():
            if queue.waiting:
                return self._take(queue, min(queue.waiting, key=lambda place: queue.start(place.client)))
        return None

    def charge(self, place: QueueEntry, seconds: float) -> None:
        """A turn that `next` gave has used the device for so long; what is not charged was free."""
        queue = self._queues[place.urgency]
        queue.starts[place.client] = queue.start(place.client) + seconds
        if not queue.waiting:  # nobody competes, so nobody owes
            queue.now = max(queue.starts.values())
        self._forget(queue)

    def _take(self, queue: _Queue, place: QueueEntry) -> QueueEntry:
        queue.waiting.remove(place)
        queue.now = max(queue.now, queue.start(place.client))
        self._forget(queue)
        return place

    def _forget(self, queue: _Queue) -> None:
        queue.starts = {client: start for client, start in queue.starts.items() if start > queue.now}
