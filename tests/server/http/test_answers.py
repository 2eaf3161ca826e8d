import asyncio
import socket
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from harness import PATIENCE, Running, run
from starlette.responses import PlainTextResponse, StreamingResponse
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from server.http.answers import STRICT_TRANSPORT, Answers
from server.http.forwarded import Forwarded
from server.http.security import HEADERS
from server.settings import ServerSettings

HTTPS = {"X-Forwarded-Proto": "https"}


@pytest.fixture(scope="module")
def proxied() -> Iterator[Running]:
    """A service with a token behind a proxy of this machine."""
    with run(ServerSettings(port=0, token="secret-enough-for-tests", trusted_proxies=("127.0.0.1",))) as service:
        yield service


@pytest.mark.parametrize("path", ["/", "/main.js", "/healthz", "/metrics", "/api/docs", "/api/openapi.json",
                                  "/api/v1/scenes", "/api/v1/scenes/cornell-box", "/api/v1/jobs", "/nothing",
                                  "/api/v1/jobs/none/result", "/api/v1/render"])  # fmt: skip
def test_head_is_as_get_without_the_body(running: Running, path: str) -> None:
    got, asked = running.http.get(path), running.http.head(path)
    assert asked.content == b""
    assert asked.status_code == got.status_code
    same = ("Content-Type", "Cache-Control", "Allow", "ETag", *HEADERS)
    assert [asked.headers.get(name) for name in same] == [got.headers.get(name) for name in same]
    if path != "/metrics":  # which counts
        assert asked.headers["Content-Length"] == got.headers["Content-Length"]


def test_head_of_an_endless_stream_ends() -> None:
    async def endless() -> Any:
        while True:
            yield "more"

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(Answers(StreamingResponse(endless())))
        async with asyncio.timeout(PATIENCE), httpx.AsyncClient(transport=transport, base_url="http://here") as client:
            return await client.head("/")

    assert asyncio.run(ask()).status_code == 200


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("PUT", "/api/v1/scenes", "GET, HEAD, POST"),
        ("PATCH", "/api/v1/jobs/none", "GET, HEAD, DELETE"),
        ("GET", "/api/v1/render", "POST"),
        ("OPTIONS", "/api/v1/jobs", "GET, HEAD, POST"),
        ("POST", "/healthz", "GET, HEAD"),
        ("PATCH", "/api/v1/scenes/cornell-box/load", "POST"),
        ("DELETE", "/api/v1/scenes/rooms/hall.glb/unload", "POST"),
        ("PATCH", "/api/v1/scenes/rooms/hall.glb/export.glb", "GET, HEAD, POST"),
        ("DELETE", "/main.js", "GET, HEAD"),
        ("POST", "/api/docs/files/swagger-ui.css", "GET, HEAD"),
    ],
)
def test_a_method_that_is_none_of_a_place_is_told_which_are(
    running: Running, method: str, path: str, allowed: str
) -> None:
    response = running.http.request(method, path)
    assert (response.status_code, response.headers["Allow"]) == (405, allowed)
    assert response.json()["code"] == "method-not-allowed"


@pytest.mark.parametrize("method", ["GET", "PATCH", "DELETE", "POST /load", "POST /unload", "GET /export.glb"])
def test_a_line_break_in_the_name_of_a_scene_is_one_like_any_letter(running: Running, method: str) -> None:
    method, _, below = method.partition(" ")
    response = running.http.request(method, f"/api/v1/scenes/%0A/a%0Ab{below}", json={})
    assert response.json()["code"] == ("forbidden" if below == "/export.glb" else "unknown-scene")


@pytest.mark.parametrize("path", ["/healthz%0A", "/api/v1/jobs%0A", "/api/v1/scenes/cornell-box/unload%0A"])
def test_a_path_that_ends_in_a_line_break_is_none(running: Running, path: str) -> None:
    response = running.http.get(path)
    assert (response.status_code, response.json()["code"]) == (404, "not-found")


@pytest.mark.parametrize(
    ("path", "caching"),
    [("/main.js", "no-cache"), ("/api/docs/files/swagger-ui.css", "no-cache"), ("/api/v1/scenes", "no-store"),
     ("/metrics", "no-store"), ("/nothing", "no-store")],
)  # fmt: skip
def test_only_files_with_a_tag_are_kept(running: Running, path: str, caching: str) -> None:
    assert running.http.get(path).headers["Cache-Control"] == caching


@pytest.mark.parametrize("path", ["/healthz", "/", "/api/v1/scenes"])  # answered, and refused
def test_https_is_stayed_with(proxied: Running, path: str) -> None:
    assert proxied.http.get(path, headers=HTTPS).headers["Strict-Transport-Security"] == STRICT_TRANSPORT
    assert "Strict-Transport-Security" not in proxied.http.get(path).headers


@pytest.mark.parametrize(("trusted", "told"), [(["127.0.0.1"], True), (["192.0.2.7"], False)])
def test_only_trusted_proxies_know_of_https(trusted: list[str], told: bool) -> None:
    app = Forwarded(Answers(PlainTextResponse("in")), "", trusted, ())

    async def ask() -> httpx.Response:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://here") as client:
            return await client.get("/", headers=HTTPS)

    assert ("Strict-Transport-Security" in asyncio.run(ask()).headers) is told


def test_other_origins_are_told_nothing_unless_configured(running: Running) -> None:
    response = running.http.get("/api/v1/scenes", headers={"Origin": "https://elsewhere.example"})
    assert not [name for name in response.headers if name.startswith("access-control-")]


def test_a_refused_handshake_is_no_fault_and_has_the_headers(
    proxied: Running, caplog: pytest.LogCaptureFixture
) -> None:
    for path, status in (("/api/v1/stream", 401), ("/nowhere", 401)):
        with pytest.raises(InvalidStatus) as refused, connect(f"ws://{proxied.http.base_url.netloc.decode()}{path}"):
            pass
        answer = refused.value.response
        assert answer.status_code == status
        assert b'"code":"unauthorized"' in answer.body
        assert {name: answer.headers[name] for name in HEADERS} == HEADERS
    assert [record for record in caplog.records if record.levelname in ("ERROR", "WARNING")] == []


def test_what_is_no_http_is_answered_in_the_same_form(running: Running) -> None:
    with socket.create_connection((running.http.base_url.host, running.http.base_url.port or 0)) as connection:
        connection.sendall(b"GET / HTTP/1.1\r\nno header\r\n\r\n")
        head, _, body = connection.recv(65536).decode().partition("\r\n\r\n")
    assert head.startswith("HTTP/1.1 400 ")
    assert body.startswith('{"code":"bad-request"')
    assert all(name.lower() in head.lower() for name in HEADERS)
