"""The service as a process: who opens it, what it logs of that, and how it ends."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from gradient_worker import BUG_SEED, SLOW_SEED
from harness import GRADIENT_WORKER, IDENTITY, PATIENCE, Walker, alive, wait_for
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from server.http.shutdown import CLOSE_SECONDS, DRAIN_SECONDS, END_SECONDS
from server.render.worker_link import STOP_SECONDS
from server.wire.browser import PROTOCOL

# That the host counts as one of a network is all that differs from listening on one.
PROGRAM = f"""
import sys
from server.http import security
from server.serve import serve
from server.settings import ServerSettings
if "open" in sys.argv:
    security.is_loopback = lambda host: False
serve(ServerSettings(port=0, log_format="json"), {GRADIENT_WORKER!r})
"""


@contextmanager
def service(errors: Path, *arguments: str) -> Iterator[tuple["subprocess.Popen[str]", str]]:
    """A service that is ready, and the address that it printed."""
    command = [sys.executable, "-c", PROGRAM, *arguments]
    with (
        errors.open("w") as stderr,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True, start_new_session=True) as process,
    ):
        try:
            assert process.stdout is not None
            yield process, process.stdout.readline().strip()
        finally:
            process.kill()


def ends_by_itself(process: "subprocess.Popen[str]") -> None:
    assert process.wait(PATIENCE) != 1, "it was ended since something held it up"


def test_the_end_comes_before_supervisors_lose_their_patience() -> None:
    assert DRAIN_SECONDS + CLOSE_SECONDS + STOP_SECONDS < END_SECONDS < 10.0


def stream(url: str) -> str:
    return f"{url.replace('http', 'ws')}/api/v1/stream"


def test_off_loopback_the_token_is_printed_once_and_never_logged(tmp_path: Path) -> None:
    errors = tmp_path / "stderr"
    with service(errors, "open") as (process, printed):
        url, token = printed.split("/?token=")
        bearer = {"Authorization": f"Bearer {token}"}
        assert httpx.get(f"{url}/").status_code == 401
        assert httpx.get(printed).status_code == 303
        assert httpx.get(f"{url}/metrics", headers=bearer).status_code == 200
        bug = {"size": [8, 8], "settings": {"seed": BUG_SEED}}
        assert httpx.post(f"{url}/api/v1/render?token={token}", json=bug, headers=bearer).status_code == 500
        with connect(f"{stream(url)}?token={token}", additional_headers=bearer) as connection:
            Walker(connection).hello()
        process.terminate()
        ends_by_itself(process)
        assert process.stdout is not None
        assert process.stdout.read() == ""
    assert token not in errors.read_text()
    events = [json.loads(line) for line in errors.read_text().splitlines() if line.startswith("{")]
    assert [event["viewer"] for event in events if event["message"] == "viewer came"] == [1]
    assert [event["viewer"] for event in events if event["message"] == "viewer left"] == [1]


def test_viewers_are_told_and_stills_finish(tmp_path: Path) -> None:
    with service(tmp_path / "stderr") as (process, url), connect(stream(url)) as connection:
        walker = Walker(connection)
        walker.hello()
        with httpx.Client(base_url=url, timeout=PATIENCE) as client, ThreadPoolExecutor(4) as pool:
            client.get("/healthz")
            slow = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}
            answers = [pool.submit(client.post, "/api/v1/render", json=slow) for _ in range(4)]
            answers[0].result(PATIENCE)
            process.terminate()
            walker.word("status", state="stopping")
            with pytest.raises(ConnectionClosed) as info:
                walker.frame()
            assert [answer.result(PATIENCE).status_code for answer in answers] == [200, 200, 200, 200]
        assert info.value.rcvd is not None
        assert info.value.rcvd.code == 1012
        ends_by_itself(process)
    logged = (tmp_path / "stderr").read_text()
    assert [logged.count(it) for it in ("viewer left", "the service ends")] == [1, 1]


def stop(process: "subprocess.Popen[str]") -> None:
    """The signal for one process, as from a supervisor."""
    process.terminate()


def stop_group(process: "subprocess.Popen[str]") -> None:
    """An interrupt from a terminal, which the worker gets too."""
    os.killpg(process.pid, signal.SIGINT)


def children(pid: int) -> list[int]:
    """The processes that a process has started."""
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


@pytest.mark.parametrize("end", [stop, stop_group])
def test_neither_a_stalled_reader_nor_a_stuck_worker_holds_the_end_up(
    tmp_path: Path, end: Callable[["subprocess.Popen[str]"], None]
) -> None:
    with service(tmp_path / "stderr") as (process, url), closing(raw_stream(url)) as reader:
        reader.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        send_text(reader, {"type": "hello", "protocol": PROTOCOL, "size": [2048, 2048]})
        assert reader.recv(1)  # and no more from here on
        for number in range(1, 4):
            time.sleep(0.2)
            send_text(reader, {"type": "pose", "id": number, "matrix": IDENTITY, "yfov": 1.0})
        (worker,) = children(process.pid)
        os.kill(worker, signal.SIGSTOP)
        end(process)
        ends_by_itself(process)
        wait_for(lambda: not alive(worker))


def raw_stream(url: str) -> socket.socket:
    """A WebSocket by hand, of which nothing is read in the background."""
    host, port = url.removeprefix("http://").split(":")
    reader = socket.create_connection((host, int(port)), timeout=PATIENCE)
    handshake = (
        f"GET /api/v1/stream HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    reader.sendall(handshake.encode())
    answer = b""
    while not answer.endswith(b"\r\n\r\n"):
        answer += reader.recv(1)
    assert b" 101 " in answer
    return reader


def send_text(reader: socket.socket, message: dict[str, Any]) -> None:
    """Sends one text message (masked with zeros)."""
    text = json.dumps(message).encode().ljust(126)
    reader.sendall(bytes([0x81, 0x80 | 126]) + len(text).to_bytes(2, "big") + bytes(4) + text)
