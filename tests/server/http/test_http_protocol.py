"""What is no request, or too much of one, over a socket."""

import json
import socket
from collections.abc import Callable

import pytest
from harness import Running

from server.http.http_protocol import MAX_HEAD_BYTES
from server.http.security import HEADERS


def ask(running: Running, data: bytes) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of the answer to raw bytes; the service closes."""
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=10) as client:
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


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"GET /healthz HTTP/1.1\r\n\r\n", 400),
        (HOST + b"Host: localhost\r\n\r\n", 400),
        (HOST + b"X: " + b"x" * (2 * MAX_HEAD_BYTES), 431),
        (HOST + b"x: y\r\n" * MAX_HEAD_BYTES, 431),
    ],
    ids=["no HTTP", "no host", "two hosts", "one large header", "many headers"],
)
def test_what_is_no_request_gets_a_problem_and_the_end(running: Running, data: bytes, status: int) -> None:
    given, headers, body = ask(running, data)
    assert given == status
    assert json.loads(body)["code"]
    assert {name.lower(): value for name, value in HEADERS.items()}.items() <= headers.items()
    assert headers["connection"] == "close"


def test_trailers_end_too(running: Running) -> None:
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=10) as client:
        assert pour(client, CHUNKED + b"0\r\n", b"x: " + b"y" * 4096 + b"\r\n") < 2**26


def test_a_body_that_is_refused_is_not_read(serve: Callable[..., Running]) -> None:
    running = serve(ready=False, token="0123456789abcdef")
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=10) as client:
        client.sendall(CHUNKED)
        answer = client.recv(65536)
        assert answer.startswith(b"HTTP/1.1 401")
        assert b"connection: close" in answer.lower()
        assert pour(client, b"", b"10000\r\n" + bytes(65536) + b"\r\n") < 2**26


def test_a_request_that_has_come_whole_keeps_its_connection(serve: Callable[..., Running]) -> None:
    running = serve(ready=False, token="0123456789abcdef")
    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=10) as client:
        client.sendall(b"POST /api/v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\r\n{}")
        answer = client.recv(65536)
    assert answer.startswith(b"HTTP/1.1 401")
    assert b"connection: close" not in answer.lower()
