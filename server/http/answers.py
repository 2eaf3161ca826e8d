"""What holds of every answer, refusals included: HEAD has no body, nothing is kept unasked, TLS is stayed with."""

from contextlib import suppress

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.security import HEADERS

# Once seen over HTTPS, browsers do not come by HTTP (RFC 6797); said of this name alone, not of those below it.
STRICT_TRANSPORT = "max-age=31536000"


class _AnsweredError(Exception):
    """The head of an answer is all that was asked for."""


class Answers:
    """ASGI middleware around all that answers. It goes by the scheme that trusted proxies say."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Ask for HEAD what GET would give, and put headers on the answer that has none of its own."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        is_head = scope.get("method") == "HEAD"

        async def with_manners(message: Message) -> None:
            if message["type"].endswith("response.start"):
                headers = MutableHeaders(scope=message)
                # What has a tag may be kept, and is asked about each time.
                headers.setdefault("Cache-Control", "no-cache" if "ETag" in headers else "no-store")
                if scope["type"] == "websocket":  # refused: uvicorn has headers of its own for other answers
                    headers.update(HEADERS)
                if scope["scheme"] in ("https", "wss"):
                    headers["Strict-Transport-Security"] = STRICT_TRANSPORT
            if is_head and message["type"] == "http.response.body":
                await send({"type": "http.response.body", "body": b""})
                if message.get("more_body", False):  # of a stream there may be no end
                    raise _AnsweredError
                return
            await send(message)

        with suppress(_AnsweredError):
            await self._app({**scope, "method": "GET"} if is_head else scope, receive, with_manners)
