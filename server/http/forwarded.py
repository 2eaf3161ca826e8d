"""What proxies in front say of a request: who asks, over which scheme, and below which path prefix.

X-Forwarded-For, -Proto and -Prefix count from trusted proxies alone. A prefix is the ASGI scope's `root_path`, and its
`path` begins with it, whether the proxy has taken it from the request or not.
"""

from collections.abc import Collection
from contextlib import suppress
from typing import Any
from urllib.parse import quote

from starlette.datastructures import Headers
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from server.addresses import check_prefix, plain_address


def route_path(scope: Scope) -> str:
    """The path of a request below the prefix."""
    return str(scope["path"][len(scope["root_path"]) :])


class Forwarded(ProxyHeadersMiddleware):
    """ASGI middleware around all that judges: uvicorn's own for client and scheme, with the prefix besides."""

    def __init__(self, app: ASGIApp, root_path: str, trusted: Collection[str], names: Collection[str]) -> None:
        """root_path: a prefix that is always there, whatever proxies say, else it is the server's; trusted: addresses
        and networks of proxies; names: of everything at the top of this service.
        """
        inner: Any = app
        super().__init__(inner, list(trusted))
        self._root_path = root_path
        self._names = names

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Pass on a request with what is known of it."""
        if scope["type"] == "lifespan":
            await super().__call__(scope, receive, send)
            return
        host, port = scope["client"] or ("", 0)
        host = plain_address(host)
        trusted = host in self.trusted_hosts
        prefix = self._root_path or scope.get("root_path", "") or (_forwarded_prefix(scope) if trusted else "")
        given = scope["path"]
        path = given if self._holds(prefix, given) else prefix + given
        scope = scope | {"client": (host, port), "root_path": prefix, "path": path}
        if prefix and given == prefix and scope["type"] == "http":
            await _add_slash(scope, receive, send)
        else:
            await super().__call__(scope, receive, send)

    def _holds(self, prefix: str, path: str) -> bool:
        """Whether a path has the prefix still: behind /viewer, /viewer/screen.js is a file of ours without it."""
        return path == prefix or (path.startswith(f"{prefix}/") and path[len(prefix) :].split("/")[1] in self._names)


def _forwarded_prefix(scope: Scope) -> str:
    """What proxies have taken from the path, the outermost first; nothing when it is no prefix."""
    said = ",".join(Headers(scope=scope).getlist("X-Forwarded-Prefix"))
    with suppress(ValueError):
        return "".join(check_prefix(prefix.strip()) for prefix in said.split(","))
    return ""


async def _add_slash(scope: Scope, receive: Receive, send: Send) -> None:
    """Send a browser from /walk to /walk/, which what the page loads is beside."""
    query = scope["query_string"].decode("latin-1")
    place = quote(scope["root_path"]) + "/"
    await RedirectResponse(f"{place}?{query}" if query else place, 307)(scope, receive, send)
