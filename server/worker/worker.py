"""The worker process's loop: jobs from the web process, as many as the device has lanes, pictures encoded in threads
meanwhile.

The web process sends the next job when it hears that one has left the device, or pauses, so the queue, its fairness and
the newest pose stay there and nothing waits here. One thread takes jobs and goes on with those whose frames are ready;
what renders is a `Backend`; server.worker.program has the real one.
"""

import logging
import os
import signal
import socket
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from queue import Empty, Queue
from threading import Lock, Thread
from time import perf_counter
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import OutOfMemoryError, UserError, brief
from server.logs import configure
from server.scenes.kernel import PR_SET_PDEATHSIG, process_control
from server.video.live_video import LiveVideo
from server.wire.browser import PickedPart, SceneInfo
from server.wire.worker import (
    START_UP,
    Cancel,
    Cause,
    Closed,
    CloseScene,
    Done,
    Export,
    Exported,
    Failed,
    Free,
    FromWorker,
    Holdings,
    Job,
    Leave,
    Opened,
    OpenScene,
    Paused,
    Pick,
    Picked,
    Progress,
    Ready,
    Render,
    Resume,
    SceneRef,
    Start,
    ToWorker,
    Yield,
    pack,
    read,
)
from server.worker.encode import encode
from server.worker.reporter import Reporter
from server.worker.tasks import CancelledError, Tasks, Turn
from server.worker.turn_clock import TurnClock

FAULT = 70  # exit status after a fault that only a new process can mend
MOST_WORDS = 4000  # characters of a failure's text
# That a thread in Python, such as one at the source of a kernel, may hold up the one that renders, which leaves the
# interpreter for each of a frame's many launches.
SWITCH_SECONDS = 0.0005
QUIET_SECONDS = 0.3  # work shorter than this reports no progress
INTERNAL = "an internal error of the renderer; the server's log has the details"

Report = Callable[[str, float], None]
log = logging.getLogger("lumenwalk.worker")


@dataclass(frozen=True)
class Picture:
    """A rendered picture on the host, no longer shared with the renderer, and its statistics.

    samples: frames averaged in it, of `target` that a still view is to have. image: encoded on the device already, in
    encode_ms; else None. pixels: (height, width, 3) uint8 sRGB; radiance: (height, width, 3) float32 linear; None where
    not asked for.
    """

    samples: int
    target: int
    image: bytes | None
    encode_ms: float
    pixels: NDArray[np.uint8] | None
    radiance: NDArray[np.float32] | None
    stage_ms: dict[str, float]
    counts: dict[str, int]
    skips: dict[str, int]
    estimates: dict[str, float] = field(default_factory=dict)


class Backend(Protocol):
    """What renders. All calls come from one thread, from jobs that may interrupt each other (gpu.core.sharing);
    UserError is the user's fault, all else the program's.
    """

    @property
    def lanes(self) -> int:
        """How many pictures may be on the device at once, which has been started."""

    def start(self, start: Start, report: Report, tasks: Tasks) -> str:
        """Choose a device, load the served scene, render one frame of it; return the device's name.

        tasks: the jobs to come; told how long a turn is on this device.
        """

    def open(self, scene: SceneRef, report: Report, packed: str = "") -> SceneInfo:
        """Make sure that a scene is loaded."""

    def beside(self, scene: SceneRef) -> dict[str, int]:
        """Files that a scene, which is loaded, was read with (gpu.scene.types.LoadReport)."""

    def render(self, job: Render, report: Report) -> Picture:
        """Render one picture."""

    def pick(self, job: Pick, report: Report) -> PickedPart:
        """Say what a camera sees at one point of its picture."""

    def export(self, job: Export, report: Report) -> bytes:
        """Write a scene as a GLB file."""

    def close(self, scene: SceneRef) -> None:
        """Free a scene and all that was made for it; nothing happens when it is not loaded."""

    def leave(self, viewer: int) -> None:
        """Free what is kept for a viewer."""

    def scenes(self) -> tuple[SceneRef, ...]:
        """The scenes that are loaded, the longest unused first."""

    def memory(self) -> tuple[int, int]:
        """Memory of the device in use, and all of it [bytes]."""

    def healthy(self) -> bool:
        """Whether the device still works after an unexpected error."""


