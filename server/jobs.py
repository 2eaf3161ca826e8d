"""Renders that take long, done in the background, one a device at a time, frame by frame behind whoever walks."""

import asyncio
import logging
import secrets
from collections import Counter
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS
from gpu.settings import RenderSettings
from server.places import asker
from server.refusals import TooBusyError, UnknownJobError
from server.render.engine_pool import EnginePool
from server.render.films import Film, render_film
from server.render.pending import RenderFaultError
from server.render.schedule import Urgency
from server.render.stills import render_frames
from server.render.worker_link import WorkerLostError
from server.results import Result, save, take
from server.scenes.residency import Residency
from server.wire.worker import Render, SceneCamera, SceneRef

MAX_LOSSES = 3  # of the worker, in a row
OF_ALL = 2  # times as many jobs of all clients as of one may wait or run
MAX_ENDED = 1000  # jobs that are remembered
log = logging.getLogger("lumenwalk.jobs")


class JobState(StrEnum):
    """How far a job is."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


ENDED = (JobState.DONE, JobState.FAILED, JobState.CANCELLED)


@dataclass
class RenderJob:
    """A picture or film in the making: what the worker is asked for, of how many frames, and what has become of it.

    frames: of all its pictures; client: who asked for it.
    """

    id: str
    render: Render
    frames: int
    media_type: str
    film: Film | None = None
    pictures: int = 1
    client: str = ""
    begun: int = 0  # which of all jobs that have
    state: JobState = JobState.QUEUED
    samples: int = 0
    error: str = ""
    result: bytes = b""
    changed: asyncio.Event = field(default_factory=asyncio.Event)  # replaced by another one each time

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return self.samples / self.frames


class Jobs:
    """The jobs of one service, by id, in the order in which they came."""

    def __init__(
        self,
        engines: EnginePool,
        residency: Residency,
        dismiss: Callable[[int], None],
        *,
        max_jobs: int,
        keep_seconds: float,
        keep_bytes: int,
    ) -> None:
        """dismiss: frees what is kept for a viewer number; max_jobs: of one client; keep_…: of results."""
        self._engines = engines
        self._residency = residency
        self._dismiss = dismiss
        self._max_jobs = max_jobs
        self._keep_seconds = keep_seconds
        self._keep_bytes = keep_bytes
        self._jobs: dict[str, RenderJob] = {}
        self._begun = 0
        self.ended = Counter(dict.fromkeys(ENDED, 0))  # since the service began
        self._added = asyncio.Event()
        self._running: dict[str, asyncio.Task[None]] = {}  # by job

    @property
    def all(self) -> list[RenderJob]:
        """The oldest first."""
        return list(self._jobs.values())

    def find(self, job_id: str) -> RenderJob:
        """The job with this id; UnknownJobError when there is none, or its time is over."""
        if job_id not in self._jobs:
            raise UnknownJobError(f"job: there is no {job_id!r} here, or no longer; /api/v1/jobs lists what there is")
        return self._jobs[job_id]

    def add(self, render: Render, frames: int, media_type: str, film: Film | None = None) -> RenderJob:
        """Queue a picture, or a film of pictures, of so many frames each; TooBusyError when too many of who asks wait,
        or twice as many of all.

        Its viewer number is the job's own.
        """
        client = asker.get()
        waiting = Counter(job.client for job in self._jobs.values() if job.state not in ENDED)
        if waiting[client] >= self._max_jobs or waiting.total() >= OF_ALL * self._max_jobs:
            raise TooBusyError(f"{waiting.total()} jobs wait or run already; try again later")
        pictures = len(film.views) if film else 1
        job = RenderJob(secrets.token_hex(8), render, pictures * frames, media_type, film, pictures, client)
        self._jobs[job.id] = job
        self._added.set()
        return job

    def remove(self, job_id: str) -> RenderJob:
        """Cancel a job that waits or runs, and forget it and its result."""
        job = self.find(job_id)
        if job.id in self._running:
            self._running[job.id].cancel()
        if job.state not in ENDED:
            self._tell(job, JobState.CANCELLED)
        self._forget(job.id)
        return job

    def stop(self) -> None:
        """Render no more: what waits or runs fails, and says why."""
        for job in self._jobs.values():
            if job.state not in ENDED:
                job.error = "the service was stopped before the picture was done"
                self._tell(job, JobState.FAILED)
        for task in self._running.values():
            task.cancel()

    def save(self, folder: Path | None) -> None:
        """Keep the results of finished jobs for the next service, if there is a folder; else they are lost."""
        done = [job for job in self._jobs.values() if job.state is JobState.DONE]
        told = (
            Result(
                id=it.id,
                scene=it.render.scene.id,
                size=it.render.size,
                frames=it.frames,
                pictures=it.pictures,
                media_type=it.media_type,
            )
            for it in done
        )
        kept = save(folder, zip(told, (job.result for job in done), strict=True)) if done and folder else 0
        if lost := len(done) - kept:
            advice = "" if folder else "; `uploads_dir` would keep them"
            log.warning("the results of %d jobs are lost with the service%s", lost, advice)

    def restore(self, folder: Path) -> None:
        """Take up the results that the service before this one has kept."""
        for result, picture in take(folder, self._keep_bytes):
            scene = SceneRef(result.scene, result.scene)
            render = Render(0, scene, SceneCamera(0), result.size, RenderSettings(), "none")
            job = RenderJob(result.id, render, result.frames, result.media_type, pictures=result.pictures)
            job.state, job.samples, job.result = JobState.DONE, result.frames, picture
            self._jobs[job.id] = job
            asyncio.get_running_loop().call_later(self._keep_seconds, self._forget, job.id)

    async def run(self) -> None:
        """Work until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            for _ in self._engines.engines:
                tasks.create_task(self._work())

    async def watch(self, job: RenderJob) -> AsyncIterator[RenderJob]:
        """The job now, then whenever something of it has changed, until it has ended."""
        while True:
            changed, ended = job.changed, job.state in ENDED
            yield job
            if ended:  # as it was told: it may have ended since
                return
            await changed.wait()

    async def _work(self) -> None:
        """One job after the other."""
        while True:
            job = self._next()
            if job is None:
                self._added.clear()
                await self._added.wait()
                continue
            self._begun += 1
            job.begun = self._begun
            task = self._running[job.id] = asyncio.create_task(self._render(job), name=f"job {job.id}")
            try:
                await asyncio.wait([task])
            finally:
                task.cancel()
                del self._running[job.id]

    def _next(self) -> RenderJob | None:
        """The oldest job of the client that has had a turn the longest ago; None where none waits."""
        last = Counter[str]()
        for job in self._jobs.values():
            last[job.client] = max(last[job.client], job.begun)
        free = (it for it in self._jobs.values() if it.state is JobState.QUEUED and it.id not in self._running)
        return min(free, key=lambda job: last[job.client], default=None)

    async def _render(self, job: RenderJob) -> None:
        if job.state is not JobState.QUEUED:
            return
        self._tell(job, JobState.RUNNING)
        try:
            await self._residency.open(job.render.scene, job.render.viewer)
            job.result = await self._result(job)
            self._tell(job, JobState.DONE)
        except (UserError, TooBusyError, RenderFaultError, WorkerLostError) as error:
            job.error = str(error)
            self._tell(job, JobState.FAILED)
        except Exception:
            log.exception("job %s failed", job.id)
            job.error = "an internal error; the server's log has the details"
            self._tell(job, JobState.FAILED)
        finally:
            self._dismiss(job.render.viewer)
            # Ended jobs are remembered for long, and what only rendering took may be megabytes.
            job.film, job.render = None, replace(job.render, edits=NO_EDITS)
        self._make_room(job)
        asyncio.get_running_loop().call_later(self._keep_seconds, self._forget, job.id)

    async def _result(self, job: RenderJob) -> bytes:
        def told(samples: int) -> None:
            self._tell(job, JobState.RUNNING, samples)

        if job.film is not None:
            frames = job.frames // job.pictures
            return await render_film(self._engines, job.render, frames, job.film, max_losses=MAX_LOSSES, told=told)
        _, image = await render_frames(
            self._engines, job.render, job.frames, Urgency.REFINING, max_losses=MAX_LOSSES, told=told
        )
        return image

    def _make_room(self, newest: RenderJob) -> None:
        """Forget the oldest jobs when they are too many, or their results too large together; the newest one stays."""
        ended = [job for job in self._jobs.values() if job.state in ENDED and job is not newest]
        total = sum(len(job.result) for job in self._jobs.values())
        while ended and (total > self._keep_bytes or len(ended) >= MAX_ENDED):
            total -= len(ended[0].result)
            self._forget(ended.pop(0).id)

    def _forget(self, job_id: str) -> None:
        self._jobs.pop(job_id, None)

    def _tell(self, job: RenderJob, state: JobState, samples: int | None = None) -> None:
        if job.state is JobState.CANCELLED:
            return
        job.state = state
        if state in ENDED:
            self.ended[state] += 1
            about = {"job": job.id, "scene": job.render.scene.id, "address": job.client}
            log.info("job %s", state, extra=about | ({"error": job.error} if job.error else {}))
        job.samples = job.samples if samples is None else samples
        job.changed.set()
        job.changed = asyncio.Event()
