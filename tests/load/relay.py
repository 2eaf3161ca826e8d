"""A relay on the loopback address before the service: a thin way, or an ear that hears what viewers send."""

import asyncio
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

Tap = Callable[[bytes], None]
CHUNK, SMALL_BUFFER = 65_536, 4096
STEP_SECONDS = 0.1


@asynccontextmanager
async def relay(
    address: tuple[str, int], *, rate: float | None = None, at_once: int = 0, tap: Callable[[], Tap] | None = None
) -> AsyncIterator[str]:
    """The URL of a relay to `address`.

    rate: bytes a second that come through from the service on each connection, after the first `at_once` bytes; None:
    no limit. tap: makes, for each connection, what is called with the bytes that the client sends.
    """
    tasks: set[asyncio.Task[None]] = set()

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        tasks.add(task)
        with suppress(OSError, asyncio.CancelledError):
            await _connect(address, reader, writer, rate, at_once, tap() if tap else None)
        writer.transport.abort()
        tasks.discard(task)

    server = await asyncio.start_server(connected, "127.0.0.1", 0)
    try:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    finally:
        server.close()
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)


async def _connect(
    address: tuple[str, int],
    reader: asyncio.StreamReader,
    writer: asyncio.StreamWriter,
    rate: float | None,
    at_once: int,
    tap: Tap | None,
) -> None:
    """Both directions of one connection, until one of them ends."""
    family, _, _, _, place = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
    line = socket.socket(family, socket.SOCK_STREAM)
    line.setblocking(False)
    if rate:  # else the kernel takes in what the thin way should hold up
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BUFFER)
    try:
        await asyncio.get_running_loop().sock_connect(line, place)
    except OSError:
        line.close()
        raise
    limit = SMALL_BUFFER if rate else CHUNK
    from_service, to_service = await asyncio.open_connection(sock=line, limit=limit)
    try:
        up = asyncio.create_task(_pump(reader, to_service, None, 0, tap))
        down = asyncio.create_task(_pump(from_service, writer, rate, at_once, None))
        _, left = await asyncio.wait((up, down), return_when=asyncio.FIRST_COMPLETED)
        for task in left:
            task.cancel()
        await asyncio.gather(up, down, return_exceptions=True)
    finally:
        to_service.transport.abort()


async def _pump(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, rate: float | None, at_once: int, tap: Tap | None
) -> None:
    size = max(int(rate * STEP_SECONDS), 1) if rate else CHUNK
    while data := await reader.read(size):
        if tap:
            tap(data)
        writer.write(data)
        await writer.drain()
        at_once -= len(data)
        if rate and at_once < 0:
            await asyncio.sleep(len(data) / rate)
