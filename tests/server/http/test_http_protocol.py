"""What is no request, or too much of one, over a socket."""

import json
import socket
from collections.abc import Callable

import pytest
from harness import PATIENCE, Running

from server.http.http_protocol import MAX_HEAD_BYTES, MAX_PARTS, MAX_PATH_BYTES, MAX_PIPELINED
from server.http.security import HEADERS


def ask(running: Running, data: bytes) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of the answer to raw bytes; the service closes."""
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=PATIENCE) as client:
        client.sendall(data)
        answer = b""
        while piece := client.recv(65536):
            answer += piece
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *lines = head.decode().split("\r\n")
    headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in lines)}
    return int(first.split()[1]), headers, body


def pour(client: socket.socket, first: bytes, piece: bytes) -> int:
    """How many bytes are taken before the service hangs up, or 64 MB."""
    sent = 0
    try:
        client.sendall(first)
        while sent < 2**26:
            sent += client.send(piece)
    except OSError:
        pass
    return sent


HOST = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
CHUNKED = b"POST /api/v1/render HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"

UPGRADE = (
    b"GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
)


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"GET /healthz HTTP/1.1\r\n\r\n", 400),
        (HOST + b"Host: localhost\r\n\r\n", 400),
        (HOST + b"X: " + b"x" * (2 * MAX_HEAD_BYTES), 431),
        (HOST + b"x: y\r\n" * MAX_HEAD_BYTES, 431),
        (CHUNKED + b"no length\r\n", 400),
        (CHUNKED.replace(b"chunked", b"other") + b"{}", 400),
        (b"CONNECT localhost:80 HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
        (UPGRADE + b"x: y\r\n" * 190 + b"\r\n", 431),
        (HOST + b"x: y\r\n" * MAX_PARTS + b"\r\n", 400),
        (HOST + b"Cookie: " + b"; ".join([b"a=b"] * (MAX_PARTS + 1)) + b"\r\n\r\n", 400),
        (HOST.replace(b"healthz", b"healthz?" + b"&".join([b"a"] * (MAX_PARTS + 1))) + b"\r\n", 400),
        (HOST.replace(b"healthz", b"a" * MAX_PATH_BYTES) + b"\r\n", 400),
    ],
    ids=[
        *("no HTTP", "no host", "two hosts", "one large header", "many headers"),
        *("a broken body", "an unknown encoding", "a tunnel", "a handshake of many headers"),
        *("more headers than parts", "many cookies", "many parameters", "a long path"),
    ],
)
def test_what_is_no_request_gets_a_problem_and_the_end(running: Running, data: bytes, status: int) -> None:
    given, headers, body = ask(running, data)
    assert given == status
    assert json.loads(body)["code"]
    assert {name.lower(): value for name, value in HEADERS.items()}.items() <= headers.items()
    assert headers["connection"] == "close"


def test_trailers_end_too(running: Running) -> None:
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=PATIENCE) as client:
        assert pour(client, CHUNKED + b"0\r\n", b"x: " + b"y" * 4096 + b"\r\n") < 2**26


def test_a_body_that_is_refused_is_not_read(serve: Callable[..., Running]) -> None:
    running = serve(ready=False, token="0123456789abcdef")
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=PATIENCE) as client:
        client.sendall(CHUNKED)
        answer = client.recv(65536)
        assert answer.startswith(b"HTTP/1.1 401")
        assert b"connection: close" in answer.lower()
        assert pour(client, b"", b"10000\r\n" + bytes(65536) + b"\r\n") < 2**26


def test_a_request_that_has_come_whole_keeps_its_connection(serve: Callable[..., Running]) -> None:
    running = serve(ready=False, token="0123456789abcdef")
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=PATIENCE) as client:
        client.sendall(b"POST /api/v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\r\n{}")
        answer = client.recv(65536)
    assert answer.startswith(b"HTTP/1.1 401")
    assert b"connection: close" not in answer.lower()


def test_what_comes_behind_a_request_and_is_none_does_not_take_its_answer(running: Running) -> None:
    status, headers, body = ask(running, HOST + b"\r\nnonsense\r\n\r\n")
    assert status == 200
    assert headers["connection"] == "close"
    assert json.loads(body)["status"] == "ok"


@pytest.mark.parametrize("upgrade", ["h2c", "websocket"])
@pytest.mark.parametrize("version", ["1.1", "1.0"])
def test_an_upgrade_that_there_is_not_is_a_request_like_any_other(running: Running, upgrade: str, version: str) -> None:
    body = b'{"size": [0, 0]}'
    head = (
        f"POST /api/v1/render HTTP/{version}\r\nHost: localhost\r\nConnection: Upgrade, HTTP2-Settings\r\n"
        f"Upgrade: {upgrade}\r\nHTTP2-Settings: AAMAAABk\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )
    after = b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" if version == "1.1" else b""
    status, _, answer = ask(running, head.encode() + body + after)
    assert status == 422
    assert b"size.0" in answer
    assert (b"HTTP/1.1 200" in answer) == bool(after)


def test_a_stream_is_for_websockets(running: Running) -> None:
    for method in ("GET", "HEAD"):
        answer = running.http.request(method, "/api/v1/stream")
        assert answer.status_code == 426
        assert answer.headers["Upgrade"] == "websocket"
        assert answer.headers["Sec-WebSocket-Version"] == "13"
    assert running.http.post("/api/v1/stream").headers["Allow"] == "GET, HEAD"


def test_of_many_requests_at_once_some_are_answered(running: Running) -> None:
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=PATIENCE) as client:
        client.sendall((HOST + b"\r\n") * 20)
        answers = b""
        while piece := client.recv(65536):
            answers += piece
    assert answers.count(b"HTTP/1.1 200") == 1 + MAX_PIPELINED
