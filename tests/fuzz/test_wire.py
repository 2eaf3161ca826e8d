"""What comes over the wire: whatever it is, a message or the one error that is expected."""

import asyncio
import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpu.errors import UserError
from server.wire.browser import PROTOCOL, parse_viewer_message
from server.wire.frame_header import Codec, FrameHeader, Phase, unpack_frame
from server.wire.worker import Done, pack, receive

FEW = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])

_IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
MESSAGES: list[dict[str, Any]] = [
    {"type": "hello", "protocol": PROTOCOL, "size": [64, 36], "settings": {"method": "path"}, "codecs": ["jpeg"]},
    {"type": "pose", "id": 1, "matrix": _IDENTITY, "yfov": 1.0, "near": 0.1},
    {"type": "settings", "id": 2, "scene": "hall", "scene_options": {"up": "z"}, "stream": {"lossless": True}},
    {"type": "ack", "frame": 3, "age_ms": 1.5},
]
_JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
_HEADER = FrameHeader(64, 36, 1, 2, 3, 0.5, 1.5, 2.5, {"trace": 1.0}, Codec.PNG, Phase.FINAL, 85, 3, 64)
_DONE = pack(Done(2, (1, 2), 3.0, 4.0, 1, 1, {"trace": 1.0}, {}, {}), b"image")


@st.composite
def changed(draw: st.DrawFn, whole: bytes) -> bytes:
    """`whole` with some bytes others, more or fewer."""
    content = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(content)))
        content[at : at + draw(st.integers(0, 4))] = draw(st.binary(max_size=8))
    return bytes(content)


def taken(text: str | bytes) -> None:
    with expected(UserError) as told:
        parse_viewer_message(text)
    assert not any("\n" in str(error) for error in told)


@contextmanager
def expected(*kinds: type[Exception]) -> Iterator[list[Exception]]:
    """Lets errors of these kinds end what is within; they are listed."""
    told: list[Exception] = []
    try:
        yield told
    except kinds as error:
        told.append(error)


async def receive_all(content: bytes) -> None:
    """As the web process hears a worker."""
    stream = asyncio.StreamReader()
    stream.feed_data(content)
    stream.feed_eof()
    await receive(stream, lambda: 1000)


@FEW
@given(st.sampled_from(MESSAGES), st.data())
def test_messages_of_viewers_with_any_value_in_any_place(message: dict[str, Any], data: st.DataObject) -> None:
    key = data.draw(st.sampled_from(sorted(message)) | st.text(max_size=8))
    taken(json.dumps(message | {key: data.draw(_JSON)}))


@FEW
@given(st.binary(max_size=64) | st.sampled_from(MESSAGES).flatmap(lambda it: changed(json.dumps(it).encode())))
def test_messages_of_viewers_of_any_bytes(text: bytes) -> None:
    taken(text)


@FEW
@given(st.binary(max_size=64) | changed(_HEADER.pack() + b"image"))
def test_frames_of_any_bytes(message: bytes) -> None:
    with expected(UserError):
        unpack_frame(message)


@FEW
@given(st.binary(max_size=64) | changed(_DONE))
def test_messages_of_workers_of_any_bytes(message: bytes) -> None:
    with expected(EOFError, ValueError):
        asyncio.run(receive_all(message))
