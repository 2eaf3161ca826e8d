"""Scenes that are read for the worker by a process of their own, behind walls, while it renders for others."""

import os
from contextlib import suppress
from pathlib import Path
from signal import SIGKILL
from subprocess import PIPE, Popen
from time import monotonic

from gpu.child_process import clean_environment
from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import SceneError
from gpu.scene.builtin import BUILTIN
from gpu.scene.types import Scene
from server.scenes.checked import CheckRequest, Refused
from server.scenes.checker import CHECK, MAX_ANSWER_BYTES, ONE_THREAD, answer_of, too_long
from server.scenes.kept_scenes import seal
from server.scenes.packed_scene import read_scene
from server.wire.worker import SceneRef, Start

PATIENCE = 2  # times of the processor's time that a reader may take: others render meanwhile


class SceneReading:
    """A process that reads the scene `ref`, from now on."""

    def __init__(self, ref: SceneRef, start: Start) -> None:
        """As `start` allows a file; a built-in scene has the usual limits, whatever those are."""
        if ref.source in BUILTIN:
            start = Start(ref)
        self.ref, self._limits, self._seconds = ref, start.scene_limits, start.check_seconds
        self._result = os.fdopen(os.memfd_create("scene", os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC), "rb")
        self._answer = os.fdopen(os.memfd_create("answer"), "rb")
        self._request = CheckRequest(
            source=ref.source,
            folder=None,
            limits=start.scene_limits,
            max_unpacked_bytes=0,
            memory_bytes=start.check_memory_bytes,
            seconds=start.check_seconds,
            options=ref.options,
            result=self._result.fileno(),
        )
        self._process = Popen(
            (*CHECK, str(os.getpid())),
            stdin=PIPE,
            stdout=self._answer,
            pass_fds=[self._result.fileno()],
            env=clean_environment() | ONE_THREAD,
            start_new_session=True,
        )
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # it has ended, which its status tells
            self._process.stdin.write(self._request.model_dump_json().encode())
            self._process.stdin.close()

    def scene(self) -> Scene:
        """The scene, once: others may have the device until it is there.

        Raises SceneError where it is not sound or takes more memory or time than allowed.
        """
        with self._result, self._answer:
            status = self._ended()
            self._answer.seek(0)
            said = answer_of(self._answer.read(MAX_ANSWER_BYTES), status, self._request, self.ref.id)
            if isinstance(said, Refused):
                raise SceneError(self.ref.id, said.field, said.problem)
            # Nothing that the reader has left behind can change what was checked.
            seal(self._result.fileno())
            return read_scene(self._result, self.ref.id, self._limits, DEVICE_SHARING.pause)

    def _ended(self) -> int:
        """Wait for the process; its exit status."""
        deadline = monotonic() + PATIENCE * self._seconds
        try:
            DEVICE_SHARING.wait_for(lambda: self._process.poll() is not None or monotonic() > deadline)
            if self._process.poll() is None:
                raise SceneError(self.ref.id, "", too_long(self._request))
            return self._process.returncode
        finally:
            if self._process.poll() is None:
                os.killpg(self._process.pid, SIGKILL)  # with all it has started
            self._process.wait()


def read_beside(scene: SceneRef, start: Start, packed: str = "") -> Scene:
    """A scene, read by a process of its own; packed: where it is if it was read already. Errors as of SceneReading."""
    if packed:
        with suppress(OSError), Path(packed).open("rb") as file:
            return read_scene(file, scene.id, start.scene_limits, DEVICE_SHARING.pause)
    return SceneReading(scene, start).scene()
