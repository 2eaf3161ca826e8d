"""Requests end with their clients: who has left waits for no turn, no scene and no file."""

import asyncio
from asyncio import FIRST_COMPLETED
from collections.abc import Callable
from typing import Any

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.errors import error_response
from server.http.metered import Metered

FINISH_SECONDS = 3.0  # for requests to be answered once the service is to end; less than it waits for them


class _Inbox:
    """What a client sends. It is read as the application asks for it, and behind that to hear that the client leaves,
    which the application may wait for too.
    """

    def __init__(self, receive: Receive) -> None:
        self._receive = receive
        self._first: Message | None = None
        self._whole, self._left = asyncio.Event(), asyncio.Event()

    async def open(self, scope: Scope) -> None:
        """Take a request that has no body, which the application may never ask for."""
        headers = Headers(scope=scope)
        if headers.get("Content-Length", "0") == "0" and "Transfer-Encoding" not in headers:
            self._first = await self._next()

    async def receive(self) -> Message:
        """The next message, for the application."""
        first, self._first = self._first, None
        if first is not None:
            return first
        if not self._whole.is_set():
            return await self._next()
        await self._left.wait()
        return {"type": "http.disconnect"}

    async def left(self) -> None:
        """Wait until the client has left."""
        await self._whole.wait()
        while not self._left.is_set():
            await self._next()

    async def _next(self) -> Message:
        message = await self._receive()
        if message["type"] == "http.disconnect":
            self._left.set()
        if not message.get("more_body", False):
            self._whole.set()
        return message


async def serve_while_present(
    app: ASGIApp,
    scope: Scope,
    receive: Receive,
    send: Send,
    end: asyncio.Event,
    charge: Callable[[float], None],
) -> None:
    """Serve an HTTP request until it is answered or its client leaves. A while after `end` it is answered by 503.

    charge: hears what it takes (server.http.metered).
    """
    inbox = _Inbox(receive)
    begun = finished = False

    async def noted(message: Message) -> None:
        nonlocal begun, finished
        begun = True
        finished = message["type"] == "http.response.body" and not message.get("more_body", False)
        await send(message)

    async def ended() -> None:
        await end.wait()
        await asyncio.sleep(FINISH_SECONDS)

    await inbox.open(scope)
    work = asyncio.create_task(_run(app, scope, inbox.receive, noted, charge))
    left, stop = asyncio.create_task(inbox.left()), asyncio.create_task(ended())
    try:
        await asyncio.wait((work, left, stop), return_when=FIRST_COMPLETED)
        if not (work.done() or left.done() or begun):
            work.cancel()
            await asyncio.wait((work,))
            if not begun:
                await error_response(503, "stopping", "the service is stopping")(scope, receive, send)
            return
        await asyncio.wait((work, left), return_when=FIRST_COMPLETED)
        if not (work.done() or finished):
            work.cancel()
        await asyncio.wait((work,))
        if not work.cancelled():
            work.result()
    finally:
        for task in (work, left, stop):
            task.cancel()


async def _run(app: ASGIApp, scope: Scope, receive: Receive, send: Send, charge: Callable[[float], None]) -> None:
    work: Any = app(scope, receive, send)
    await Metered(work, charge)
