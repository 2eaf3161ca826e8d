"""What ended a worker, so that nobody has it tried again: each time would take the device from all others, too.

A job is held to be at fault if its worker crashed, was killed because it hung, or ended after it had long been at it. A
worker killed in a short time may have been killed by somebody: then the job is tried once more. Of several jobs that a
worker had at once none is: jobs have a worker to themselves then, until each of these has been done, has failed by an
ordinary mistake or has ended one. Another seed or a pixel less is no way round: when two pictures that cost about the
same have ended workers, all that cost as much are out.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from signal import SIGKILL, SIGTERM
from time import monotonic

from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import DEFAULT_OPTIONS
from gpu.settings import RenderSettings
from server.render.cost import Cost, Kind, frame_cost
from server.wire.worker import HEARTBEAT, Export, Job, OpenScene, Pick, Render, SceneRef

STRIKES = 2
LONG_SECONDS = 5.0  # of a job, in which a worker killed from outside was rather killed for its memory
# Of the pixels and rays of a picture, from which on another is like it; and so many have to end workers until all that
# are like them are out: one may have had a fault of its own, and others look at the scene.
LIKE, LIKE_STRIKES = 0.5, 2
SCENE_STRIKES = 3  # of a file, however it is read, that ended workers, after which it is not shown at all
MOST = 1000  # that are remembered
SUSPECT_SECONDS = 30.0  # after which nobody wants a job any more that has been neither done nor at fault


class QuarantinedError(UserError):
    """It ended the renderer before, and is not tried again (422)."""


@dataclass(frozen=True)
class _Offence:
    """A scene that is read, a kind of pictures of it, or another kind of work with it."""

    scene: SceneRef
    size: tuple[int, int] = (0, 0)
    settings: RenderSettings | None = None
    kind: str = ""

    @property
    def file(self) -> SceneRef:
        """However it is read."""
        return replace(self.scene, options=DEFAULT_OPTIONS)

    def is_like(self, kind: Kind, cost: Cost, *, cuda: bool) -> bool:
        """Whether pictures of this kind and cost are like this one, or cost more."""
        if self.settings is None or Kind.of(self.scene, self.settings) != kind:
            return False
        own = frame_cost(self.size, self.settings, cuda=cuda)
        return cost.pixels >= LIKE * own.pixels and cost.rays >= LIKE * own.rays


def _offence(job: Job) -> _Offence | None:
    match job:
        case OpenScene(scene):
            return _Offence(scene)
        case Render(viewer, scene, _, size, settings) if viewer != HEARTBEAT:  # which is nobody's wish
            return _Offence(scene, size, settings.model_copy(update={"frames": None, "exposure": None}))
        case Pick(scene=scene) | Export(scene=scene):
            return _Offence(scene, kind=job.kind)
        case _:
            return None


@dataclass
class Quarantine:
    """Counts what jobs did to workers, by scene and settings; a file that has changed is another scene."""

    _strikes: dict[_Offence, int] = field(default_factory=dict)  # in the order of their last
    _suspects: dict[_Offence, float] = field(default_factory=dict)  # and since when [s]

    def blame(self, job: Job, seconds: float, status: int | None, *, hung: bool) -> None:
        """A worker has ended with this exit status (negative: a signal) in a turn of a job, with which it has been for
        so many seconds in all; hung: it was killed because it said nothing for too long.
        """
        offence = _offence(job)
        if offence is None:
            return
        self._suspects.pop(offence, None)
        killed = status is not None and -status in (SIGKILL, SIGTERM)
        strikes = 1 if killed and not hung and seconds < LONG_SECONDS else STRIKES
        self._strike(offence, strikes)

    def suspect(self, jobs: Iterable[Job]) -> None:
        """A worker has ended in turns of several jobs at once, of which any may be at fault."""
        now = monotonic()
        self._suspects |= {offence: now for job in jobs if (offence := _offence(job)) is not None}

    def renew(self) -> None:
        """A worker takes jobs again: until now none of those that are suspected could be done."""
        self._suspects = dict.fromkeys(self._suspects, monotonic())

    @property
    def suspecting(self) -> bool:
        """Whether a worker is to have one job at a time, so that it is known which ended it."""
        now = monotonic()
        self._suspects = {what: since for what, since in self._suspects.items() if now - since < SUSPECT_SECONDS}
        return bool(self._suspects)

    def _strike(self, offence: _Offence, strikes: int) -> None:
        self._strikes[offence] = self._strikes.pop(offence, 0) + strikes
        if len(self._strikes) > MOST:
            del self._strikes[next(iter(self._strikes))]

    def acquit(self, job: Job) -> None:
        """It has been done, or failed by an ordinary mistake."""
        if (self._strikes or self._suspects) and (offence := _offence(job)) is not None:
            self._strikes.pop(offence, None)
            self._suspects.pop(offence, None)

    def check(self, job: Job, *, cuda: bool = False) -> None:
        """QuarantinedError for a job that is not tried again; cuda: it would be on a GPU."""
        offence = _offence(job) if self._strikes else None
        if offence is None:
            return
        if self._is_out(_Offence(offence.scene)):
            raise QuarantinedError(
                f"{offence.scene.id}: ended the renderer when it was read, so that it is not read again until the "
                "file changes or the service is started anew"
            )
        if self._is_out(offence):
            raise QuarantinedError(
                f"{offence.scene.id}: ended the renderer with what is asked for, so that nobody has it tried "
                "again; change it"
            )
        alike = [other for other in self._strikes if other.file == offence.file and self._is_out(other)]
        if offence.settings is not None:
            kind = Kind.of(offence.scene, offence.settings)
            cost = frame_cost(offence.size, offence.settings, cuda=cuda)
            if sum(other.is_like(kind, cost, cuda=cuda) for other in alike) >= LIKE_STRIKES:
                raise QuarantinedError(
                    f"{offence.scene.id}: pictures by this method that take as much, or less, ended the renderer, "
                    "so that nobody has it tried; ask for a smaller one, or fewer samples or VPLs"
                )
        if len(alike) >= SCENE_STRIKES and offence.scene.source not in BUILTIN:
            raise QuarantinedError(
                f"{offence.scene.id}: ended the renderer {len(alike)} times, so that it is not shown again until "
                "the file changes or the service is started anew"
            )

    def _is_out(self, offence: _Offence) -> bool:
        return self._strikes.get(offence, 0) >= STRIKES
