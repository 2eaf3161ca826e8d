"""What the stream does with those who ask for too much."""

import json
import time
from collections.abc import Callable
from contextlib import suppress
from threading import Event, Thread
from typing import Any

import pytest
from harness import IDENTITY, Running, Walker
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from server.walk import stream, viewer
from server.walk.viewer import MESSAGE_BURST, MESSAGE_RATE
from server.wire.browser import PROTOCOL, parse_viewer_message

Visit = Callable[[Running], Walker]
POSE = json.dumps({"type": "pose", "id": 1, "matrix": IDENTITY, "yfov": 1.0})


def consume(socket: ClientConnection) -> None:
    """Reads until the socket is closed."""
    while True:
        socket.recv(10)


def code_of(socket: ClientConnection) -> int:
    """The code that the server closes with."""
    with pytest.raises(ConnectionClosed) as info:
        consume(socket)
    assert info.value.rcvd is not None
    return info.value.rcvd.code


def count(running: Running, name: str, **labels: str) -> float:
    return running.service.metrics.registry.get_sample_value(f"lumenwalk_{name}", labels) or 0.0


def test_a_message_that_is_too_big_is_refused_with_its_code(running: Running, visit: Visit) -> None:
    walker = visit(running)
    walker.hello()
    with suppress(ConnectionClosed):  # the server does not wait for the rest
        walker.socket.send("x" * (17 * 2**20))
    assert code_of(walker.socket) == 1009
    visit(running).hello()


def test_a_flood_is_slowed_down_and_others_are_not(
    running: Running, visit: Visit, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = 0

    def counting(text: str) -> Any:
        nonlocal read
        read += 1
        return parse_viewer_message(text)

    monkeypatch.setattr(viewer, "parse_viewer_message", counting)
    hostile, other = visit(running), visit(running)
    other.hello()
    hostile.hello()
    seen = 0
    ended = Event()

    def flood() -> None:
        try:
            while not ended.is_set():
                hostile.socket.send(POSE)
        except ConnectionClosed:
            pass

    read = 0
    thread = Thread(target=flood, daemon=True)
    thread.start()
    began = time.monotonic()
    try:
        while time.monotonic() - began < 1.5:
            seen += 1
            other.pose(seen)
            other.send("ack", frame=other.frame(timeout=5.0)[0].frame)
        took, was_read = time.monotonic() - began, read
    finally:
        ended.set()
    hostile.socket.socket.close()
    thread.join(10)
    assert seen > 5
    assert was_read <= MESSAGE_BURST + MESSAGE_RATE * took + 3 * seen + 10


def test_who_says_nothing_takes_no_viewers_place(
    serve: Callable[..., Running], visit: Visit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream, "MAX_GREETING", 2)
    running = serve(max_viewers=1)
    silent = []
    for number in range(2):
        silent.append(visit(running))
        while len(running.service.greeting) == number:
            time.sleep(0.01)
    visit(running).hello()
    assert code_of(silent[0].socket) == 1002  # made room
    assert running.service.viewers
    assert code_of(visit(running).socket) == 1013
    assert count(running, "refused_total", reason="full") == 1
    silent[1].send("hello", protocol=PROTOCOL, size=[64, 36])
    assert code_of(silent[1].socket) == 1013


def test_nobody_is_let_in_while_the_service_stops(serve: Callable[..., Running], visit: Visit) -> None:
    running = serve()
    running.service.stopping.set()
    assert code_of(visit(running).socket) == 1012
    response = running.http.get("/api/v1/scenes")
    assert (response.status_code, response.json()["code"]) == (503, "stopping")
    assert "Retry-After" in response.headers
