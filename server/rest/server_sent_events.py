"""Server-sent events: what goes on, as it goes on (https://html.spec.whatwg.org/multipage/server-sent-events.html)."""

import asyncio
from asyncio import FIRST_COMPLETED
from collections.abc import AsyncGenerator, AsyncIterator

from pydantic import BaseModel
from starlette.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from server.errors import ErrorBody
from server.places import Places, asker
from server.service import Service

MEDIA_TYPE = "text/event-stream"
LAST_SECONDS = 0.2  # for what is watched to end with the service
COMMENT = ":\n\n"  # clients pass over it; proxies see that the stream lives


def event(name: str, data: BaseModel) -> str:
    """One event; JSON has no line breaks of its own."""
    return f"event: {name}\ndata: {data.model_dump_json()}\n\n"


class EventStream(StreamingResponse):
    """A response that ends when `events` do, or the service, and says nothing for `rest_seconds` at most.

    Proxies are told not to hold any back. TooBusyError, as an answer, when its client has as many as it may.
    """

    def __init__(
        self, events: AsyncGenerator[str], places: Places, stopping: asyncio.Event, rest_seconds: float
    ) -> None:
        headers = {"X-Accel-Buffering": "no"}
        super().__init__(_until(stopping, events, rest_seconds), media_type=MEDIA_TYPE, headers=headers)
        self._places = places

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the events."""
        with self._places.taken(asker.get()):
            await super().__call__(scope, receive, send)


def event_stream(events: AsyncGenerator[str], service: Service) -> EventStream:
    """The events as a response of this service."""
    return EventStream(events, service.streams, service.stopping, service.settings.keepalive_seconds)


async def _until(stopping: asyncio.Event, events: AsyncGenerator[str], rest_seconds: float) -> AsyncIterator[str]:
    end = asyncio.create_task(stopping.wait())
    try:
        while True:
            following = asyncio.ensure_future(anext(events, None))
            try:
                while not (await asyncio.wait((following, end), timeout=rest_seconds, return_when=FIRST_COMPLETED))[0]:
                    yield COMMENT
                if not following.done():
                    await asyncio.wait((following,), timeout=LAST_SECONDS)
            finally:  # also when the client has left: a generator that still runs cannot be closed
                if not following.done():
                    following.cancel()
                    await asyncio.wait((following,))
            if following.cancelled():
                yield event("stopping", ErrorBody(code="stopping", message="the service is stopping"))
                return
            text = following.result()
            if text is None:
                return
            yield text
    finally:
        end.cancel()
        await events.aclose()


def wants_events(accept: str | None) -> bool:
    """Whether a client asks for events rather than for the outcome alone."""
    return accept is not None and MEDIA_TYPE in accept.lower()
