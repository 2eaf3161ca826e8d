"""Pages of other origins that may use the service: what their browsers ask for (https://fetch.spec.whatwg.org/#http-cors-protocol)."""

from collections.abc import Collection, Sequence

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.addresses import origin_of

METHODS = ("GET", "HEAD", "POST", "PATCH", "DELETE")
HEADERS = ("Authorization", "Content-Type", "Accept")
PREFLIGHT_SECONDS = 600  # that a browser need not ask again


def is_preflight(method: str, headers: Headers) -> bool:
    """Whether a browser asks what a page may do, which it does without the page's token."""
    return method == "OPTIONS" and "Access-Control-Request-Method" in headers


class Cors:
    """ASGI middleware around all that answers, refusals included: the pages that may ask may read why not."""

    def __init__(self, app: ASGIApp, origins: Collection[str], exposed: Sequence[str]) -> None:
        """origins: that are let in; exposed: headers of answers that their pages may read."""
        self._app = app
        self._origins = origins
        self._exposed = ", ".join(exposed)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what browsers ask first, and say of other answers who may read them."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        origin = headers.get("Origin", "")
        known = origin_of(origin) in self._origins

        async def with_words(message: Message) -> None:
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                answer.add_vary_header("Origin")
                if known:
                    answer["Access-Control-Allow-Origin"] = origin
                    answer["Access-Control-Allow-Credentials"] = "true"
                    answer["Access-Control-Expose-Headers"] = self._exposed
            await send(message)

        if known and is_preflight(scope["method"], headers):
            await _preflight()(scope, receive, with_words)
        else:
            await self._app(scope, receive, with_words)


def _preflight() -> Response:
    return Response(
        status_code=204,
        headers={
            "Access-Control-Allow-Methods": ", ".join(METHODS),
            "Access-Control-Allow-Headers": ", ".join(HEADERS),
            "Access-Control-Max-Age": str(PREFLIGHT_SECONDS),
        },
    )
