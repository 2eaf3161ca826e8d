"""The worker process, spoken to without the engine."""

import io
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from threading import Thread
from types import UnionType
from unittest.mock import create_autospec

import pytest
from gradient_worker import (
    BUG_SEED,
    ENOUGH,
    FAULT_SEED,
    GATHER_SEED,
    LATE_FAULT_SEED,
    MEMORY,
    SLICED_SEED,
    SLOW_SECONDS,
    SLOW_SEED,
    WRONG_SEED,
)
from harness import GRADIENT_WORKER, PATIENCE, alive, wait_for

from gpu.settings import RenderSettings
from server.wire.log_format import LogFormat
from server.wire.worker import (
    Cancel,
    Cause,
    CloseScene,
    Done,
    Export,
    Exported,
    Failed,
    Free,
    FromWorker,
    Leave,
    Opened,
    OpenScene,
    Output,
    Paused,
    Pick,
    Picked,
    Ready,
    Render,
    Resume,
    SceneCamera,
    SceneRef,
    Start,
    ToWorker,
    Yield,
    pack,
    read,
)
from server.worker.tasks import Tasks
from server.worker.worker import FAULT, Backend, Picture, Worker

SCENE = SceneRef("cornell-box", "cornell-box")


class Pipe:
    """Our end of the border."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._file = connection.makefile("rb")

    def send(self, message: ToWorker) -> None:
        self._connection.sendall(pack(message))

    def read(self, kind: type[FromWorker] | UnionType) -> tuple[FromWorker, bytes]:
        """The next message of this kind and its bytes."""
        while True:
            message, payload = read(self._file)
            if isinstance(message, kind):
                return message, payload

    def close(self) -> None:
        self._file.close()
        self._connection.close()


@contextmanager
def worker() -> Iterator[tuple[Pipe, "subprocess.Popen[bytes]"]]:
    ours, theirs = socket.socketpair()
    ours.settimeout(PATIENCE)
    pipe = Pipe(ours)
    with subprocess.Popen([*GRADIENT_WORKER, str(theirs.fileno())], pass_fds=[theirs.fileno()]) as process:
        theirs.close()
        try:
            yield pipe, process
        finally:
            pipe.close()
            process.wait(PATIENCE)


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    """The border to a worker that is ready."""
    with worker() as (pipe, _):
        pipe.send(Start(SCENE))
        pipe.read(Ready)
        yield pipe


def render(request: int, output: Output = "jpeg", seed: int = 0) -> Render:
    return Render(1, SCENE, SceneCamera(0), (16, 8), RenderSettings(seed=seed), output, request=request)


def test_a_render_is_answered_with_its_image(pipe: Pipe) -> None:
    pipe.send(render(5, ".png"))
    done, image = pipe.read(Done)
    assert isinstance(done, Done)
    assert (done.request, done.size) == (5, (16, 8))
    assert image.startswith(b"\x89PNG")


def test_a_viewers_video_goes_on_from_picture_to_picture_until_it_leaves(pipe: Pipe) -> None:
    keys = []
    for request, number in ((1, 1), (2, 2), (3, 3), (4, 5)):
        pipe.send(replace(render(request, "h264"), video=number))
        done, image = pipe.read(Done)
        assert isinstance(done, Done)
        assert image.startswith(b"\0\0\0\1")
        keys.append(done.is_key)
    pipe.send(Leave(1))
    pipe.send(replace(render(5, "h264"), video=6))
    done, _ = pipe.read(Done)
    assert isinstance(done, Done)
    assert [*keys, done.is_key] == [True, False, False, True, True]


def test_a_viewer_that_leaves_in_the_middle_of_a_frame_leaves_nothing(pipe: Pipe) -> None:
    pipe.send(replace(render(1, "h264", SLICED_SEED), video=1))
    pipe.send(Yield(1))
    pipe.read(Paused)
    pipe.send(Leave(1))
    for request in range(2, 2 + ENOUGH):
        pipe.send(replace(render(request), viewer=2))
    pipe.send(Resume(1))
    for number in (1, 2):
        pipe.send(replace(render(10 + number, "h264"), video=1 + number))
    answers = [pipe.read(Done)[0] for _ in range(ENOUGH + 3)]
    keys = {answer.request: answer.is_key for answer in answers if isinstance(answer, Done)}
    assert (keys[1], keys[11], keys[12]) == (True, True, False)


def test_frames_of_several_viewers_are_on_the_device_at_once_and_end_whatever_is_said_meanwhile() -> None:
    """Neither ends alone."""
    with worker() as (pipe, _):
        pipe.send(Start(SCENE, device="lanes 2"))
        ready, _ = pipe.read(Ready)
        assert isinstance(ready, Ready)
        assert ready.lanes == 2
        pipe.send(render(1, seed=GATHER_SEED))
        for message in (Yield(1), Cancel(1), Leave(1), Resume(99)):
            pipe.send(message)
        pipe.send(replace(render(2, seed=GATHER_SEED), viewer=2))
        answers = [pipe.read(FromWorker)[0] for _ in range(4)]
    assert sorted(answer.request for answer in answers if isinstance(answer, Free)) == [1, 2]
    assert sorted(answer.request for answer in answers if isinstance(answer, Done)) == [1, 2]


def test_the_device_is_free_once_a_job(pipe: Pipe) -> None:
    pipe.send(render(1))
    pipe.send(render(2, seed=WRONG_SEED))
    pipe.send(OpenScene(SCENE, 3))
    answers = [pipe.read(Free)[0] for _ in range(3)]
    assert [answer.request for answer in answers if isinstance(answer, Free)] == [1, 2, 3]


def test_a_scene_is_opened(pipe: Pipe) -> None:
    pipe.send(OpenScene(SCENE, 9))
    opened, _ = pipe.read(Opened)
    assert isinstance(opened, Opened)
    assert (opened.request, opened.info.id) == (9, "cornell-box")


def test_an_answer_too_long_to_be_told_is_a_fault_of_one_job(pipe: Pipe) -> None:
    for message in (OpenScene(SceneRef("verbose.glb", "verbose.glb"), 1), OpenScene(SCENE, 2)):
        pipe.send(message)
    failed, _ = pipe.read(Failed)
    assert isinstance(failed, Failed)
    assert (failed.request, failed.cause) == (1, Cause.PROGRAM)
    assert pipe.read(Opened)[0].request == 2  # type: ignore[union-attr]


def test_the_scenes_on_the_device_are_told_after_each_job(pipe: Pipe) -> None:
    hall = SceneRef("hall", "hall")
    for message in (OpenScene(hall, 1), CloseScene(hall, 2)):
        pipe.send(message)
    answers = [pipe.read(Free)[0] for _ in range(2)]
    assert [answer.holdings.scenes for answer in answers if isinstance(answer, Free)] == [(SCENE, hall), (SCENE,)]


def test_what_a_job_cost_is_told(pipe: Pipe) -> None:
    pipe.send(render(1, seed=SLOW_SEED))
    free, _ = pipe.read(Free)
    assert isinstance(free, Free)
    assert free.busy_ms >= 1e3 * SLOW_SECONDS
    assert (free.holdings.memory_used, free.holdings.memory_total) == MEMORY


@pytest.mark.parametrize("seed", [FAULT_SEED, LATE_FAULT_SEED])
def test_a_device_that_fails_ends_the_worker_at_once(seed: int) -> None:
    with worker() as (pipe, process):
        pipe.send(Start(SCENE))
        pipe.read(Ready)
        pipe.send(render(1, seed=seed))
        assert process.wait(PATIENCE) == FAULT


def test_a_mistake_is_answered_with_its_text(pipe: Pipe) -> None:
    pipe.send(render(4, seed=WRONG_SEED))
    assert pipe.read(Failed)[0] == Failed(4, "settings.seed: is the wrong one", Cause.USER)


def test_a_start_that_fails_is_said_and_ends_the_worker() -> None:
    with worker() as (pipe, process):
        pipe.send(Start(SCENE, device="none"))
        assert pipe.read(Failed)[0] == Failed(0, "no device 'none' here", Cause.USER)
        assert process.wait(PATIENCE) == 0


def test_the_worker_ends_when_the_web_process_does() -> None:
    with worker() as (pipe, process):
        pipe.send(Start(SCENE))
        pipe.read(Ready)
        pipe.send(render(1, seed=SLOW_SEED))  # even while it is busy
        pipe.close()
        assert process.wait(PATIENCE) == 0


def test_the_log_has_the_format_of_the_service(capfd: pytest.CaptureFixture[str]) -> None:
    with worker() as (pipe, _):
        pipe.send(Start(SCENE, log_format=LogFormat.JSON))
        pipe.read(Ready)
        pipe.send(render(1, seed=BUG_SEED))
        pipe.read(Failed)
    (line,) = capfd.readouterr().err.splitlines()
    assert json.loads(line)["message"] == "request 1 failed"


SWITCHING = """
import socket, sys
from server.wire.worker import Leave, pack
from server.worker.worker import work
ours, theirs = socket.socketpair()
ours.sendall(pack(Leave(1)))
try:
    work(theirs.detach(), None)
