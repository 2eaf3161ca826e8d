"""Age of frames on a slow line: `python -m tests.load.slow_line URL [MBIT/S] [ROUND TRIP MS] [SECONDS]`.

One viewer at 640×360 walks with JPEGs, with H.264, and with what the service chooses, on a line made here: packets in
a queue as short as a router's, one after the other at the line's rate, then on their way for half the round trip. It is
no network, so nothing is lost on it.
"""

import asyncio
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from time import perf_counter

import numpy as np

from server.wire.frame_header import Codec
from tests.load.target import Target
from tests.load.viewer import Plan, Seen, Viewer

PACKET_BYTES, QUEUED_PACKETS = 1448, 32
WARM_UP_SECONDS = 5.0  # in which the service gets to know the line
WISHES = {"JPEG": False, "H.264": True, "chosen": None}


@asynccontextmanager
async def line(address: tuple[str, int], rate: float, way: float) -> AsyncIterator[str]:
    """The URL of a line to `address`: so many bytes a second towards the viewer, and seconds for each way."""

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        from_service, to_service = await asyncio.open_connection(*address, limit=PACKET_BYTES)
        with suppress(OSError, asyncio.CancelledError):
            await asyncio.gather(_carry(reader, to_service, None, way), _carry(from_service, writer, rate, way))
        for end in (writer, to_service):
            end.transport.abort()

    server = await asyncio.start_server(connected, "127.0.0.1", 0)
    async with server:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"


async def _carry(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, rate: float | None, way: float) -> None:
    """Packets from one end to the other until there is no more, each after the one before as its bytes take."""
    queue: asyncio.Queue[bytes] = asyncio.Queue(QUEUED_PACKETS)
    loop = asyncio.get_running_loop()

    async def send() -> None:
        free = loop.time()
        while data := await queue.get():
            if rate:
                free = max(free, loop.time()) + len(data) / rate
                await asyncio.sleep(free - loop.time())
            loop.call_later(way, writer.write, data)

    sending = asyncio.create_task(send())
    try:
        while data := await reader.read(PACKET_BYTES):
            await queue.put(data)
        await queue.put(b"")
        await sending
    finally:
        sending.cancel()


async def walk(target: Target, rate: float, way: float, video: bool | None, seconds: float) -> list[Seen]:
    """The frames that a viewer got once the service knew the line."""
    plan = Plan((640, 360), stream={"video": video, "motion_scale": 1.0}, codecs=("jpeg", "h264"))
    async with line(target.address, rate, way) as url, target.socket(url) as socket:
        viewer = Viewer(socket, plan)
        task = asyncio.create_task(viewer.run())
        await asyncio.sleep(WARM_UP_SECONDS)
        began = perf_counter()
        await asyncio.sleep(seconds)
        task.cancel()
        await asyncio.wait([task])
    return [seen for seen in viewer.log.seen if seen.at > began]


def report(name: str, seen: list[Seen], seconds: float) -> str:
    """A line of the table."""
    ages = [it.arrived for it in seen if it.arrived is not None] or [float("nan")]
    video = sum(it.header.codec in (Codec.H264, Codec.H264_KEY) for it in seen)
    size = sum(it.size for it in seen)
    median, late = np.percentile(ages, (50, 95))
    return (
        f"{name:8} {len(seen) / seconds:5.1f} frames/s, {video:5} of {len(seen):5} video, "
        f"{8e-6 * size / seconds:6.2f} Mbit/s, age {median:5.0f} ms, p95 {late:5.0f} ms"
    )


async def main(url: str, megabits: float = 5.0, trip_ms: float = 60.0, seconds: float = 20.0) -> None:
    """Print how each kind of frames fares."""
    for name, video in WISHES.items():
        seen = await walk(Target(url), 1e6 * megabits / 8.0, trip_ms / 2e3, video, seconds)
        print(report(name, seen, seconds), flush=True)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], *(float(word) for word in sys.argv[2:])))
