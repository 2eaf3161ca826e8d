"""A worker's process, with this process's end of the socket to it.

Little is imported here, so that the first worker can run before all else is imported.
"""

import logging
import socket
from collections.abc import Sequence
from subprocess import DEVNULL, Popen, TimeoutExpired
from typing import Self

from gpu.child_process import clean_environment, module_command
from gpu.errors import UserError
from server.folders import TemporaryFolder

WORKER = module_command("server.worker.program")
KILLED_SECONDS = 3.0  # after which one that was killed is in the kernel for good
# Else glibc has a heap for each few threads, and keeps what is free at the end of each, though it is told to trim them.
ONE_HEAP = {"MALLOC_ARENA_MAX": "1"}
log = logging.getLogger("lumenwalk.link")


class WorkerProcess:
    """A running worker. The socket is private to the two processes; when either ends, the other reads the end of it."""

    def __init__(self, command: Sequence[str]) -> None:
        """Run `command` with the number of an inherited socket as its last argument; UserError when it cannot run."""
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

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        return self._process.pid

    def kill(self) -> None:
        """End it at once, whatever it does."""
        self._process.kill()

    def status(self) -> int | None:
        """The exit status (negative: the signal that ended it) once it has ended."""
        status = self._process.poll()
        if status is not None:
            self._release()
        return status

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def end(self) -> None:
        """Kill it, if it still runs, and wait for its end, where no loop does."""
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


def _temporary_folder() -> TemporaryFolder | None:
    """A folder for what compilers leave behind in a worker that is killed; None where there can be none."""
    try:
        return TemporaryFolder()
    except OSError as error:
        log.warning("no temporary folder for the worker: %s", error)
        return None
