import asyncio
import resource
import socket
from collections.abc import Callable
from contextlib import ExitStack

import pytest
from harness import PATIENCE, Running, wait_for

from gpu.errors import UserError
from server.http import accepting as module
from server.http.accepting import accept_all, listen


class Counted(asyncio.Protocol):
    """Connections that are made."""

    def __init__(self, made: list[asyncio.BaseTransport]) -> None:
        self._made = made

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._made.append(transport)


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="needs IPv6")
@pytest.mark.parametrize(
    ("host", "reached"), [("::1", ["::1"]), ("::", ["::1", "127.0.0.1"]), ("127.0.0.1", ["127.0.0.1"])]
)
def test_it_listens_on_ipv6_and_on_both(host: str, reached: list[str]) -> None:
    with listen(host, 0) as listener:
        for address in ("::1", "127.0.0.1"):
            try:
                socket.create_connection((address, listener.getsockname()[1]), PATIENCE).close()
            except OSError:
                assert address not in reached
            else:
                assert address in reached


@pytest.mark.parametrize("host", ["a..b", "x" * 300])
def test_a_name_that_no_host_can_have_is_told(host: str) -> None:
    with pytest.raises(UserError, match="no name of a host"):
        listen(host, 0)


def test_connections_are_taken_in_as_far_as_the_gate_is_open(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ACCEPT_COST", 10.0)

    async def run() -> None:
        made: list[asyncio.BaseTransport] = []
        with ExitStack() as stack:
            listener = stack.enter_context(listen("127.0.0.1", 0))
            address = listener.getsockname()[:2]
            accepting = asyncio.create_task(accept_all(listener, lambda: Counted(made)))
            for _ in range(3):
                stack.enter_context(socket.create_connection(address, PATIENCE))
            while not made:
                await asyncio.sleep(0)
            for _ in range(20):
                await asyncio.sleep(0)
            accepting.cancel()
            await asyncio.wait([accepting])
            assert len(made) == 1
            made[0].close()  # type: ignore[attr-defined]

    asyncio.run(asyncio.wait_for(run(), PATIENCE))


def test_who_has_left_already_costs_little(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ACCEPT_COST", 10.0)

    async def run() -> None:
        made: list[asyncio.BaseTransport] = []
        with ExitStack() as stack:
            listener = stack.enter_context(listen("127.0.0.1", 0))
            address = listener.getsockname()[:2]
            for _ in range(3):
                socket.create_connection(address, PATIENCE).close()
            stack.enter_context(socket.create_connection(address, PATIENCE))
            accepting = asyncio.create_task(accept_all(listener, lambda: Counted(made)))
            while not made:
                await asyncio.sleep(0)
            accepting.cancel()
            await asyncio.wait([accepting])
            assert len(made) == 1
            made[0].close()  # type: ignore[attr-defined]

    asyncio.run(asyncio.wait_for(run(), PATIENCE))


def test_it_goes_on_after_the_system_had_no_descriptor(
    monkeypatch: pytest.MonkeyPatch, serve: Callable[..., Running], caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(module, "RETRY_SECONDS", 0.01)
    running = serve(ready=False)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with ExitStack() as stack:
        # Several, since what other tests left may close meanwhile, and its descriptors can be had then.
        clients = [stack.enter_context(socket.socket()) for _ in range(8)]
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(client.fileno() for client in clients) + 1, hard))
        try:
            for client in clients:
                client.connect((running.http.base_url.host, running.http.base_url.port))
            wait_for(lambda: "cannot be taken in" in caplog.text)
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        client = clients[-1]
        client.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
        client.settimeout(PATIENCE)
        assert client.recv(12) == b"HTTP/1.1 200"
