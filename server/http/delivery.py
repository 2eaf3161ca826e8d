"""How answers leave: piece by piece, so that of one that is not read only a little waits in memory."""

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.connection import connection_of

PIECE_BYTES = 65_536


class Delivery:
    """ASGI middleware, the outermost one."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request, and its answer in pieces. An answer that comes before all of the request ends it there."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        connection = connection_of(scope)

        async def in_pieces(message: Message) -> None:
            if message["type"] == "http.response.start" and connection is not None and connection.unread:
                MutableHeaders(scope=message)["Connection"] = "close"
            body = memoryview(message.get("body", b""))
            while len(body) > PIECE_BYTES:
                await send({"type": message["type"], "body": body[:PIECE_BYTES], "more_body": True})
                body = body[PIECE_BYTES:]
            await send({**message, "body": body} if "body" in message else message)

        await self._app(scope, receive, in_pieces)
