"""One worker process as the web process holds it: started, spoken to, ended."""

import asyncio
import socket
from collections.abc import Sequence

from gpu.errors import UserError
from server.messages import FromWorker, ToWorker, pack, receive

STOP_SECONDS = 3.0
BUFFER_BYTES = 2**20


class WorkerLostError(Exception):
    """The worker process is gone, and with it the answers that it owed."""


class Link:
    """A running worker process and the socket to it."""

    def __init__(
        self, process: asyncio.subprocess.Process, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self._process = process
        self._reader = reader
        self._writer = writer

    @classmethod
    async def start(cls, command: Sequence[str]) -> "Link":
        """Run `command` with the number of an inherited socket as its last argument. UserError when it cannot run.

        The socket is private to the two processes; when either ends, the other reads the end of it.
        """
        ours, theirs = socket.socketpair()
        try:
            # stdout belongs to whoever started the service; a worker's words go to the log.
            process = await asyncio.create_subprocess_exec(
                *command,
                str(theirs.fileno()),
                pass_fds=[theirs.fileno()],
                stdin=asyncio.subprocess.DEVNULL,
                stdout=2,
                start_new_session=True,
            )
        except OSError as error:
            ours.close()
            raise UserError(f"the worker process cannot be started: {error}") from None
        finally:
            theirs.close()
        return cls(process, *await asyncio.open_connection(sock=ours, limit=BUFFER_BYTES))

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        return self._process.pid

    def send(self, message: ToWorker) -> None:
        """Send a message; they are small and few, so nothing waits for the pipe."""
        self._writer.write(pack(message))

    async def receive(self) -> tuple[FromWorker, bytes]:
        """The worker's next message; WorkerLostError when there will be none."""
        try:
            message, payload = await receive(self._reader)
        except (EOFError, OSError):
            raise WorkerLostError(f"worker {self.pid} ended") from None
        except ValueError as error:
            raise WorkerLostError(f"worker {self.pid} sent what is not a message: {error}") from None
        if not isinstance(message, FromWorker):
            raise WorkerLostError(f"worker {self.pid} sent {message.kind}, which is not for it to say")
        return message, payload

    async def stop(self) -> int:
        """End the worker, kindly first, and return its exit status (negative: the signal that ended it)."""
        self._writer.close()
        try:
            return await asyncio.wait_for(self._process.wait(), STOP_SECONDS)
        except TimeoutError:
            self._process.kill()
            return await self._process.wait()
