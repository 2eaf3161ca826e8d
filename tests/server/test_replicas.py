import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import pytest

from server import replicas
from server.refusals import UnknownSceneError
from server.render.placement import LOADING_SECONDS
from server.render.worker_link import WorkerLostError
from server.replicas import Replicas

TOKEN = "correct-horse-battery-staple"


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replicas, "ASK_SECONDS", 60.0)


class Fake:
    """A replica on loopback: says what it is told to, and keeps what it was asked."""

    def __init__(self, viewers: int = 0, **scenes: bool) -> None:
        self.viewers, self.scenes, self.status = viewers, scenes, "200 OK"
        self.asked: list[str] = []
        self.body: bytes | None = None
        self.extra, self.url = "", ""

    async def answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while head := (await reader.readuntil(b"\r\n\r\n") if not reader.at_eof() else b""):
            self.asked.append(head.decode())
            ready = {"viewers": self.viewers, "workers": [{"status": "ready"}]}
            listed = [{"id": name, "loaded": loaded} for name, loaded in self.scenes.items()]
            told = json.dumps(ready if "/readyz " in self.asked[-1] else listed).encode()
            body = told if self.body is None else self.body
            writer.write(f"HTTP/1.1 {self.status}\r\nContent-Length: {len(body)}\r\n{self.extra}\r\n".encode() + body)
            await writer.drain()


@asynccontextmanager
async def served(*fakes: Fake) -> AsyncIterator[list[str]]:
    """The addresses of replicas that run."""
    async with AsyncExitStack() as stack:
        for number, fake in enumerate(fakes):
            server = await asyncio.start_server(_quietly(fake.answer), "127.0.0.1", 0)
            stack.callback(server.close)
            fake.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/r/{number}"
        yield [fake.url for fake in fakes]


def _quietly(answer: Callable[..., Awaitable[None]]) -> Callable[..., Awaitable[None]]:
    async def handle(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            await answer(reader, writer)
        except (asyncio.IncompleteReadError, ConnectionError):
            pass
        finally:
            writer.close()

    return handle


def clock() -> tuple[list[float], Callable[[], float]]:
    at = [0.0]
    return at, lambda: at[0]


async def sent(fakes: list[Fake], *scenes: str) -> list[str]:
    async with served(*fakes) as urls:
        chosen = Replicas(urls, None, clock()[1])
        return [await chosen.choose(scene) for scene in scenes]


def test_who_comes_goes_where_the_scene_is_then_where_fewest_are() -> None:
    holds, empty = Fake(3, hall=True), Fake(0, hall=False)
    assert asyncio.run(sent([empty, holds], "hall")) == ["/r/1"]
    assert asyncio.run(sent([Fake(5, hall=True), Fake(2, hall=True)], "hall")) == ["/r/1"]
    assert asyncio.run(sent([Fake(9, hall=True), Fake(0, hall=False)], "hall")) == ["/r/1"]


def test_those_who_come_at_once_are_counted_before_the_replicas_tell_of_them() -> None:
    fakes = [Fake(0, hall=True), Fake(0, hall=True)]
    assert sorted(asyncio.run(sent(fakes, *["hall"] * 4))) == ["/r/0", "/r/0", "/r/1", "/r/1"]
    assert all(len(fake.asked) == 2 for fake in fakes)


def test_a_replica_that_loads_a_scene_is_spared_others() -> None:
    fakes = [Fake(0, hall=False, attic=False), Fake(3, hall=False, attic=False)]
    assert asyncio.run(sent(fakes, "hall", "attic", "hall")) == ["/r/0", "/r/1", "/r/0"]


def test_answers_count_for_a_second_and_a_load_until_it_is_there() -> None:
    async def walk() -> None:
        at, now = clock()
        fakes = [Fake(0, hall=False, attic=False), Fake(3, hall=False, attic=False)]
        async with served(*fakes) as urls:
            chosen = Replicas(urls, None, now)
            assert await chosen.choose("hall") == "/r/0"
            at[0] = 0.9
            await chosen.choose("hall")
            assert len(fakes[0].asked) == 2
            at[0] = 2.0
            assert await chosen.choose("attic") == "/r/1"
            assert len(fakes[0].asked) == 4
            fakes[0].scenes["hall"], at[0] = True, 4.0
            fakes[1].viewers = 30
            assert await chosen.choose("attic") == "/r/0"

    asyncio.run(walk())


def test_a_load_that_never_ends_is_forgotten() -> None:
    async def walk() -> None:
        at, now = clock()
        async with served(Fake(0, hall=False, attic=False), Fake(3, hall=False, attic=False)) as urls:
            chosen = Replicas(urls, None, now)
            assert await chosen.choose("hall") == "/r/0"
            at[0] = LOADING_SECONDS + 1.0
            assert await chosen.choose("attic") == "/r/0"

    asyncio.run(walk())


def broken() -> Iterator[Fake]:
    for change in (
        {"status": "503 Service Unavailable"},
        {"status": "302 Found", "extra": "Location: http://127.0.0.1:1/\r\n"},
        {"body": b"<html>"},
        {"body": b"[]"},
        {"body": b" " * (replicas.MAX_ANSWER_BYTES + 1)},
    ):
        fake = Fake(0, hall=True)
        vars(fake).update(change)
        yield fake


def test_replicas_that_cannot_render_or_answer_otherwise_are_left_out() -> None:
    for fake in broken():
        assert asyncio.run(sent([fake, Fake(9, hall=True)], "hall")) == ["/r/1"]


def test_it_is_said_when_no_replica_can() -> None:
    for fake in broken():
        with pytest.raises(WorkerLostError, match="none of the 1 replicas"):
            asyncio.run(sent([fake], "hall"))
    with pytest.raises(UnknownSceneError, match="no 'attic'"):
        asyncio.run(sent([Fake(0, hall=True)], "attic"))


def test_nobody_waits_long_for_a_replica_that_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replicas, "ASK_SECONDS", 0.05)

    async def ask() -> None:
        silent: Any = asyncio.Event()
        server = await asyncio.start_server(_quietly(lambda *_: silent.wait()), "127.0.0.1", 0)
        url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/r/0"
        try:
            with pytest.raises(WorkerLostError):
                await Replicas([url], None).choose("hall")
        finally:
            silent.set()
            server.close()

    asyncio.run(ask())


def test_only_two_places_of_each_replica_are_asked_with_the_token() -> None:
    async def ask() -> None:
        fake = Fake(0, **{"../../secret": True})
        async with served(fake) as urls:
            await Replicas(urls, TOKEN).choose("../../secret")
        lines = [head.split("\r\n")[0] for head in fake.asked]
        assert lines == ["GET /r/0/readyz HTTP/1.1", "GET /r/0/api/v1/scenes HTTP/1.1"]
        assert all(f"authorization: bearer {TOKEN}" in head.lower() for head in fake.asked)

    asyncio.run(ask())
