"""The WebSocket of one viewer: text messages in, messages and frames out."""

import asyncio
from contextlib import suppress

from fastapi import WebSocket, WebSocketDisconnect
from starlette.websockets import WebSocketState

from gpu.errors import UserError
from server.wire.browser import Message

CLOSE_SECONDS = 1.0  # for a viewer to take note of the end
CLOSED_ABNORMALLY = 1006  # RFC 6455: what a socket says that was not closed


class ViewerSocket:
    """Reads and writes what the wire protocol allows; WebSocketDisconnect once the connection has ended."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket

    async def receive(self) -> str:
        """The next text message; UserError for a binary one."""
        message = await self._socket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1005), message.get("reason"))
        text = message.get("text")
        if text is None:
            raise UserError("viewers send text messages only")
        return str(text)

    async def send(self, message: Message) -> int:
        """Send a message as JSON; the number of its characters."""
        self._check_open()
        text = message.model_dump_json()
        await self._socket.send_text(text)
        return len(text)

    async def send_frame(self, frame: bytes) -> None:
        """Send a header and its image."""
        self._check_open()
        await self._socket.send_bytes(frame)

    async def say_goodbye(self, message: Message) -> None:
        """Send a message if the viewer takes it soon."""
        with suppress(TimeoutError):
            async with asyncio.timeout(CLOSE_SECONDS):
                await self.send(message)

    async def leave(self, code: int, reason: str) -> None:
        """Close, and raise WebSocketDisconnect."""
        self._check_open()
        with suppress(TimeoutError):
            async with asyncio.timeout(CLOSE_SECONDS):
                await self._socket.close(code, reason)
        raise WebSocketDisconnect(code, reason)

    def _check_open(self) -> None:
        """Another task may have closed the socket, or met its end, an instant ago."""
        if self._socket.application_state is not WebSocketState.CONNECTED:
            raise WebSocketDisconnect(CLOSED_ABNORMALLY)