except TypeError:  # not Start
    print(sys.getswitchinterval())
"""


def test_a_thread_in_python_holds_up_launches_for_a_moment_each() -> None:
    """By the interpreter's own 5 ms each, a frame with 50 launches would take a quarter of a second."""
    run = subprocess.run([sys.executable, "-c", SWITCHING], capture_output=True, text=True, check=True)
    assert float(run.stdout) <= 0.001


PARENT = """
import socket, subprocess, sys
ours, theirs = socket.socketpair()
child = subprocess.Popen([*sys.argv[1:], str(theirs.fileno())], pass_fds=[theirs.fileno()], stdout=subprocess.DEVNULL)
with ours.makefile("rb") as pipe:
    ours.sendall(sys.stdin.buffer.read())
    pipe.read(1)
print(child.pid, flush=True)
child.wait()
"""


def test_a_stopped_worker_ends_with_the_web_process() -> None:
    command = [sys.executable, "-c", PARENT, *GRADIENT_WORKER]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as parent:
        assert parent.stdin is not None
        assert parent.stdout is not None
        parent.stdin.write(pack(Start(SCENE)))
        parent.stdin.close()
        worker_pid = int(parent.stdout.readline())
        os.kill(worker_pid, signal.SIGSTOP)
        parent.kill()
    wait_for(lambda: not alive(worker_pid))


