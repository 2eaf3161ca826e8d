"""uvicorn's WebSocket, for viewers that do not read what they are sent: they can neither fill memory nor stay for ever.

A closed asyncio transport waits until its peer has read everything, so a peer that reads nothing must be cut off.
"""

from typing import Any, cast

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from server.http.connection import KEY
from server.http.refusal import refusal

MAX_FRAGMENTS = 1024  # of one message
NO_TEXT, POLICY = 1007, 1008  # codes of a close
LINGER_SECONDS = 10.0  # for a peer to read the last words
DISCARD_SECONDS = 0.5  # for it to stop talking


class WebSocket(WebSocketsSansIOProtocol):
    """One connection."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._pong = b""  # what has to wait

    def data_received(self, data: bytes) -> None:
        """Understand what has come. First comes a whole handshake, which may have more headers than are taken."""
        super().data_received(data)
        if not self.handshake_initiated and not self.transport.is_closing():
            text = "the headers of a WebSocket's handshake are too many or too long"
            self.transport.write(refusal(431, "too-large", text, self.default_headers))
            self.transport.close()

    def send_receive_event_to_app(self) -> None:
        """Pass on a message. Text that is none ends the connection, and is no fault to be logged."""
        try:
            if self.curr_msg_data_type == "text":
                b"".join(self.frames).decode()
        except UnicodeDecodeError:
            self.conn.fail(NO_TEXT, "text that is not UTF-8")
            self.handle_parser_exception()
        else:
            super().send_receive_event_to_app()

    def handle_ping(self) -> None:
        """Answer a ping; while the peer does not read, only those that came last are kept to be (RFC 6455, 5.5.3)."""
        if self.writable.is_set():
            super().handle_ping()
        else:  # the answers to all pings of one reading come at once
            self._pong = b"".join(self.conn.data_to_send()) or self._pong

    def resume_writing(self) -> None:
        """The peer has read: answer its last ping."""
        super().resume_writing()
        if self._pong and not self.transport.is_closing():
            pong, self._pong = self._pong, b""
            self.transport.write(pong)

    def handle_parser_exception(self) -> None:
        """Say why this ends, and throw away what still comes: closed with that unread, a socket may lose the words."""
        if self.close_sent:
            return
        assert self.conn.close_sent is not None
        code, reason = self.conn.close_sent.code, self.conn.close_sent.reason
        self.queue.put_nowait({"type": "websocket.disconnect", "code": code, "reason": reason})
        self.transport.write(b"".join(self.conn.data_to_send()))
        self.close_sent = True
        self.close_timer = self.loop.call_later(DISCARD_SECONDS, self.transport.close)
        if self.read_paused:
            self.read_paused = False
            self.transport.resume_reading()

    def keepalive_timeout(self) -> None:
        """The peer does not answer pings: cut it off in a while."""
        super().keepalive_timeout()
        self._cut_off()

    def handle_cont(self, event: Frame) -> None:
        """A piece of a message; of empty ones there could be any number."""
        if len(self.frames) < MAX_FRAGMENTS:
            super().handle_cont(event)
        elif self.conn.close_sent is None:
            self.conn.fail(POLICY, f"a message has more than {MAX_FRAGMENTS} fragments")
            self.handle_parser_exception()

    async def send(self, message: Any) -> None:
        """Send it. A handshake that is refused with an answer is done as well, and no fault to be logged."""
        await super().send(message)
        if message["type"] == "websocket.http.response.body" and not message.get("more_body", False):
            self.handshake_complete = True

    async def run_asgi(self) -> None:
        """Serve the connection, and cut it off if it outlives that."""
        cast(dict[str, Any], self.scope)["extensions"][KEY] = self.transport
        try:
            await super().run_asgi()
        finally:
            if not self.disconnected:
                self._cut_off()

    def _cut_off(self) -> None:
        self.loop.call_later(LINGER_SECONDS, self.transport.abort)
