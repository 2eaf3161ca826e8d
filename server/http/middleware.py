"""Limits of HTTP requests: how many are worked on at once, how large their bodies are, and how long those may take."""

import asyncio
import itertools
from collections.abc import Sequence
from contextlib import ExitStack
from math import ceil

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.errors import error_response
from server.http.forwarded import route_path
from server.http.metered import charger
from server.http.presence import serve_while_present
from server.http.security import OPEN
from server.logs import bind
from server.places import Places, asker
from server.refusals import TooBusyError
from server.service import WAITING_OF_ALL, Service

BODY_SECONDS = 30.0  # for a body to arrive
REFUSAL_SECONDS = 1.0  # that a client waits for its refusal that took too much
SPARE_REQUESTS = 64  # that may be answered at once, beside the stills that wait


class BodyLimit:
    """Answers 413 to a request body of more than `max_bytes`, announced or not, and 408 to one that does not come.

    What is at the paths `streamed` reads its body piece by piece and has a limit of its own.
    """

    def __init__(self, app: ASGIApp, max_bytes: int, streamed: Sequence[str] = ()) -> None:
        self._app = app
        self._max_bytes = max_bytes
        self._streamed = streamed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Read the body, which is small, and pass it on whole."""
        bodiless = scope["type"] != "http" or scope["method"] in ("GET", "HEAD", "OPTIONS")
        if bodiless or route_path(scope) in self._streamed:
            await self._app(scope, receive, send)
            return
        announced = Headers(scope=scope).get("Content-Length", "")
        if announced.isdecimal() and int(announced) > self._max_bytes:
            await self._too_large(scope, receive, send)
            return
        try:
            async with asyncio.timeout(BODY_SECONDS):
                body = await self._read(receive)
        except TimeoutError:
            text = f"the request body did not arrive within {BODY_SECONDS:g} s"
            await error_response(408, "too-slow", text)(scope, receive, send)
            return
        if body is None:
            return
        if len(body) > self._max_bytes:
            await self._too_large(scope, receive, send)
            return
        whole: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

        async def replay() -> Message:
            return whole.pop() if whole else await receive()

        await self._app(scope, replay, send)

    async def _too_large(self, scope: Scope, receive: Receive, send: Send) -> None:
        text = f"the request body is larger than this server's limit of {self._max_bytes} bytes"
        await error_response(413, "too-large", text)(scope, receive, send)

    async def _read(self, receive: Receive) -> bytes | None:
        """The body, as far as it is not too large; None when the client has left."""
        body = bytearray()
        more = True
        while more and len(body) <= self._max_bytes:
            message = await receive()
            if message["type"] == "http.disconnect":
                return None
            body += message.get("body", b"")
            more = message.get("more_body", False)
        return bytes(body)


class RequestLimit:
    """Answers 503 to more requests at once than the service takes, half of them of one client, and to all while it
    stops, and 429 to a client whose requests took too much of the web process; numbers them.
    """

    def __init__(self, app: ASGIApp, service: Service) -> None:
        self._app = app
        self._service = service
        most = WAITING_OF_ALL * service.settings.max_waiting_renders + SPARE_REQUESTS
        self._places = Places("requests that are being answered", most, ceil(most / 2))
        self._numbers = itertools.count(1)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request that there is room for."""
        if scope["type"] != "http" or route_path(scope) in OPEN:
            await self._app(scope, receive, send)
            return
        bind(request=next(self._numbers))
        if self._service.stopping.is_set():
            await error_response(503, "stopping", "the service is stopping")(scope, receive, send)
        elif self._service.efforts.empty(asker.get()):
            self._service.metrics.refused("effort")
            await asyncio.sleep(REFUSAL_SECONDS)  # else asking again would take as much
            text = "what you asked for took too much of this server's time; try again later"
            await error_response(429, "too-busy", text)(scope, receive, send)
        else:
            with ExitStack() as place:
                try:
                    place.enter_context(self._places.taken(asker.get()))
                except TooBusyError as error:
                    self._service.metrics.refused("requests")
                    await error_response(503, "too-busy", str(error))(scope, receive, send)
                    return
                await self._serve(scope, receive, send, place)

    async def _serve(self, scope: Scope, receive: Receive, send: Send, place: ExitStack) -> None:
        """What is being answered counts until the answer begins: how long that takes to read is the client's affair."""

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                place.close()
            await send(message)

        charge = charger(scope, self._service)
        await serve_while_present(self._app, scope, receive, counted, self._service.stopping, charge)
