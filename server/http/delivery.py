"""How answers leave: piece by piece, so that of one that is not read only a little waits in memory."""

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.connection import Connection, connection_of

PIECE_BYTES = 65_536
HELD_BYTES = 512 * 2**20  # of all bodies that are being sent; what several read, as a job's result, counts once


class Delivery:
    """ASGI middleware, the outermost one.

    When the bodies of answers take more than they may, those that have been read for the longest are cut off.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._held: dict[Connection, bytes] = {}  # the oldest first

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request, and its answer in pieces. An answer that comes before all of the request ends it there."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        connection = connection_of(scope)

        async def in_pieces(message: Message) -> None:
            if message["type"] == "http.response.start" and connection is not None and connection.unread:
                MutableHeaders(scope=message)["Connection"] = "close"
            whole = message.get("body", b"")
            if connection is not None and len(whole) > PIECE_BYTES:
                self._hold(connection, whole)
            body = memoryview(whole)
            while len(body) > PIECE_BYTES:
                await send({"type": message["type"], "body": body[:PIECE_BYTES], "more_body": True})
                body = body[PIECE_BYTES:]
            await send({**message, "body": body} if "body" in message else message)

        try:
            await self._app(scope, receive, in_pieces)
        finally:
            if connection is not None:
                self._held.pop(connection, None)

    def _hold(self, connection: Connection, body: bytes) -> None:
        self._held.pop(connection, None)
        others = [*self._held]
        self._held[connection] = body
        while others and sum({id(held): len(held) for held in self._held.values()}.values()) > HELD_BYTES:
            oldest = others.pop(0)
            del self._held[oldest]
            oldest.abort()
