"""Scenes read in a child process first, with limits on its memory and time, so that no file can harm the service.

The child is server.scenes.check_scene. What it says of a scene is all that the web process ever learns from the file.
"""

import asyncio
import logging
import os
import signal
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from gpu.child_process import clean_environment, module_command
from gpu.errors import SceneError
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from server.places import Places, asker
from server.refusals import TooBusyError
from server.scenes import walls
from server.scenes.archives import UnpackedError
from server.scenes.checked import Checked, CheckRequest, Refused
from server.scenes.kept_scenes import KEPT_SECONDS, KeptScene, KeptScenes
from server.settings import ServerSettings

CHECK = module_command("server.scenes.check_scene")
AT_ONCE = 2
MAX_WAITING, MAX_WAITING_OF_ONE = 32, 16
MAX_ANSWER_BYTES = 2**24  # of what a child says of a scene, which may no longer do as it was told
log = logging.getLogger("lumenwalk.checker")


_answer: TypeAdapter[Checked | Refused] = TypeAdapter(Checked | Refused)


def answer_of(output: bytes, status: int, request: CheckRequest, name: str) -> Checked | Refused:
    """What a child said of the scene that is called `name`, which ended with that status; SceneError if nothing."""
    try:
        return _answer.validate_json(output)
    except ValidationError:
        raise SceneError(name, "", _death(status, request)) from None


def too_long(request: CheckRequest) -> str:
    """What is wrong with a scene that takes longer to read than may be."""
    return f"takes more than {request.seconds:g} s to read; simplify it, or raise check_seconds of this server"


def _death(status: int, request: CheckRequest) -> str:
    """Why a child ended without an answer."""
    if status == -signal.SIGXCPU:
        return too_long(request)
    if status == -signal.SIGKILL:  # nobody here did it
        return (
            f"its reader was killed by the system, which ran out of memory; simplify it, or give the service more "
            f"than the {request.memory_bytes} bytes of check_memory_bytes"
        )
    ended = signal.Signals(-status).name if status < 0 else f"status {status}"
    return (
        f"cannot be read: its reader ended with {ended}; the file is broken, or needs more than the "
        f"{request.memory_bytes} bytes of check_memory_bytes of this server, whose log may have more"
    )


# Threads of libraries would reserve memory. The last keeps USD from printing that its limit is set.
ONE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "PXR_WORK_THREAD_LIMIT": "1",
    "TF_ENV_SETTING_ALERTS_ENABLED": "0",
}


class Checker:
    """Runs a few children at a time."""

    def __init__(self, settings: ServerSettings, command: Sequence[str] = CHECK) -> None:
        self._limits, self._in_environment = settings.scene_limits, settings.environment is not None
        self._memory_bytes = settings.check_memory_bytes
        self._seconds = settings.check_seconds
        self._command = command
        self._turns = asyncio.Semaphore(AT_ONCE)
        for wall in walls.missing():
            log.debug("this kernel has no %s: readers of scenes do without", wall)
        self._places = Places("scenes that are read or wait for it", MAX_WAITING, MAX_WAITING_OF_ONE)
        self.kept = KeptScenes()
        self.outcomes = Counter({"sound": 0, "refused": 0})  # of all that was read, since the service began

    async def check(
        self,
        source: str,
        name: str,
        folder: str | None = None,
        options: ImportOptions = DEFAULT_OPTIONS,
        max_unpacked_bytes: int = 0,
    ) -> Checked:
        """What is in the scene `source`, read as `options` say; `name` is what viewers call it; an archive is unpacked
        into `folder`, of up to `max_unpacked_bytes`. All but archives are kept for the worker that is to have them.

        Raises SceneError when the scene is not sound or takes more memory or time than allowed (UnpackedError for an
        archive that is too large), TooBusyError when too many scenes wait to be checked.
        """
        kept: KeptScene | None = None
        if folder is None:
            with suppress(OSError):  # then it is read again
                kept = KeptScene(source, options)
        request = CheckRequest(
            source=source,
            folder=folder,
            options=options,
            limits=self._limits,
            max_unpacked_bytes=max_unpacked_bytes,
            memory_bytes=self._memory_bytes,
            seconds=self._seconds,
            in_environment=self._in_environment,
            result=kept.memory if kept is not None else None,
        )
        try:
            with self._places.taken(asker.get()):
                async with self._turns:
                    answer = await self._run(request, name)
            if isinstance(answer, Refused) and answer.unpacked_bytes is not None:
                raise UnpackedError(name, answer.unpacked_bytes, max_unpacked_bytes)
            if isinstance(answer, Refused):
                raise SceneError(name, answer.field, answer.problem)
        except SceneError:
            self.outcomes["refused"] += 1
            raise
        self.outcomes["sound"] += 1
        if kept is not None:
            self.kept.keep(kept)
            asyncio.get_running_loop().call_later(KEPT_SECONDS, self.kept.forget, kept.key)
        info = answer.info.model_copy(update={"id": name, "name": Path(name).stem})  # not where it is kept
        return answer.model_copy(update={"info": info})

    async def _run(self, request: CheckRequest, name: str) -> Checked | Refused:
        try:
            process = await asyncio.create_subprocess_exec(
                *self._command,
                str(os.getpid()),
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                pass_fds=() if request.result is None else (request.result,),
                env=clean_environment() | ONE_THREAD,
                start_new_session=True,
            )
        except OSError as error:
            raise TooBusyError(f"no process can be started to read {name}: {error.strerror or error}") from None
        try:
            async with asyncio.timeout(self._seconds):
                output = await _conversation(process, request)
                if len(output) > MAX_ANSWER_BYTES:
                    raise SceneError(name, "", "cannot be read: its reader says more than there is; the file is broken")
                await process.wait()
        except TimeoutError:
            raise SceneError(name, "", too_long(request)) from None
        finally:
            await _end(process)
        assert process.returncode is not None
        return answer_of(output, process.returncode, request, name)


async def _conversation(process: asyncio.subprocess.Process, request: CheckRequest) -> bytes:
    """What a child says when it is asked, as far as it is no more than a byte too long."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(request.model_dump_json().encode())
    process.stdin.close()
    try:
        return await process.stdout.readexactly(MAX_ANSWER_BYTES + 1)
    except asyncio.IncompleteReadError as answer:
        return answer.partial


async def _end(process: asyncio.subprocess.Process) -> None:
    """Kill a child that has not ended, and all it has started, which may outlive it.

    What it has said is read to the end: until then asyncio does not count it as ended, however dead it is.
    """
    assert process.stdout is not None
    if process.returncode is None or not process.stdout.at_eof():
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    while await process.stdout.read(2**16):
        pass
    await process.wait()