def test_a_pick_is_answered_in_its_turn(pipe: Pipe) -> None:
    pipe.send(Pick(SCENE, SceneCamera(0), (8, 4), (0.25, 0.5), request=1))
    free, _ = pipe.read(Free)
    assert isinstance(free, Free)
    picked, payload = pipe.read(Picked)
    assert isinstance(picked, Picked)
    assert (free.request, picked.request, picked.part.object, payload) == (1, 1, "chair", b"")


def test_an_export_is_answered_with_the_file(pipe: Pipe) -> None:
    pipe.send(Export(SCENE, request=1))
    exported, payload = pipe.read(Exported)
    assert isinstance(exported, Exported)
    assert (exported.request, payload) == (1, b"glTF with no edits")


def test_looks_for_messages_end_however_short_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Tasks, "poll_seconds", 1e-6)
    backend = create_autospec(Backend, instance=True)
    ours, theirs = socket.socketpair()
    with ours, theirs:
        worker = Worker(theirs, lambda _: backend)
        worker._backend = backend

        def look() -> None:
            for viewer in range(2000):
                worker._inbox.put(Leave(viewer))
                worker._step()
                worker._step()  # there is none

        thread = Thread(target=look, daemon=True)
        thread.start()
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert backend.leave.call_count == 2000


def test_a_picture_that_the_device_has_encoded_is_sent_at_once_with_the_end_of_its_turn() -> None:
    backend = create_autospec(Backend, instance=True)
    backend.render.return_value = Picture(1, 4, b"image", 0.25, None, None, {}, {}, {})
    backend.memory.return_value, backend.scenes.return_value = MEMORY, (SCENE,)
    connection = create_autospec(socket.socket, instance=True)
    worker = Worker(connection, lambda _: backend)
    worker._backend = backend
    worker._inbox.put(render(5))
    worker._step()
    (sent,) = (call.args[0] for call in connection.sendall.call_args_list)
    pipe = io.BytesIO(sent)
    (free, _), (done, image) = read(pipe), read(pipe)
    assert isinstance(free, Free)
    assert isinstance(done, Done)
    assert (free.request, done.request, done.encode_ms, image, pipe.read()) == (5, 5, 0.25, b"image", b"")
