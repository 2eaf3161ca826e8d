import asyncio
from typing import Any

import pytest

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