class Worker:
    """Takes messages from a socket to the backend and its answers back."""

    _backend: Backend  # since it was started

    def __init__(self, connection: socket.socket, make: Callable[[Start], Backend]) -> None:
        self._connection = connection
        self._make = make
        self._sending = Lock()
        # A SimpleQueue waits for ever where a short wait is over before it has begun to wait.
        self._inbox: Queue[ToWorker] = Queue()
        self._tasks, self._clock = Tasks(), TurnClock()
        self._tasks.others_wait = lambda: not self._inbox.empty()
        self._under_way: dict[int, Render] = {}  # what is rendered, by request
        self._left_behind: set[int] = set()  # of these, those whose viewer has left
        cores = min(8, os.cpu_count() or 1)
        self._encoders = ThreadPoolExecutor(cores, thread_name_prefix="encode")
        self._videos = LiveVideo()
        self._video_threads = [ThreadPoolExecutor(1, thread_name_prefix="video") for _ in range(cores)]

    def run(self) -> int:
        """Serve until the web process is gone, which ends this process; returns the exit status of a failed start."""
        Thread(target=self._read, daemon=True, name="read").start()
        start = self._inbox.get()
        if not isinstance(start, Start):
            raise TypeError(f"expected Start first, got {start}")
        configure(start.log_format)
        self._send(Progress("starting", 0.0))
        try:
            report = self._reporter(quiet_seconds=0.0)
            self._backend = self._make(start)
            device = self._backend.start(start, report, self._tasks)
            report.end()
            DEVICE_SHARING.begin(self._tasks)
            self._send(Ready(device, self._holdings(), self._backend.lanes))
        except Exception as error:
            self._fail(START_UP, error)
            return 0 if isinstance(error, UserError) else FAULT
        while True:
            try:
                self._step()
            except Exception:
                log.critical("this worker cannot go on", exc_info=True)
                os._exit(FAULT)

    def _step(self) -> None:
        """Go on with a job that can, and take the next message, if there are any."""
        ready = self._tasks.ready()
        if ready is not None:
            self._take_turn(ready, partial(self._tasks.resume, ready))
        waits = ready is None
        try:
            message = self._inbox.get(waits, self._tasks.poll_seconds)
        except Empty:
            return
        self._handle(message)

    def _video_thread(self, viewer: int) -> ThreadPoolExecutor:
        """The one that encodes a viewer's video, whose pictures must stay in order."""
        return self._video_threads[viewer % len(self._video_threads)]

    def _handle(self, message: ToWorker) -> None:
        match message:
            case Leave(viewer):
                self._leave(viewer)
                self._left_behind.update(it.request for it in self._under_way.values() if it.viewer == viewer)
            case OpenScene() | CloseScene() | Render() | Pick() | Export():
                self._take_turn(message.request, lambda: self._tasks.start(message.request, partial(self._do, message)))
            case Resume(request) if self._tasks.knows(request):  # it may have ended in another's turn meanwhile
                self._take_turn(request, lambda: self._tasks.resume(request))

    def _leave(self, viewer: int) -> None:
        self._backend.leave(viewer)
        self._video_thread(viewer).submit(self._videos.forget, viewer)  # behind its last picture

    def _take_turn(self, request: int, turn: Callable[[], Turn]) -> None:
        """Begin or go on with a job's turn."""
        self._clock.begin(request)
        match turn():
            case Turn.GIVEN_BACK:
                self._send(Paused(request, self._busy_ms(request), self._holdings()))
            case Turn.OPEN if self._tasks.waits(request):
                self._clock.wait(request)

    def _busy_ms(self, request: int) -> float:
        return 1e3 * self._clock.end(request)

    def _read(self) -> None:
        # The end of the pipe is the end of the web process: nothing is left to do, whatever the device is busy with.
        with self._connection.makefile("rb") as pipe:
            try:
                while True:
                    message, _ = read(pipe)
                    match message:
                        case Yield(request):
                            self._tasks.ask_back(request)
                        case Cancel(request):
                            self._tasks.cancel(request)
                        case _ if isinstance(message, ToWorker):
                            self._inbox.put(message)
            except (EOFError, OSError):
                os._exit(0)

    def _do(self, job: Job) -> None:
        report = self._reporter(QUIET_SECONDS)
        began = DEVICE_SHARING.own_time()
        answer: FromWorker | None = None  # sent when all know what it changed
        file = b""
        try:
            match job:
                case OpenScene(scene):
                    info = self._backend.open(scene, report, job.packed)
                    answer = Opened(job.request, info, self._backend.beside(scene))
                case CloseScene(scene):
                    self._backend.close(scene)
                    answer = Closed(job.request)
                case Pick():
                    answer = Picked(job.request, self._backend.pick(job, report))
                case Export():
                    file = self._backend.export(job, report)
                    answer = Exported(job.request)
                case Render():
                    self._under_way[job.request] = job
                    picture = self._backend.render(job, report)
                    render_ms = 1e3 * (DEVICE_SHARING.own_time() - began) - picture.encode_ms
                    if picture.image is None:
                        encoders = self._video_thread(job.viewer) if job.output == "h264" else self._encoders
                        encoders.submit(self._finish, job, picture, render_ms)
                    else:
                        answer, file = _done(job, picture, render_ms, picture.encode_ms), picture.image
        except Exception as error:
            # Whatever the error says: after an illegal access even an allocation fails, as if memory were short.
            self._check_health(error)
            self._fail(job.request, error)
        except CancelledError:
            self._fail(job.request, UserError("cancelled"))
        report.end()
        if (rendered := self._under_way.pop(job.request, None)) and job.request in self._left_behind:
            self._left_behind.remove(job.request)
            self._leave(rendered.viewer)  # again: its last frame was still in the making
        self._end(Free(job.request, self._busy_ms(job.request), self._holdings()), answer, file)

    def _holdings(self) -> Holdings:
        return Holdings(*self._backend.memory(), self._backend.scenes())

    def _check_health(self, error: Exception) -> None:
        if not self._backend.healthy():
            log.critical("the device does not work any more: ending this worker", exc_info=error)
            os._exit(FAULT)

    def _finish(self, job: Render, picture: Picture, render_ms: float) -> None:
        try:
            began = perf_counter()
            is_key = True
            if job.output == "h264" and picture.pixels is not None:
                image, is_key = self._videos.encode(job.viewer, job.video, picture.pixels)
            else:
                image = encode(picture.pixels, picture.radiance, job.output, job.quality)
            encode_ms = picture.encode_ms + 1e3 * (perf_counter() - began)
            self._send(_done(job, picture, render_ms, encode_ms, is_key=is_key), image)
        except Exception as error:
            self._fail(job.request, error)

    def _end(self, free: Free, answer: FromWorker | None, file: bytes) -> None:
        """A job has left the device, and is answered, if that is not done elsewhere: both in one writing."""
        try:
            packed = b"" if answer is None else pack(answer, file)
        except ValueError as error:  # it cannot be told: that is a fault, and not one to die of
            self._fail(free.request, error)
            packed = b""
        self._write(pack(free) + packed)

    def _fail(self, request: int, error: Exception) -> None:
        users_fault = isinstance(error, UserError)
        if not users_fault:
            log.error("request %d failed", request, exc_info=error)
        memory = isinstance(error, OutOfMemoryError)
        cause = Cause.MEMORY if memory else Cause.USER if users_fault else Cause.PROGRAM
        self._send(Failed(request, brief(str(error), MOST_WORDS) if users_fault else INTERNAL, cause))

    def _reporter(self, quiet_seconds: float) -> Reporter:
        return Reporter(lambda text, fraction: self._send(Progress(text, fraction)), quiet_seconds)

    def _send(self, message: FromWorker, payload: bytes = b"") -> None:
        self._write(pack(message, payload))

    def _write(self, packed: bytes) -> None:
        try:
            with self._sending:
                self._connection.sendall(packed)
        except OSError:
            os._exit(0)  # the web process is gone


def _done(job: Render, picture: Picture, render_ms: float, encode_ms: float, *, is_key: bool = True) -> Done:
    stats = (picture.stage_ms, picture.counts, picture.skips, picture.estimates)
    return Done(job.request, job.size, render_ms, encode_ms, picture.samples, picture.target, *stats, is_key)


def _end_with_parent() -> None:
    """Be killed when the process that started this one ends: one that is stopped does not read that its pipe ended."""
    with suppress(OSError):
        process_control(PR_SET_PDEATHSIG, signal.SIGKILL)


def work(descriptor: int, make: Callable[[Start], Backend]) -> int:
    """Run a worker on the inherited socket `descriptor`; returns the process's exit status.

    make: what renders for a service that was started so.
    """
    # What a terminal sends goes to both processes: the web process ends this one when it is done.
    for sign in (signal.SIGINT, signal.SIGHUP):
        signal.signal(sign, signal.SIG_IGN)
    _end_with_parent()
    sys.setswitchinterval(SWITCH_SECONDS)
    with socket.socket(fileno=descriptor) as connection:
        return Worker(connection, make).run()
