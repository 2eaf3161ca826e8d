import asyncio
from typing import Any

import pytest
from fastapi import WebSocket, WebSocketDisconnect
from harness import PATIENCE

from gpu.errors import UserError
from server.walk.viewer_socket import ViewerSocket
from server.wire.browser import State, Status

READY = Status(state=State.READY)


class Peer:
    """The other side of a WebSocket: says `words`, notes what it is sent, and may take nothing any more."""

    def __init__(self, *words: dict[str, Any], deaf: bool = False) -> None:
        self.sent: list[dict[str, Any]] = []
        self._words = [{"type": "websocket.connect"}, *words]
        self._deaf = deaf

    async def socket(self) -> ViewerSocket:
        socket = WebSocket({"type": "websocket"}, self._receive, self._send)
        await socket.accept()
        return ViewerSocket(socket)

    async def _receive(self) -> dict[str, Any]:
        return self._words.pop(0)

    async def _send(self, message: Any) -> None:
        if self._deaf and message["type"] != "websocket.accept":
            await asyncio.sleep(3600)
        self.sent.append(message)


def test_text_is_received_until_the_viewer_leaves() -> None:
    async def main() -> None:
        peer = Peer(
            {"type": "websocket.receive", "text": "hello"},
            {"type": "websocket.receive", "bytes": b"hello"},
            {"type": "websocket.disconnect", "code": 1001, "reason": "closed"},
        )
        socket = await peer.socket()
        assert await socket.receive() == "hello"
        with pytest.raises(UserError, match="text messages only"):
            await socket.receive()
        with pytest.raises(WebSocketDisconnect) as end:
            await socket.receive()
        assert (end.value.code, end.value.reason) == (1001, "closed")

    asyncio.run(main())


def test_nothing_is_sent_after_the_end() -> None:
    async def main() -> None:
        peer = Peer()
        socket = await peer.socket()
        await socket.send(READY)
        await socket.send_frame(b"frame")
        with pytest.raises(WebSocketDisconnect):
            await socket.leave(1013, "stalled")
        assert [message["type"] for message in peer.sent[1:]] == ["websocket.send", "websocket.send", "websocket.close"]
        assert peer.sent[1]["text"] == READY.model_dump_json()
        assert peer.sent[2]["bytes"] == b"frame"
        assert (peer.sent[3]["code"], peer.sent[3]["reason"]) == (1013, "stalled")
        for late in (socket.send(READY), socket.send_frame(b"frame"), socket.leave(1012, "stopping")):
            with pytest.raises(WebSocketDisconnect):
                await late

    asyncio.run(main())


def test_a_viewer_that_takes_nothing_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.walk.viewer_socket.CLOSE_SECONDS", 0.05)

    async def main() -> None:
        socket = await Peer(deaf=True).socket()
        await socket.say_goodbye(READY)
        with pytest.raises(WebSocketDisconnect):
            await socket.leave(1012, "stopping")

    asyncio.run(asyncio.wait_for(main(), PATIENCE))
