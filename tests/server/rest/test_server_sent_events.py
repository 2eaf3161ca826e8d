import asyncio
from collections.abc import AsyncGenerator

import pytest
from harness import PATIENCE

from server.errors import ErrorBody
from server.places import Places
from server.refusals import TooBusyError
from server.rest.server_sent_events import COMMENT, EventStream, event, wants_events


def test_an_event_is_a_name_and_a_line_of_json() -> None:
    body = ErrorBody(code="bad", message="two\nlines")
    assert event("error", body) == 'event: error\ndata: {"code":"bad","message":"two\\nlines"}\n\n'


@pytest.mark.parametrize(
    ("accept", "wants"),
    [(None, False), ("*/*", False), ("application/json", False), ("Text/Event-Stream, */*;q=0.1", True)],
)
def test_events_are_for_who_asks_for_them(accept: str | None, wants: bool) -> None:
    assert wants_events(accept) is wants


def event_stream(events: AsyncGenerator[str], stopping: asyncio.Event, rest_seconds: float) -> EventStream:
    return EventStream(events, Places("streams", 1, 1), stopping, rest_seconds)


class Source:
    """Gives `texts`, then waits for ever unless it `ends`; `closed` once nobody listens any more."""

    def __init__(self, *texts: str, ends: bool) -> None:
        self._texts, self._ends = texts, ends
        self.begun = self.closed = False

    async def __call__(self) -> AsyncGenerator[str]:
        self.begun = True
        try:
            for text in self._texts:
                yield text
            if not self._ends:
                await asyncio.sleep(3600)
        finally:
            self.closed = True


@pytest.mark.parametrize("ends", [True, False])
def test_a_stream_ends_with_its_events_or_with_the_service(ends: bool) -> None:
    async def main() -> None:
        source, stopping = Source("a", "b", ends=ends), asyncio.Event()
        stream = event_stream(source(), stopping, 60.0).body_iterator
        assert [await anext(stream), await anext(stream)] == ["a", "b"]
        if not ends:
            stopping.set()
            assert str(await anext(stream)).startswith("event: stopping\n")
        with pytest.raises(StopAsyncIteration):
            await anext(stream)
        assert source.closed

    asyncio.run(asyncio.wait_for(main(), PATIENCE))


def test_a_stream_that_rests_says_that_it_lives() -> None:
    async def main() -> None:
        source = Source("a", ends=False)
        stream = event_stream(source(), asyncio.Event(), 0.01).body_iterator
        assert [await anext(stream) for _ in range(3)] == ["a", COMMENT, COMMENT]
        assert COMMENT.startswith(":")  # what a client passes over
        assert isinstance(stream, AsyncGenerator)
        await stream.aclose()  # the client leaves between two of them
        assert source.closed

    asyncio.run(asyncio.wait_for(main(), PATIENCE))


def test_events_are_closed_when_the_client_leaves() -> None:
    async def main() -> None:
        source = Source(ends=False)
        stream = event_stream(source(), asyncio.Event(), 60.0).body_iterator
        waiting = asyncio.ensure_future(anext(stream))
        while not source.begun:
            await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        assert source.closed

    asyncio.run(asyncio.wait_for(main(), PATIENCE))


def test_an_end_that_comes_with_the_services_is_the_last_word() -> None:
    async def main() -> None:
        stopping = asyncio.Event()

        async def events() -> AsyncGenerator[str]:
            await stopping.wait()
            yield "end"

        stream = event_stream(events(), stopping, 60.0).body_iterator
        asyncio.get_running_loop().call_soon(stopping.set)
        assert [text async for text in stream] == ["end"]

    asyncio.run(asyncio.wait_for(main(), PATIENCE))


def test_a_stream_takes_a_place_while_it_lasts() -> None:
    async def main() -> None:
        places, sent = Places("streams", 1, 1), list[object]()
        scope = {"type": "http", "asgi": {"spec_version": "2.4"}, "client": ("192.0.2.7", 1)}

        async def send(message: object) -> None:
            sent.append(message)

        async def receive() -> dict[str, str]:
            await asyncio.sleep(3600)
            return {}

        stream = EventStream(Source("a", ends=True)(), places, asyncio.Event(), 60.0)
        with places.taken("198.51.100.1"), pytest.raises(TooBusyError):
            await stream(scope, receive, send)
        assert sent == []
        await stream(scope, receive, send)
        assert sent
        with places.taken("192.0.2.7"):
            pass

    asyncio.run(asyncio.wait_for(main(), PATIENCE))
