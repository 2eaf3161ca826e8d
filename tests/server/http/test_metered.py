"""What answering takes is charged to whoever asks."""

import asyncio
from collections.abc import Callable
from time import thread_time
from types import SimpleNamespace
from typing import Any

import pytest
from harness import Running, Walker
from websockets.exceptions import ConnectionClosed

from server.http.connection import KEY, Connection
from server.http.metered import FREE_SECONDS, MOST_SECONDS, TRUSTED_MOST_SECONDS, Meter, Metered, charger
from server.rate_limit import Buckets

LONG = 5 * FREE_SECONDS


def work(seconds: float) -> None:
    end = thread_time() + seconds
    while thread_time() < end:
        pass


def test_turns_that_let_others_wait_are_counted_and_waiting_is_not() -> None:
    charged: list[float] = []

    async def turns() -> str:
        work(LONG)
        await asyncio.sleep(0.01)
        work(2 * LONG)
        return "done"

    async def run() -> str:
        return await Metered(turns(), charged.append)

    assert asyncio.run(run()) == "done"
    assert [*map(bool, charged)] == [True, True]
    assert charged[0] >= LONG - FREE_SECONDS
    assert charged[1] >= 2 * LONG - FREE_SECONDS


def test_short_turns_are_free() -> None:
    charged: list[float] = []

    async def turns() -> None:
        for _ in range(100):
            await asyncio.sleep(0)

    async def run() -> None:
        await Metered(turns(), charged.append)

    asyncio.run(run())
    assert sum(charged) < 100 * FREE_SECONDS  # but for what the machine itself takes now and then


def test_errors_and_ends_pass_and_count() -> None:
    charged: list[float] = []

    async def waits() -> None:
        try:
            await asyncio.sleep(60.0)
        finally:
            work(LONG)

    async def fails() -> None:
        work(LONG)
        raise ValueError("so")

    async def run() -> None:
        async def metered() -> None:
            await Metered(waits(), charged.append)

        task = asyncio.create_task(metered())
        await asyncio.sleep(0)
        task.cancel()
        await asyncio.wait([task])
        assert task.cancelled()
        with pytest.raises(ValueError, match="so"):
            await Metered(fails(), charged.append)

    asyncio.run(run())
    assert len(charged) == 2


class Fake(Connection):
    """A connection without a socket, that is trusted after `trust`."""

    def __init__(self) -> None:
        self.trusted = False
        self.charged = 0.0

    def trust(self) -> None:
        self.trusted = True

    def charge(self, seconds: float) -> None:
        self.charged += seconds


@pytest.mark.parametrize(
    ("kind", "trusted", "of_connection", "of_client"),
    [("http", False, True, False), ("http", True, False, True), ("websocket", True, True, True)],
)
def test_who_is_charged(kind: str, trusted: bool, of_connection: bool, of_client: bool) -> None:
    connection, efforts = Fake(), Buckets(1e-9, 2.0)

    async def app(scope: Any, receive: Any, send: Any) -> None:
        if trusted:
            connection.trust()
        work(LONG)

    async def nothing(*_: Any) -> None: ...

    scope = {"type": kind, "client": ("192.0.2.1", 1), "extensions": {KEY: connection}}
    service: Any = SimpleNamespace(efforts=efforts)
    asyncio.run(Meter(app, service)(scope, nothing, nothing))  # type: ignore[arg-type]
    assert (connection.charged > 0.0) == of_connection
    assert efforts.empty("192.0.2.1") == of_client


def test_pauses_of_the_machine_hold_nobody_back_for_long() -> None:
    connection = Fake()
    scope = {"type": "http", "client": ("192.0.2.1", 1), "extensions": {KEY: connection}}
    charger(scope, SimpleNamespace(efforts=Buckets(1.0, 1.0)))(60.0)  # type: ignore[arg-type]
    assert connection.charged == MOST_SECONDS
    connection.trust()
    charger(scope | {"type": "websocket"}, SimpleNamespace(efforts=Buckets(1.0, 1.0)))(60.0)  # type: ignore[arg-type]
    assert connection.charged == MOST_SECONDS + TRUSTED_MOST_SECONDS


def test_who_took_too_much_is_told_to_wait_and_others_are_not(
    serve: Callable[..., Running], visit: Callable[[Running], Walker]
) -> None:
    running = serve(ready=False)
    running.service.efforts.take("127.0.0.1", 1e6)
    refused = running.http.get("/api/v1/jobs")
    assert (refused.status_code, refused.json()["code"]) == (429, "too-busy")
    assert running.http.get("/healthz").status_code == 200
    with pytest.raises(ConnectionClosed, match="1013"):
        visit(running).hello()
    assert running.http.get("/api/v1/jobs", headers={"X-Forwarded-For": "192.0.2.1"}).status_code == 200
