"""The service as a process: what it prints, what it imports, and how it ends."""

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from errno import ENOSPC
from io import StringIO
from pathlib import Path

import httpx
import pytest
from harness import GRADIENT_WORKER, PATIENCE, Walker, alive
from websockets.sync.client import connect

from gpu.errors import UserError
from server.app import create_app, create_server
from server.engines import make_engines
from server.render.activity import READY, RECOVERING, Activity, EngineState
from server.render.worker_process import WorkerProcess
from server.serve import _announcer, _url, serve
from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"
PROGRAM = f"""
import signal
import sys
from gpu.errors import UserError
from server.serve import serve
from server.http import shutdown
from server.serve import serve
from server.settings import ServerSettings
from server.walk.stream import ROUTE
shutdown.DRAIN_SECONDS = shutdown.END_SECONDS = 1000.0  # what holds up the end does so for too long
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # whatever runs the tests ignores
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


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
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
    assert "the service ends" in errors.read_text()
    assert not re.search("Traceback|ERROR|again|status -", errors.read_text())


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
    app = create_app(settings, make_engines(settings, GRADIENT_WORKER))
    engines = app.state.service.engines
    engines.listeners.add(_announcer(engines, create_server(app, settings), "http://localhost"))
    for name, stream in zip(("stdout", "stderr"), written, strict=True):
        monkeypatch.setattr(sys, name, stream)
    for activity in (Activity(EngineState.STARTING, "compiling"), READY, RECOVERING):
        engines.engines[0].set_activity(activity)
    assert [stream.getvalue() for stream in written] == [
        "http://localhost\n",
        "lumenwalk: compiling\nlumenwalk: starting the renderer again\n",
    ]


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


def test_an_address_of_another_machine_is_said() -> None:
    with pytest.raises(UserError, match=r"cannot listen on 192\.0\.2\.1"):
        serve(ServerSettings(host="192.0.2.1", port=0), GRADIENT_WORKER)


def test_a_worker_runs_before_what_serves_is_imported_and_no_longer_than_that_goes_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    started = list[int]()

    class Noted(WorkerProcess):
        def __init__(self, command: Sequence[str]) -> None:
            super().__init__(command)
            started.append(self.pid)

    monkeypatch.setattr("server.render.workers.WorkerProcess", Noted)
    monkeypatch.setitem(sys.modules, "server.app", None)
    with pytest.raises(ImportError):
        serve(ServerSettings(port=0), GRADIENT_WORKER)
    (pid,) = started
    assert not alive(pid)


def test_what_is_wrong_is_said_before_a_worker_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.render.workers.WorkerProcess", lambda *_: pytest.fail("a worker is started"))
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(UserError, match="is in use"):
        serve(ServerSettings(port=taken.getsockname()[1]), GRADIENT_WORKER)
    with pytest.raises(UserError, match="there is no such file"):
        serve(ServerSettings(port=0, scene=str(tmp_path / "gone.glb")), GRADIENT_WORKER)
    with pytest.raises(UserError, match="has an empty name"):
        serve(ServerSettings(port=0, device="cpu,"), GRADIENT_WORKER)
