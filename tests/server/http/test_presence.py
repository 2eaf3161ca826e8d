"""Requests whose clients leave, or that are under way as the service ends."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from harness import PATIENCE

from server.http import presence
from server.http.presence import serve_while_present

BODILESS = {"type": "http", "method": "GET", "headers": []}
CHUNKED = {"type": "http", "method": "POST", "headers": [(b"transfer-encoding", b"chunked")]}
START = {"type": "http.response.start", "status": 200, "headers": []}
END = {"type": "http.response.body", "body": b"done"}


class Client:
    """Sends messages, then waits; it leaves when told to."""

    def __init__(self, *messages: dict[str, Any]) -> None:
        self._messages = [*messages]
        self.gone = asyncio.Event()
        self.got: list[dict[str, Any]] = []

    async def receive(self) -> dict[str, Any]:
        if self._messages:
            return self._messages.pop(0)
        await self.gone.wait()
        return {"type": "http.disconnect"}

    async def send(self, message: Any) -> None:
        self.got.append(message)


def free(seconds: float) -> None:
    """Who does not mind what is taken."""


def run(test: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(asyncio.wait_for(test(), PATIENCE))  # type: ignore[arg-type]


WHOLE = {"type": "http.request", "body": b"", "more_body": False}


def test_who_has_left_waits_no_more() -> None:
    async def main() -> None:
        client, cancelled = Client(WHOLE), asyncio.Event()

        async def app(scope: Any, receive: Any, send: Any) -> None:
            client.gone.set()
            try:
                await asyncio.sleep(3600)
            finally:
                cancelled.set()

        await serve_while_present(app, BODILESS, client.receive, client.send, asyncio.Event(), free)
        assert cancelled.is_set()
        assert client.got == []

    run(main)


def test_a_body_is_read_as_the_application_asks_for_it() -> None:
    async def main() -> None:
        pieces = [{"type": "http.request", "body": bytes([number]), "more_body": number < 2} for number in range(3)]
        client, got = Client(*pieces), []

        async def app(scope: Any, receive: Any, send: Any) -> None:
            while True:
                await asyncio.sleep(0)
                message = await receive()
                got.append(message)
                if not message["more_body"]:
                    break
            await send(START)
            await send(END)

        await serve_while_present(app, CHUNKED, client.receive, client.send, asyncio.Event(), free)
        assert got == pieces
        assert client.got == [START, END]

    run(main)


def test_the_application_hears_that_the_client_leaves() -> None:
    async def main() -> None:
        client = Client(WHOLE)

        async def app(scope: Any, receive: Any, send: Any) -> None:
            assert await receive() == WHOLE
            client.gone.set()
            assert (await receive())["type"] == "http.disconnect"

        await serve_while_present(app, BODILESS, client.receive, client.send, asyncio.Event(), free)

    run(main)


def test_what_is_done_after_the_answer_is_done() -> None:
    async def main() -> None:
        client, after = Client(WHOLE), []

        async def app(scope: Any, receive: Any, send: Any) -> None:
            await send(START)
            await send(END)
            client.gone.set()  # uvicorn says so once an answer is sent
            await asyncio.sleep(0.01)
            after.append("done")

        await serve_while_present(app, BODILESS, client.receive, client.send, asyncio.Event(), free)
        assert after == ["done"]

    run(main)


@pytest.mark.parametrize("scope", [BODILESS, CHUNKED])
def test_the_end_of_the_service_is_the_answer(scope: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(presence, "FINISH_SECONDS", 0.0)

    async def main() -> None:
        client, end = Client(*([WHOLE] if scope is BODILESS else [])), asyncio.Event()

        async def app(scope: Any, receive: Any, send: Any) -> None:
            end.set()
            while (await receive())["type"] != "http.disconnect":
                pass

        await serve_while_present(app, scope, client.receive, client.send, end, free)
        assert client.got[0]["status"] == 503
        assert json.loads(client.got[1]["body"])["code"] == "stopping"

    run(main)


def test_errors_of_the_application_are_raised() -> None:
    async def main() -> None:
        async def app(scope: Any, receive: Any, send: Any) -> None:
            raise ValueError

        client = Client(WHOLE)
        with pytest.raises(ValueError):  # noqa: PT011
            await serve_while_present(app, BODILESS, client.receive, client.send, asyncio.Event(), free)

    run(main)
