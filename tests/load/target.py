"""The service under test: one that runs already on this machine, or one started here as a child process."""

import asyncio
import os
import secrets
import signal
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
from websockets.asyncio.client import ClientConnection, connect

from gpu.errors import UserError
from server.http.security import is_loopback

START_SECONDS = 600.0  # the first start on a machine compiles the kernels
END_SECONDS = 15.0
MAX_MESSAGE_BYTES = 2**27
HERE = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Target:
    """Where the service is, what opens it, and its process if that is ours."""

    url: str
    token: str | None = None
    process: asyncio.subprocess.Process | None = field(default=None, compare=False)

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        parts = urlsplit(self.url)
        return parts.hostname or "", parts.port or (443 if parts.scheme == "https" else 80)

    @property
    def headers(self) -> dict[str, str]:
        """What opens the service."""
        return {"Authorization": f"Bearer {self.token}"} if self.token else {}

    def http(self) -> httpx.AsyncClient:
        """A client for its REST interface."""
        # Idle connections go long before the service closes them, which could cross with a request, cores being busy.
        limits = httpx.Limits(max_connections=None, keepalive_expiry=0.5)
        return httpx.AsyncClient(base_url=self.url, headers=self.headers, timeout=120, limits=limits, trust_env=False)

    def socket(self, url: str | None = None, **options: Any) -> connect:
        """A WebSocket to its stream, or to the stream of a relay at `url`; `options` go to websockets."""
        stream = f"{(url or self.url).replace('http', 'ws', 1)}/api/v1/stream"
        given = {"additional_headers": self.headers} | options
        return connect(stream, compression=None, max_size=MAX_MESSAGE_BYTES, ping_interval=None, proxy=None, **given)

    async def ready(self) -> bool:
        """Whether it can render now."""
        async with self.http() as http:
            return (await http.get("/readyz")).status_code == 200


Socket = ClientConnection


def target_at(url: str, token: str | None, *, remote: bool) -> Target:
    """A service that runs already, at the root of a host or below a path of it; UserError when it is not on this
    machine, unless `remote` allows that.
    """
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise UserError(f"{url}: must be the address that `lumenwalk serve` prints, such as http://127.0.0.1:8000")
    if not remote and not is_loopback(parts.hostname):
        raise UserError(f"{url}: is not this machine: --remote allows to load a server that is yours")
    return Target(f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}", token)


@asynccontextmanager
async def serving(flags: Sequence[str], worker: str | None = None, log: Path | None = None) -> AsyncIterator[Target]:
    """A service with these flags of `lumenwalk serve`, on a free port, with a token; it ends with the context.

    worker: a program instead of the renderer. log: where its words go; None: with ours. UserError if it does not start.
    """
    token = secrets.token_urlsafe()
    command = [
        sys.executable,
        "-m",
        "tests.load.host",
        *(["--worker", worker] if worker else []),
        "--port",
        "0",
        *flags,
    ]
    stderr = log.open("ab") if log else None
    try:
        process = await asyncio.create_subprocess_exec(
            *command,
            cwd=HERE,
            env=os.environ | {"LUMENWALK_TOKEN": token},
            stdout=asyncio.subprocess.PIPE,
            stderr=stderr,
            start_new_session=True,
        )
    finally:
        if stderr:
            stderr.close()
    try:
        yield Target(await _first_line(process, log), token, process)
    finally:
        await _end(process)


async def _first_line(process: asyncio.subprocess.Process, log: Path | None) -> str:
    """The address, which the service prints once a frame can be had."""
    assert process.stdout is not None
    try:
        line = await asyncio.wait_for(process.stdout.readline(), START_SECONDS)
    except TimeoutError:
        raise UserError(f"the service did not start within {START_SECONDS:.0f} s") from None
    if not line:
        raise UserError(f"the service did not start; {log or 'what it said'} says why")
    return line.decode().strip()


async def _end(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        process.send_signal(signal.SIGTERM)
        try:
            await asyncio.wait_for(process.wait(), END_SECONDS)
        except TimeoutError:
            process.kill()
            await process.wait()
