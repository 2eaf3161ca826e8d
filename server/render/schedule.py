"""The queue for the device: the most urgent first, and among those, whoever used it least lately. No I/O here."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from time import monotonic

# A still that waited this long goes first, at most one in as long: walkers must not keep it out for ever, nor it them.
PATIENCE_SECONDS = 1.0


class Urgency(IntEnum):
    """What is rendered first; lower goes first."""

    MOVING = 0  # frames of a view that moves
    STILL = 1  # the first frame of a rest; stills; reading scenes
    REFINING = 2  # more frames of a view that is shown already; jobs


@dataclass(eq=False, frozen=True)
class QueueEntry:
    """A client that waits, since when [s], and for something how urgent."""

    client: int
    urgency: Urgency
    since: float


@dataclass
class _Queue:
    """Entries of one urgency, its virtual time [s of device time], and those of clients who are ahead of it."""

    waiting: list[QueueEntry] = field(default_factory=list)
    now: float = 0.0
    starts: dict[int, float] = field(default_factory=dict)

    def start(self, client: int) -> float:
        return self.starts.get(client, self.now)


class Schedule:
    """Entries, and the device time that their turns used.

    Within one urgency this is start-time fair queueing (Goyal, Vin, Cheng 1996) with the cost of a turn charged after
    it. The virtual time is that of the client served last, and whoever comes starts there: idleness earns no credit,
    and what was used before it is forgotten, so nothing is kept of clients that have left.
    """

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self._now = now
        self._overdue_at = -PATIENCE_SECONDS  # when a still last went first since it had waited long
        self._queues = {urgency: _Queue() for urgency in Urgency}

    def join(self, client: int, urgency: Urgency) -> QueueEntry:
        """Queue up; a client may do so several times."""
        entry = QueueEntry(client, urgency, self._now())
        self._queues[urgency].waiting.append(entry)
        return entry

    def rejoin(self, entry: QueueEntry) -> None:
        """Queue up again for the rest of a turn that was given back, before what the client wants after it."""
        self._queues[entry.urgency].waiting.insert(0, entry)

    def leave(self, entry: QueueEntry) -> None:
        """Leave the queue; does nothing when the turn has come already."""
        waiting = self._queues[entry.urgency].waiting
        if entry in waiting:
            waiting.remove(entry)

    def next(self, admits: Callable[[QueueEntry], bool] = lambda _entry: True) -> QueueEntry | None:
        """The entry whose turn it is, of those that may have one now, taken out of the queue; None if there is none."""
        admitted = {
            urgency: [entry for entry in queue.waiting if admits(entry)] for urgency, queue in self._queues.items()
        }
        stills = admitted[Urgency.STILL]
        if stills and self._now() - max(stills[0].since, self._overdue_at) >= PATIENCE_SECONDS:
            self._overdue_at = self._now()
            return self._take(self._queues[Urgency.STILL], stills[0])
        for urgency, queue in self._queues.items():
            if entries := admitted[urgency]:
                return self._take(queue, min(entries, key=lambda entry: queue.start(entry.client)))
        return None

    def charge(self, entry: QueueEntry, seconds: float) -> None:
        """A turn that `next` gave has used the device for so long; what is not charged was free."""
        queue = self._queues[entry.urgency]
        queue.starts[entry.client] = queue.start(entry.client) + seconds
        if not queue.waiting:  # nobody competes, so nobody owes
            queue.now = max(queue.starts.values())
        self._forget(queue)

    def _take(self, queue: _Queue, entry: QueueEntry) -> QueueEntry:
        queue.waiting.remove(entry)
        queue.now = max(queue.now, queue.start(entry.client))
        self._forget(queue)
        return entry

    def _forget(self, queue: _Queue) -> None:
        queue.starts = {client: start for client, start in queue.starts.items() if start > queue.now}
