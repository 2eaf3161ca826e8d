"""A worker's process, with this process's end of the socket to it, and how one is started before there is a loop."""

import asyncio
import logging
import socket
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from subprocess import DEVNULL, Popen, TimeoutExpired

from gpu.child_process import clean_environment, module_command
from gpu.errors import UserError
from server.folders import TemporaryFolder
from server.wire.worker import Start, pack

WORKER = module_command("server.worker.program")
KILLED_SECONDS = 3.0  # after which one that was killed is in the kernel for good
POLL_SECONDS = 0.01
# Else glibc has a heap for each few threads, and keeps what is free at the end of each, though it is told to trim them.
ONE_HEAP = {"MALLOC_ARENA_MAX": "1"}
log = logging.getLogger("lumenwalk.link")


class WorkerProcess:
    """A running worker. The socket is private to the two processes; when either ends, the other reads the end of it."""

    def __init__(self, command: Sequence[str], start: Start) -> None:
        """Run `command` with the number of an inherited socket as its last argument, and tell it `start`.

        UserError when it cannot run.
        """
        self.socket, theirs = socket.socketpair()
        self._temporary = _temporary_folder()
        places = {} if self._temporary is None else {"TMPDIR": str(self._temporary.path)}
        with theirs:
            try:
                # stdout belongs to whoever started the service; a worker's words go to the log.
                self._process = Popen(
                    (*command, str(theirs.fileno())),
                    pass_fds=[theirs.fileno()],
                    stdin=DEVNULL,
                    stdout=2,
                    env=ONE_HEAP | clean_environment() | places,
                    start_new_session=True,
                )
            except OSError as error:
                self.socket.close()
                self._release()
                raise UserError(f"the worker process cannot be started: {error}") from None
            self.socket.sendall(pack(start))  # it is small: nothing waits for who reads it

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        return self._process.pid

    def kill(self) -> None:
        """End it at once, whatever it does."""
        self._process.kill()

    async def ended(self) -> int:
        """Wait for its end; the exit status (negative: the signal that ended it)."""
        while (status := self._process.poll()) is None:
            await asyncio.sleep(POLL_SECONDS)
        self._release()
        return status

    def end(self) -> None:
        """Kill it and wait for its end, where no loop does."""
        self.kill()
        try:
            self._process.wait(KILLED_SECONDS)
        except TimeoutExpired:
            self.leave_behind()
        self.socket.close()
        self._release()

    def leave_behind(self) -> None:
        """It does not even die when it is killed."""
        self._release()
        log.error("worker %d does not die; it is left behind", self.pid)

    def _release(self) -> None:
        if self._temporary is not None:
            self._temporary.remove()


class Workers:
    """Starts one worker after another by a command, each of which is told the same; the first may be early."""

    def __init__(self, command: Sequence[str], start: Start) -> None:
        self._command, self.start = command, start
        self._early: WorkerProcess | None = None

    def new(self) -> WorkerProcess:
        """A worker, which is the early one if nobody has that; UserError when it cannot run."""
        early, self._early = self._early, None
        return early or WorkerProcess(self._command, self.start)

    @contextmanager
    def early(self) -> Iterator[None]:
        """Have the first worker run from now on; it is ended at the end of the context, if nobody has it by then."""
        self._early = WorkerProcess(self._command, self.start)
        try:
            yield
        finally:
            if self._early is not None:
                self._early.end()


def _temporary_folder() -> TemporaryFolder | None:
    """A folder for what compilers leave behind in a worker that is killed; None where there can be none."""
    try:
        return TemporaryFolder()
    except OSError as error:
        log.warning("no temporary folder for the worker: %s", error)
        return None
