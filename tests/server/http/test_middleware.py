import socket
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest
from gradient_worker import SLOW_SEED
from harness import PATIENCE, Running

from server.http import middleware


def test_a_body_that_is_too_large_is_refused(running: Running) -> None:
    body = b" " * (running.service.settings.max_message_bytes + 1)
    response = running.http.post("/api/v1/render", content=body)
    assert (response.status_code, response.json()["code"]) == (413, "too-large")


def test_a_body_that_is_announced_as_too_large_is_not_waited_for(running: Running) -> None:
    address = running.http.base_url.host, running.http.base_url.port
    length = running.service.settings.max_message_bytes + 1
    with socket.create_connection(address, timeout=PATIENCE) as client:
        client.sendall(f"POST /api/v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n\r\n".encode())
        assert client.recv(65536).startswith(b"HTTP/1.1 413")


def test_a_body_without_a_length_is_counted(running: Running) -> None:
    def chunks() -> Iterator[bytes]:
        for _ in range(running.service.settings.max_message_bytes // 1000 + 1):
            yield b" " * 1000

    assert running.http.post("/api/v1/render", content=chunks()).status_code == 413


@pytest.mark.parametrize("chunked", [True, False])
def test_a_body_within_the_limit_arrives_whole(running: Running, chunked: bool) -> None:
    body = b'{"size": [8, 8]}' + b" " * 5000
    content = iter([body[:7], body[7:]]) if chunked else body
    response = running.http.post("/api/v1/render", content=content, headers={"Content-Type": "application/json"})
    assert response.status_code == 200


def test_more_requests_than_there_is_room_for_are_told_to_retry(
    serve: Callable[..., Running], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(middleware, "SPARE_REQUESTS", 0)
    running = serve(max_waiting_renders=1)
    slow = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}

    def render() -> httpx.Response:
        while (answer := running.http.post("/api/v1/render", json=slow)).status_code == 503:
            pass  # the other request had the room
        return answer

    with ThreadPoolExecutor(1) as pool:
        still = pool.submit(render)
        while (response := running.http.get("/api/v1/scenes")).status_code == 200 and not still.done():
            pass
        assert running.http.get("/healthz").status_code == 200
        other = {"X-Forwarded-For": "192.0.2.1"}  # half of the room is for others
        assert running.http.get("/api/v1/scenes", headers=other).status_code == 200
        assert still.result(PATIENCE).status_code == 200
    assert (response.status_code, response.json()["code"]) == (503, "too-busy")
    assert "Retry-After" in response.headers
    assert running.http.get("/api/v1/scenes").status_code == 200


def test_a_body_that_does_not_come_gives_its_place_up(running: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(middleware, "BODY_SECONDS", 0.2)

    address = running.http.base_url.host, running.http.base_url.port
    with socket.create_connection(address, timeout=PATIENCE) as client:
        client.sendall(b"POST /api/v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n ")
        answer = client.recv(65536)
        while b"too-slow" not in answer and (piece := client.recv(65536)):
            answer += piece
    assert answer.startswith(b"HTTP/1.1 408")
    assert b"too-slow" in answer
