import asyncio
from time import perf_counter

import httpx

from tests.load.crowd import wait_for, walking
from tests.load.recorder import Recorder
from tests.load.relay import relay
from tests.load.target import Target
from tests.load.viewer import Plan

SMALL = Plan(size=(96, 54))


async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Repeats what it is asked, 3000 times."""
    data = await reader.read(100)
    writer.write(3000 * data)
    writer.close()


async def ask(rate: float | None, at_once: int = 0) -> tuple[bytes, float]:
    """What came through a relay, and how long it took."""
    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    async with server, relay(server.sockets[0].getsockname(), rate=rate, at_once=at_once) as url:
        reader, writer = await asyncio.open_connection("127.0.0.1", int(url.rpartition(":")[2]))
        began = perf_counter()
        writer.write(b"x")
        came = await reader.read(-1)
        writer.close()
        return came, perf_counter() - began


def test_a_thin_way_brings_everything_at_its_rate() -> None:
    came, seconds = asyncio.run(ask(rate=3000.0))
    assert came == 3000 * b"x"
    assert seconds > 0.7
    came, sooner = asyncio.run(ask(rate=3000.0, at_once=3000))
    assert came == 3000 * b"x"
    assert sooner < seconds


def test_viewers_walk_through_a_relay_as_they_do_without(target: Target) -> None:
    async def visit() -> int:
        async with relay(target.address) as url, walking(target, SMALL, url) as viewer:
            await wait_for(lambda: len(viewer.log.seen) > 3, 20.0)
            return len(viewer.log.seen)

    assert asyncio.run(visit()) > 3


def test_a_recorder_hears_the_poses_of_who_walks_first(target: Target) -> None:
    recorder = Recorder()

    async def visit() -> int:
        async with relay(target.address, tap=recorder.tap) as url, httpx.AsyncClient(base_url=url) as http:
            assert (await http.get("/")).status_code == 200
            async with walking(target, SMALL, url) as viewer:
                await wait_for(lambda: len(viewer.log.seen) > 3, 20.0)
                async with walking(target, SMALL, url) as other:
                    await wait_for(lambda: len(other.log.seen) > 3, 20.0)
            return viewer.log.poses

    poses = asyncio.run(visit())
    assert poses - 1 <= len(recorder.views) <= poses
    assert recorder.times == sorted(recorder.times)
    assert len(set(recorder.views)) == len(recorder.views)
