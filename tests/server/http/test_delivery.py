import asyncio
from typing import Any

import pytest

from server.http import connection, delivery
from server.http.connection import Connection
from server.http.delivery import PIECE_BYTES, Delivery

START = {"type": "http.response.start", "status": 200, "headers": []}


def answer(*messages: dict[str, Any]) -> list[dict[str, Any]]:
    """What is sent of an answer."""
    sent: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        for message in messages:
            await send(message)

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        raise AssertionError

    asyncio.run(Delivery(app)({"type": "http"}, receive, send))
    return sent


@pytest.mark.parametrize("size", [0, 1, PIECE_BYTES, PIECE_BYTES + 1, 3 * PIECE_BYTES])
def test_a_body_leaves_in_pieces(size: int) -> None:
    body = bytes(number % 251 for number in range(size))
    start, *pieces = answer(START, {"type": "http.response.body", "body": body})
    assert start == START
    assert b"".join(bytes(piece["body"]) for piece in pieces) == body
    assert max(len(piece["body"]) for piece in pieces) <= PIECE_BYTES
    assert [piece.get("more_body", False) for piece in pieces] == [True] * (len(pieces) - 1) + [False]


def test_a_streams_pieces_stay_a_stream() -> None:
    first = {"type": "http.response.body", "body": bytes(PIECE_BYTES + 1), "more_body": True}
    assert [piece.get("more_body") for piece in answer(START, first)[1:]] == [True, True]


class Fake(Connection):
    """A connection without a socket."""

    def __init__(self) -> None:
        self.unread = self.aborted = False

    def abort(self) -> None:
        self.aborted = True


@pytest.mark.parametrize(("shared", "cut"), [(False, [True, False, False]), (True, [False, False, False])])
def test_bodies_that_take_too_much_are_cut_off(monkeypatch: pytest.MonkeyPatch, shared: bool, cut: list[bool]) -> None:
    monkeypatch.setattr(delivery, "HELD_BYTES", 5 * PIECE_BYTES)
    result = bytes(2 * PIECE_BYTES)

    async def main() -> list[bool]:
        gate = asyncio.Event()

        async def app(scope: Any, receive: Any, send: Any) -> None:
            await send(START)
            await send({"type": "http.response.body", "body": result if shared else bytes(2 * PIECE_BYTES)})

        async def send(message: Any) -> None:
            if message["type"] == "http.response.body":
                await gate.wait()

        async def receive() -> Any:
            raise AssertionError

        front, readers = Delivery(app), [Fake() for _ in range(3)]
        scopes = [{"type": "http", "extensions": {connection.KEY: reader}} for reader in readers]
        tasks = [asyncio.create_task(front(scope, receive, send)) for scope in scopes]
        for _ in range(100):
            await asyncio.sleep(0)  # until all wait for the gate
        ends = [reader.aborted for reader in readers]
        gate.set()
        await asyncio.gather(*tasks)
        assert front._held == {}
        return ends

    assert asyncio.run(main()) == cut
