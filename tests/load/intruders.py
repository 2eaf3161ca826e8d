"""`python -m tests.load.intruders HOST PORT SILENT CHUNKED KNOCKING ASKING`: who has no token and besets a service.

A process of its own, so that what it costs is not the walkers' loss; it ends with its standard input. Connections that
the service ends are made again, at once. Only addresses of this machine are taken.
"""

import asyncio
import resource
import sys
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress

from server.addresses import is_loopback

CHUNKS = b"1\r\nx\r\n" * 10_000
HEAD = b"POST /healthz HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
AGAIN_SECONDS = 0.5  # between two connections of one who is not in a hurry


async def silent(host: str, port: int) -> None:
    """Connect and say nothing."""
    reader, writer = await asyncio.open_connection(host, port)
    try:
        await reader.read()
    finally:
        writer.close()


async def chunks(host: str, port: int) -> None:
    """A body of one-byte chunks without end, as fast as it is taken."""
    _, writer = await asyncio.open_connection(host, port)
    try:
        writer.write(HEAD)
        while not writer.is_closing():
            writer.write(CHUNKS)
            await writer.drain()
    finally:
        writer.close()


async def knock(host: str, port: int) -> None:
    """Connect and leave."""
    _, writer = await asyncio.open_connection(host, port)
    writer.close()


async def ask(host: str, port: int) -> None:
    """Ask for the page, over a connection of its own."""
    reader, writer = await asyncio.open_connection(host, port)
    try:
        writer.write(b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        await reader.read()
    finally:
        writer.close()


async def again(what: Callable[[str, int], Awaitable[None]], host: str, port: int, pause: float) -> None:
    """Do it again whenever it ends, with a `pause` [s]."""
    while True:
        with suppress(OSError):
            await what(host, port)
        await asyncio.sleep(pause)


async def intrude(host: str, port: int, counts: Sequence[int]) -> None:
    """All of them, until standard input ends."""
    pauses = AGAIN_SECONDS, AGAIN_SECONDS, 0.0, 0.0
    kinds = zip((silent, chunks, knock, ask), counts, pauses, strict=True)
    tasks = [asyncio.create_task(again(what, host, port, pause)) for what, n, pause in kinds for _ in range(n)]
    await asyncio.to_thread(sys.stdin.read)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def main() -> int:
    """Run as asked; 2 for another machine."""
    host, port, *counts = sys.argv[1:]
    if not is_loopback(host):
        print("only services of this machine", file=sys.stderr)
        return 2
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(max(soft, 4096), hard), hard))
    asyncio.run(intrude(host, int(port), [int(count) for count in counts]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
