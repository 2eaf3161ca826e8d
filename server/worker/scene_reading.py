"""Scenes that are read for the worker by a process of their own, behind walls, while it renders for others."""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from signal import SIGKILL
from subprocess import PIPE, Popen
from time import monotonic

from gpu.child_process import clean_environment
from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import SceneError
from gpu.scene.types import Scene
from server.scenes.checked import CheckRequest, Refused
from server.scenes.checker import CHECK, MAX_ANSWER_BYTES, ONE_THREAD, answer_of, too_long
from server.scenes.kept_scenes import seal
from server.scenes.packed_scene import read_scene
from server.wire.worker import SceneRef, Start

PATIENCE = 2  # times of the processor's time that a reader may take: others render meanwhile


def read_beside(scene: SceneRef, start: Start, packed: str = "") -> Scene:
    """The scene in a file; others may have the device until it is there. packed: where it is if it was read already.

    Raises SceneError where it is not sound or takes more memory or time than `start` allows.
    """
    if packed:
        with suppress(OSError), Path(packed).open("rb") as file:
            return read_scene(file, scene.id, start.scene_limits, DEVICE_SHARING.pause)
    result = os.memfd_create("scene", os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC)
    with os.fdopen(result, "rb") as file, os.fdopen(os.memfd_create("answer"), "rb") as answer:
        request = CheckRequest(
            source=scene.source,
            folder=None,
            limits=start.scene_limits,
            max_unpacked_bytes=0,
            memory_bytes=start.check_memory_bytes,
            seconds=start.check_seconds,
            options=scene.options,
            result=result,
        )
        status = _run(request, answer.fileno(), scene.id)
        answer.seek(0)
        said = answer_of(answer.read(MAX_ANSWER_BYTES), status, request, scene.id)
        if isinstance(said, Refused):
            raise SceneError(scene.id, said.field, said.problem)
        # Nothing that the reader has left behind can change what was checked.
        seal(result)
        return read_scene(file, scene.id, start.scene_limits, DEVICE_SHARING.pause)


def _run(request: CheckRequest, answer: int, name: str) -> int:
    """Run a reader that writes its answer to that descriptor; its exit status."""
    assert request.result is not None
    deadline = monotonic() + PATIENCE * request.seconds
    process = Popen(
        (*CHECK, str(os.getpid())),
        stdin=PIPE,
        stdout=answer,
        pass_fds=[request.result],
        env=clean_environment() | ONE_THREAD,
        start_new_session=True,
    )
    try:
        assert process.stdin is not None
        with suppress(BrokenPipeError):  # it has ended, which its status tells
            process.stdin.write(request.model_dump_json().encode())
            process.stdin.close()
        ended: Callable[[], bool] = lambda: process.poll() is not None or monotonic() > deadline  # noqa: E731
        DEVICE_SHARING.wait_for(ended)
        if process.poll() is None:
            raise SceneError(name, "", too_long(request))
        return process.returncode
    finally:
        if process.poll() is None:
            os.killpg(process.pid, SIGKILL)  # with all it has started
        process.wait()
