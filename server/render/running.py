"""The turns that jobs have in a worker now: as many at once as its device has lanes. No I/O here."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from server.render.schedule import QueueEntry, Urgency
from server.wire.worker import HEARTBEAT, STILLS, Job

SHORT_TURN_SECONDS = 0.01  # of a turn, which is not asked back: it ends soon
# Of a frame of somebody who moves, before others who move may have the turn: frames that all share all come late.
WHOLE_FRAME_SECONDS, WHOLE_FRAME_SECONDS_ON_CUDA = 1.0, 0.05


@dataclass
class RunningTurn:
    """A job whose turn it is; it may say nothing for `patience`; spent: in its turns before."""

    request: int
    entry: QueueEntry
    job: Job
    began: float  # [s]
    patience: float  # [s]
    spent: float = 0.0  # [s]
    asked_back: bool = False

    @property
    def is_heartbeat(self) -> bool:
        """Whether nobody asked for it."""
        return self.entry.client == HEARTBEAT

    def free_at(self, *, cuda: bool) -> float:
        """When it may be asked back for others [s]; cuda: it is on a GPU."""
        seconds = SHORT_TURN_SECONDS
        if self.entry.urgency is Urgency.MOVING:
            seconds = WHOLE_FRAME_SECONDS_ON_CUDA if cuda else WHOLE_FRAME_SECONDS
        return self.began + seconds

    def gives_way_to(self, entry: QueueEntry) -> bool:
        """Whether it may have to wait for `entry` once it has given its turn back."""
        own = self.entry
        # A viewer's frames follow one another anyway; stills are of many who ask for them, and may have waited long.
        is_other = entry.client != own.client or own.client == STILLS
        return is_other and (entry.urgency <= own.urgency or entry.urgency is Urgency.STILL)


class RunningTurns:
    """By request, the one that began first first; `lanes`: how many there may be; `alone`: for now, one at a time."""

    def __init__(self) -> None:
        self.lanes, self.alone = 1, False
        self._turns: dict[int, RunningTurn] = {}
        self._clients: set[int] = set()  # whose turns they are

    def __len__(self) -> int:
        return len(self._turns)

    def __iter__(self) -> Iterator[RunningTurn]:
        return iter(tuple(self._turns.values()))

    def get(self, request: int) -> RunningTurn | None:
        """The turn that a request has now, if any."""
        return self._turns.get(request)

    def begin(self, turn: RunningTurn) -> None:
        """One more."""
        self._turns[turn.request] = turn
        self._clients.add(turn.entry.client)

    def end(self, turn: RunningTurn) -> None:
        """One less."""
        del self._turns[turn.request]
        self._clients = {it.entry.client for it in self._turns.values()}

    @property
    def full(self) -> bool:
        """Whether none may begin beside these."""
        return len(self._turns) >= (1 if self.alone else self.lanes)

    @property
    def began(self) -> float | None:
        """When the first of them did [s]; None while there is none."""
        return min((turn.began for turn in self), default=None)

    @property
    def patience(self) -> float:
        """How long nothing may be said while they run [s]."""
        return max((turn.patience for turn in self), default=0.0)

    def admit(self, entry: QueueEntry) -> bool:
        """Whether a turn may begin beside these.

        A client has one at a time: its next frame is to have the pose that is newest when the last one is done, and
        stills must not fill all lanes. What refines begins beside nothing that is more urgent.
        """
        if self.full or entry.client in self._clients:
            return False
        return entry.urgency is not Urgency.REFINING or all(turn.entry.urgency >= entry.urgency for turn in self)

    def to_ask_back(self, waiting: Iterable[QueueEntry]) -> list[RunningTurn]:
        """Those in whose place one of the entries that wait might run, and what refines beside what is more urgent; but
        for those that were asked.
        """
        entries = tuple(waiting)
        return [turn for turn in self if not turn.asked_back and self._is_in_the_way(turn, entries)]

    def _is_in_the_way(self, turn: RunningTurn, waiting: tuple[QueueEntry, ...]) -> bool:
        own = turn.entry
        if own.urgency is Urgency.REFINING and any(other.entry.urgency < own.urgency for other in self):
            return True
        return any(turn.gives_way_to(entry) and (self.full or entry.client == own.client) for entry in waiting)
