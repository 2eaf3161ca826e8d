"""One worker process as the web process holds it: started, spoken to, ended."""

import asyncio
import logging
import os
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from signal import SIGKILL
from time import monotonic

from gpu.child_process import clean_environment
from gpu.errors import UserError
from server.folders import TemporaryFolder
from server.wire.worker import FromWorker, Progress, ToWorker, pack, receive

STOP_SECONDS = 3.0  # that a worker has to end by itself
KILLED_SECONDS = 3.0  # after which one that was killed is in the kernel for good
BUFFER_BYTES = 2**20
MAX_PROGRESS_A_SECOND = 200  # the one message that a worker may send as often as it likes
# Else glibc has a heap for each few threads, and keeps what is free at the end of each, though it is told to trim them.
ONE_HEAP = {"MALLOC_ARENA_MAX": "1"}
log = logging.getLogger("lumenwalk.link")


class WorkerLostError(Exception):
    """The worker process is gone, and with it the answers that it owed."""


class InnocentLossError(WorkerLostError):
    """It went with a worker that ended in another's turn: to be tried again, and nobody's fault."""


class TurnedAwayError(InnocentLossError):
    """It has not begun, and another worker is ready for it."""


class WorkerLink:
    """A running worker process and the socket to it."""

    def __init__(
        self,
        process: asyncio.subprocess.Process,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        temporary: TemporaryFolder | None = None,
    ) -> None:
        """temporary: deleted when the process has ended."""
        self._process = process
        self._temporary = temporary
        self._reader = reader
        self._writer = writer
        self._second = 0  # of the progress counted
        self._progress = 0

    @classmethod
    async def start(cls, command: Sequence[str]) -> "WorkerLink":
        """Run `command` with the number of an inherited socket as its last argument. UserError when it cannot run.

        The socket is private to the two processes; when either ends, the other reads the end of it.
        """
        ours, theirs = socket.socketpair()
        with theirs:
            reader, writer = await asyncio.open_connection(sock=ours, limit=BUFFER_BYTES)
            temporary = _temporary_folder()
            places = {} if temporary is None else {"TMPDIR": str(temporary.path)}
            try:
                # stdout belongs to whoever started the service; a worker's words go to the log.
                process = await asyncio.create_subprocess_exec(
                    *command,
                    str(theirs.fileno()),
                    pass_fds=[theirs.fileno()],
                    stdin=asyncio.subprocess.DEVNULL,
                    stdout=2,
                    env=ONE_HEAP | clean_environment() | places,
                    start_new_session=True,
                )
            except BaseException as error:
                writer.transport.abort()
                if temporary is not None:
                    temporary.remove()
                if isinstance(error, OSError):
                    raise UserError(f"the worker process cannot be started: {error}") from None
                raise
        return cls(process, reader, writer, temporary)

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        return self._process.pid

    def send(self, message: ToWorker) -> None:
        """Send a message; they are small and few, so nothing waits for the pipe."""
        self._writer.write(pack(message))

    async def receive(self, most_bytes: Callable[[], int]) -> tuple[FromWorker, bytes]:
        """The worker's next message, with no more bytes than `most_bytes` allows when it comes.

        WorkerLostError when there will be none, or when it sends what it should not: then it is killed.
        """
        try:
            message, payload = await receive(self._reader, most_bytes)
        except (EOFError, OSError):
            raise WorkerLostError(f"worker {self.pid} ended") from None
        except ValueError as error:
            raise self.refuse(f"what is not a message: {error}") from None
        if not isinstance(message, FromWorker):
            raise self.refuse(f"{message.kind}, which is not for it to say")
        if isinstance(message, Progress):
            self._count_progress()
        return message, payload

    def refuse(self, what: str) -> WorkerLostError:
        """Kill a worker that sent `what`, and return the error that says so."""
        self.kill()
        return WorkerLostError(f"worker {self.pid} sent {what}")

    def kill(self) -> None:
        """End the worker at once, whatever it does; `receive` then fails."""
        if self._process.returncode is None:  # Process.kill() may take the exit status away from who waits for it
            with suppress(ProcessLookupError):
                os.kill(self.pid, SIGKILL)
        self._writer.transport.abort()  # a process stuck in a driver may not even die

    async def stop(self) -> int | None:
        """End the worker, kindly first; its exit status (negative: the signal that ended it), None if it lives on."""
        self._writer.close()
        try:
            return await self._wait(STOP_SECONDS)
        except TimeoutError:
            self.kill()
            return await self._wait_killed()
        except asyncio.CancelledError:
            self.kill()
            await self._wait_killed()  # else it might outlive the event loop, and nobody would take its exit status
            raise
        finally:
            if self._temporary is not None:
                self._temporary.remove()

    async def _wait(self, seconds: float) -> int:
        return await asyncio.wait_for(self._process.wait(), seconds)

    async def _wait_killed(self) -> int | None:
        try:
            return await self._wait(KILLED_SECONDS)
        except TimeoutError:
            log.error("worker %d does not die; it is left behind", self.pid)
            return None

    def _count_progress(self) -> None:
        second = int(monotonic())
        self._progress = self._progress + 1 if second == self._second else 1
        self._second = second
        if self._progress > MAX_PROGRESS_A_SECOND:
            raise self.refuse(f"more than {MAX_PROGRESS_A_SECOND} words on its progress in a second")


def _temporary_folder() -> TemporaryFolder | None:
    """A folder for what compilers leave behind in a worker that is killed; None where there can be none."""
    try:
        return TemporaryFolder()
    except OSError as error:
        log.warning("no temporary folder for the worker: %s", error)
        return None
