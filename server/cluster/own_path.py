"""The path of a replica, `/r/<replica>/…`, as the service behind it sees it."""

import re

from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

NAMED = re.compile(r"/r/([^/]+)")


def named(scope: Scope) -> re.Match[str] | None:
    """How a request's path begins, below what the server itself has for a prefix, if it names a replica."""
    return NAMED.match(scope["path"].removeprefix(scope.get("root_path", "")))


class OwnPath:
    """ASGI middleware: whatever replica a path names, it is a prefix. One that is gone was meant by who had it before.
    Bodies leave as bytes: Ray cannot pass on views of them.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request."""
        if scope["type"] in ("http", "websocket") and (prefix := named(scope)):
            scope = {**scope, "root_path": scope.get("root_path", "") + prefix[0]}

        async def as_bytes(message: Message) -> None:
            await send({**message, "body": bytes(message["body"])} if "body" in message else message)

        await self._app(scope, receive, as_bytes)


class ToOwnPath:
    """ASGI application: a browser that asks for the page, and for no replica, is sent to the path of this one."""

    def __init__(self, app: ASGIApp, prefix: str) -> None:
        self._app, self._prefix = app, prefix

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Redirect, or pass on."""
        root = scope["root_path"]
        if scope["type"] == "http" and scope["path"] == f"{root}/" and not NAMED.search(root):
            answer = RedirectResponse(f"{root}{self._prefix}/", 307, {"Cache-Control": "no-store"})
            await answer(scope, receive, send)
        else:
            await self._app(scope, receive, send)
