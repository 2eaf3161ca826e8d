"""One worker process as the web process holds it: spoken to, and ended."""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from server.render.worker_process import KILLED_SECONDS, WorkerProcess
from server.wire.worker import FromWorker, Progress, ToWorker, pack, receive

STOP_SECONDS = 3.0  # that a worker has to end by itself
POLL_SECONDS = 0.01  # between two looks at whether it has
BUFFER_BYTES = 2**20
MAX_PROGRESS_A_SECOND = 200  # the one message that a worker may send as often as it likes


class WorkerLostError(Exception):
    """The worker process is gone, and with it the answers that it owed."""


class InnocentLossError(WorkerLostError):
    """It went with a worker that ended in another's turn: to be tried again, and nobody's fault."""


class TurnedAwayError(InnocentLossError):
    """It has not begun, and another worker is ready for it."""


class WorkerLink:
    """A running worker process and the socket to it."""

    def __init__(self, process: WorkerProcess, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._process = process
        self._reader = reader
        self._writer = writer
        self._held: list[bytes] | None = None  # what waits to be sent with others
        self._second = 0  # of the progress counted
        self._progress = 0

    @classmethod
    async def to(cls, process: WorkerProcess) -> "WorkerLink":
        """The link to a worker, which ends with it."""
        try:
            return cls(process, *await asyncio.open_connection(sock=process.socket, limit=BUFFER_BYTES))
        except BaseException:
            process.end()
            raise

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        return self._process.pid

    def send(self, message: ToWorker) -> None:
        """Send a message; they are small and few, so nothing waits for the pipe."""
        if self._held is None:
            self._writer.write(pack(message))
        else:
            self._held.append(pack(message))

    @contextmanager
    def together(self) -> Iterator[None]:
        """What is sent meanwhile goes in one writing: a call of the system for each takes longer than its message."""
        self._held = []
        try:
            yield
        finally:
            held, self._held = self._held, None
            if held:
                self._writer.write(b"".join(held))

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
        self._process.kill()
        self._writer.transport.abort()  # a process stuck in a driver may not even die

    async def stop(self) -> int | None:
        """End the worker, kindly first; its exit status (negative: the signal that ended it), None if it lives on."""
        self._writer.close()
        try:
            return await asyncio.wait_for(self._ended(), STOP_SECONDS)
        except TimeoutError:
            self.kill()
            return await self._killed()
        except asyncio.CancelledError:
            self.kill()
            await self._killed()  # else it might outlive the event loop, and nobody would take its exit status
            raise

    async def _killed(self) -> int | None:
        try:
            return await asyncio.wait_for(self._ended(), KILLED_SECONDS)
        except TimeoutError:
            self._process.leave_behind()
            return None

    async def _ended(self) -> int:
        while (status := self._process.status()) is None:
            await asyncio.sleep(POLL_SECONDS)
        return status

    def _count_progress(self) -> None:
        second = int(monotonic())
        self._progress = self._progress + 1 if second == self._second else 1
        self._second = second
        if self._progress > MAX_PROGRESS_A_SECOND:
            raise self.refuse(f"more than {MAX_PROGRESS_A_SECOND} words on its progress in a second")
