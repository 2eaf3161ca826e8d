"""Viewers that do not read: what is kept for them is bounded, and they are cut off."""

import json
import socket
import time
from collections.abc import Callable

import pytest
from harness import IDENTITY, PATIENCE, Running, Walker, wait_for
from websockets.exceptions import ConnectionClosed
from websockets.frames import Frame, Opcode
from websockets.sync.client import connect

from server.http import websocket
from server.walk import viewer
from server.wire.browser import PROTOCOL

HELLO = {"type": "hello", "protocol": PROTOCOL, "size": [3840, 2160], "stream": {"motion_scale": 1.0}}


def deaf(running: Running, **fields: object) -> socket.socket:
    """A viewer that has said hello with a small buffer for what comes, and never reads it."""
    host, port = running.http.base_url.host, running.http.base_url.port
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect((host, port))
    request = (
        f"GET /api/v1/stream HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    connection.sendall(request.encode())
    connection.recv(65536)
    say(connection, HELLO | fields)
    return connection


def say(connection: socket.socket, message: object) -> None:
    connection.sendall(Frame(Opcode.TEXT, json.dumps(message).encode()).serialize(mask=True))


def sockets(running: Running) -> list[websocket.WebSocket]:
    """What the service holds open."""
    return [it for it in list(running.server.server_state.connections) if isinstance(it, websocket.WebSocket)]


def test_only_the_last_pings_of_who_does_not_read_are_kept(running: Running) -> None:
    with connect(f"ws://{running.http.base_url.netloc.decode()}/api/v1/stream") as client:
        Walker(client).hello()
        (held,) = sockets(running)
        held.loop.call_soon_threadsafe(held.pause_writing)
        pongs = [client.ping(str(number)) for number in range(10)]
        wait_for(lambda: held._pong.endswith(b"9"))
        pongs.append(client.ping("last"))
        wait_for(lambda: b"last" in held._pong)
        assert b"9" not in held._pong
        assert not pongs[0].wait(0.2)
        held.loop.call_soon_threadsafe(held.resume_writing)
        assert pongs[-1].wait(PATIENCE)


def test_messages_have_few_fragments(running: Running) -> None:
    with deaf(running, size=[64, 36]) as connection:
        connection.sendall(Frame(Opcode.TEXT, b"", fin=False).serialize(mask=True))
        flood = Frame(Opcode.CONT, b"", fin=False).serialize(mask=True) * (websocket.MAX_FRAGMENTS + 1)
        connection.sendall(flood)
        said = b""
        while b"fragments" not in said:
            piece = connection.recv(65536)
            assert piece, said[-200:]
            said += piece


def test_pings_are_read_no_faster_than_they_may_cost(running: Running) -> None:
    flood = Frame(Opcode.PING, b"").serialize(mask=True) * 2_000_000
    with deaf(running, size=[64, 36]) as connection:
        connection.settimeout(1.0)
        with pytest.raises(TimeoutError):
            connection.sendall(flood)
        began = time.monotonic()
        assert running.http.get("/healthz").status_code == 200
        assert time.monotonic() - began < 5.0


def test_who_reads_nothing_is_cut_off(serve: Callable[..., Running], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer, "STALLED_SECONDS", 0.5)
    monkeypatch.setattr(viewer, "WATCH_SECONDS", 0.1)
    monkeypatch.setattr(websocket, "LINGER_SECONDS", 0.5)
    running = serve()
    with deaf(running) as connection:
        wait_for(lambda: bool(running.service.viewing))
        (held,) = sockets(running)
        held.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        say(connection, {"type": "pose", "id": 1, "matrix": IDENTITY, "yfov": 1.0})
        wait_for(lambda: not sockets(running))
        assert not running.service.viewers


def test_text_that_is_none_is_the_viewers_fault(running: Running, caplog: pytest.LogCaptureFixture) -> None:
    with connect(f"ws://{running.http.base_url.netloc.decode()}/api/v1/stream") as client:
        client.socket.sendall(Frame(Opcode.TEXT, b"\xff\xfe").serialize(mask=True))
        with pytest.raises(ConnectionClosed) as closed:
            client.recv(PATIENCE)
    assert closed.value.rcvd is not None
    assert (closed.value.rcvd.code, closed.value.rcvd.reason) == (1007, "text that is not UTF-8")
    assert not [record for record in caplog.records if record.levelname == "ERROR"]
