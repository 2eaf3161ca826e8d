"""A service that runs in a thread of the test, with gradients for pictures, and viewers to walk in it."""

import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Any

import httpx
import pytest
from websockets.sync.client import ClientConnection, connect

from server.app import create_app, create_server
from server.engines import make_engines
from server.http.accepting import listen
from server.http.shutdown import Server
from server.service import Service
from server.settings import ServerSettings
from server.wire.browser import PROTOCOL
from server.wire.frame_header import FrameHeader, unpack_frame

# Children get no PYTHONPATH, so they are told where this checkout is.
RUN = (
    "import runpy, sys; sys.path[:0] = sys.argv[1:3]; del sys.argv[:3]; "
    "runpy.run_path(sys.argv[0], run_name='__main__')"
)
HERE = Path(__file__).parent


def script(name: str) -> tuple[str, ...]:
    """The command of a script beside this file."""
    return (sys.executable, "-c", RUN, str(HERE), str(HERE.parents[1]), str(HERE / f"{name}.py"))


GRADIENT_WORKER = script("gradient_worker")
ANY_CHECK = script("any_check")
PATIENCE = 40.0  # s, for what a machine does at once that has nothing else to do and does not stand still
IDENTITY = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def wait_for(condition: Callable[[], bool]) -> None:
    """Until this is so; an assertion fails where it does not become so."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def alive(pid: int) -> bool:
    """Whether the process runs, stopped or not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def rogue(way: str) -> tuple[str, ...]:
    """The command of a worker that misbehaves in this way."""
    return *script("rogue_worker"), way


class Walker:
    """A viewer for tests: says hello, sends poses, and sorts what comes back into frames and words."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.words: list[dict[str, Any]] = []
        self.frames: list[tuple[FrameHeader, bytes]] = []

    def send(self, type_: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"type": type_, **fields}))

    def hello(self, **fields: Any) -> dict[str, Any]:
        """Says hello and waits for the scene, which is returned."""
        self.send("hello", **{"protocol": PROTOCOL, "size": [64, 36]} | fields)
        return self.word("scene")

    def pose(self, number: int, x: float | None = None) -> None:
        """Another place with each number, or at x: a pose that is where the last one was changes nothing."""
        place = [0.01 * number if x is None else x, *IDENTITY[13:]]
        self.send("pose", id=number, matrix=[*IDENTITY[:12], *place], yfov=1.0)

    def word(self, type_: str, timeout: float = PATIENCE, **fields: Any) -> dict[str, Any]:
        """The next message of this type with these fields; what comes before it is kept or passed over."""
        deadline = time.monotonic() + timeout
        while True:
            for index, word in enumerate(self.words):
                if {"type": type_, **fields}.items() <= word.items():
                    del self.words[: index + 1]
                    return word
            self._take(deadline)

    def frame(self, timeout: float = PATIENCE) -> tuple[FrameHeader, bytes]:
        deadline = time.monotonic() + timeout
        while not self.frames:
            self._take(deadline)
        return self.frames.pop(0)

    def no_frame(self, seconds: float = 0.3) -> None:
        """Fails when a frame comes within that time."""
        with pytest.raises(TimeoutError):
            self.frame(seconds)

    def _take(self, deadline: float) -> None:
        message = self.socket.recv(max(deadline - time.monotonic(), 0.0))
        if isinstance(message, bytes):
            self.frames.append(unpack_frame(message))
        else:
            self.words.append(json.loads(message))


@dataclass
class Running:
    """A service that listens on a free port of the loopback address."""

    service: Service
    http: httpx.Client
    server: Server

    @contextmanager
    def walker(self) -> Iterator[Walker]:
        """A viewer that has connected."""
        url = f"ws://{self.http.base_url.netloc.decode()}/api/v1/stream"
        with connect(url, max_size=2**26, compression="deflate") as socket:
            yield Walker(socket)

    def ended(self, job: dict[str, Any]) -> dict[str, Any]:
        """A job when it has ended."""
        deadline = time.monotonic() + PATIENCE
        while job["state"] in ("queued", "running"):
            assert time.monotonic() < deadline, job
            time.sleep(0.02)
            job = self.http.get(job["url"]).json()
        return job

    def wait_ready(self, timeout: float = PATIENCE) -> None:
        deadline = time.monotonic() + timeout
        while self.http.get("/readyz").status_code != 200:
            assert time.monotonic() < deadline, self.service.engines.activity
            time.sleep(0.02)


@contextmanager
def run(
    settings: ServerSettings, worker: Sequence[str] = GRADIENT_WORKER, check: Sequence[str] = ANY_CHECK
) -> Iterator[Running]:
    """A service that runs as long as the context, on a port of its own."""
    app = create_app(settings, make_engines(settings, worker), check)
    server = create_server(app, settings)
    listener = listen(settings.host, settings.port)
    thread = Thread(target=server.run, args=([listener],), daemon=True)
    thread.start()
    try:
        while not server.started:
            assert thread.is_alive()
            time.sleep(0.005)
        port = listener.getsockname()[1]
        # Idle connections go long before the service closes them, which could cross with a request, cores being busy.
        limits = httpx.Limits(keepalive_expiry=0.5)
        with closing(httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE, limits=limits)) as http:
            yield Running(app.state.service, http, server)
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        assert not thread.is_alive()
