"""The service as a process: what it prints, what it imports, and how it ends."""

import asyncio
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from errno import ENOSPC
from io import StringIO
from pathlib import Path

import httpx
import pytest
from harness import GRADIENT_WORKER, PATIENCE, Walker
from pydantic import TypeAdapter
from websockets.sync.client import connect

from gpu.errors import UserError
from server.app import _announcer, _url, create_app, create_server, prepare, serve, server_config
from server.render.activity import READY, RECOVERING, Activity, EngineState
from server.settings import ServerSettings
from server.walk.stream import ROUTE
from server.walk.viewer import settings_schema

TOKEN = "correct-horse-battery-staple"
PROGRAM = f"""
import sys
from gpu.errors import UserError
from server.app import serve
from server.http import shutdown
from server.settings import ServerSettings
from server.walk.stream import ROUTE
shutdown.DRAIN_SECONDS = shutdown.END_SECONDS = 1000.0  # what holds up the end does so for too long
try:
    serve(ServerSettings(port=0, device=sys.argv[1] or None), {GRADIENT_WORKER!r})
except UserError as error:
    print("user error:", error)
"""


@contextmanager
def service(errors: Path, device: str = "") -> Iterator["subprocess.Popen[str]"]:
    # importtime lists on stderr every module that the web process imports.
    command = [sys.executable, "-X", "importtime", "-c", PROGRAM, device]
    with errors.open("w") as stderr:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True, start_new_session=True)
        try:
            with process:
                yield process
                process.kill()
        finally:
            process.kill()


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_it_prints_its_url_serves_without_warp_and_stops_at_once(tmp_path: Path, sign: signal.Signals) -> None:
    errors = tmp_path / "stderr"
    with service(errors) as process:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+", url)
        assert httpx.post(f"{url}/api/v1/render", json={"size": [32, 18]}, timeout=PATIENCE).status_code == 200
        with connect(f"{url.replace('http', 'ws')}/api/v1/stream") as connection:
            walker = Walker(connection)
            walker.hello()
            walker.pose(1)
            walker.frame()
            os.killpg(process.pid, sign)  # as a terminal and systemd do; the worker must not take it for a fault
            process.wait(PATIENCE)
    imported = {line.split("|")[-1].strip() for line in errors.read_text().splitlines() if "import time:" in line}
    assert "server.walk.stream" in imported
    assert not [name for name in imported if name.split(".")[0] == "warp"]
    assert not re.search("Traceback|ERROR|again", errors.read_text())


def test_a_start_that_fails_ends_the_service_with_the_reason(tmp_path: Path) -> None:
    with service(tmp_path / "stderr", device="none") as process:
        assert process.stdout is not None
        assert process.stdout.read() == "user error: no device 'none' here\n"
        assert process.wait(PATIENCE) == 0


def test_words_that_cannot_be_written_stop_no_renderer(monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(StringIO):
        def flush(self) -> None:
            raise OSError(ENOSPC, "No space left on device")

    settings, written = ServerSettings(), (Full(), Full())
    app = create_app(settings, GRADIENT_WORKER)
    engines = app.state.service.engines
    engines.listeners.add(_announcer(engines, create_server(app, settings), "http://localhost"))
    for name, stream in zip(("stdout", "stderr"), written, strict=True):
        monkeypatch.setattr(sys, name, stream)
    for activity in (Activity(EngineState.STARTING, "compiling"), READY, RECOVERING):
        engines.engines[0]._set_activity(activity)
    assert [stream.getvalue() for stream in written] == [
        "http://localhost\n",
        "lumenwalk: compiling\nlumenwalk: starting the renderer again\n",
    ]


def test_a_port_in_use_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(UserError, match=f"port {port} of 127.0.0.1 is in use"):
            serve(ServerSettings(port=port), GRADIENT_WORKER)


@pytest.mark.parametrize(
    ("settings", "url"),
    [
        ({}, "http://127.0.0.1:81"),
        ({"host": "::1"}, "http://[::1]:81"),
        ({"host": "::1", "root_path": "/walk/"}, "http://[::1]:81/walk/"),
        ({"host": "::", "token": TOKEN}, f"http://[::1]:81/?token={TOKEN}"),
        ({"host": "0.0.0.0", "token": TOKEN}, f"http://127.0.0.1:81/?token={TOKEN}"),
        ({"host": "2001:db8::7", "token": TOKEN, "root_path": "/a/b"}, f"http://[2001:db8::7]:81/a/b/?token={TOKEN}"),
    ],
)
def test_the_link_can_be_opened(settings: dict[str, str], url: str) -> None:
    assert _url(ServerSettings(**settings), 81, with_token="token" in settings) == url


def test_proxies_and_rest_are_as_the_settings_say() -> None:
    settings = ServerSettings(keepalive_seconds=7.0)
    config = server_config(create_app(settings), settings)
    assert config.ws_ping_interval == 7.0
    assert not config.proxy_headers  # read once only, by server.http.forwarded


def test_the_first_request_finds_all_made_that_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    app, made, make, frozen = create_app(ServerSettings()), list[object](), TypeAdapter.__init__, list[bool]()

    def count(adapter: object, *args: object, **options: object) -> None:
        made.append(adapter)
        make(adapter, *args, **options)

    monkeypatch.setattr(TypeAdapter, "__init__", count)
    monkeypatch.setattr("gc.freeze", lambda: frozen.append(True))
    settings_schema.cache_clear()
    prepare(app)
    assert made
    assert settings_schema.cache_info().currsize == 1
    assert frozen
    made.clear()

    async def ask() -> int:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
            return (await client.get("/healthz")).status_code

    assert asyncio.run(ask()) == 200
    assert not made


def test_no_answer_waits_for_a_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    async def thread(*_: object) -> None:
        pytest.fail("a thread is asked, which waits for the interpreter while frames are sent")

    monkeypatch.setattr("fastapi.dependencies.utils.run_in_threadpool", thread)

    async def ask() -> int:
        transport = httpx.ASGITransport(create_app(ServerSettings()))
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
            return (await client.get("/api/v1/jobs")).status_code

    assert asyncio.run(ask()) == 200


def test_an_address_of_another_machine_is_said() -> None:
    with pytest.raises(UserError, match=r"cannot listen on 192\.0\.2\.1"):
        serve(ServerSettings(host="192.0.2.1", port=0), GRADIENT_WORKER)


def test_an_environment_that_cannot_be_read_is_told_at_the_start(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read: No such file"):
        create_app(ServerSettings(environment=tmp_path / "gone.hdr"))


def test_a_walk_is_asked_for_before_all_else() -> None:
    """A crowd that comes, most of it to be refused, is not matched with one route after the other."""
    routes = create_app(ServerSettings()).routes
    assert routes.index(ROUTE) <= 1
    assert all(getattr(route, "path", "") == "/api/openapi.json" for route in routes[: routes.index(ROUTE)])
