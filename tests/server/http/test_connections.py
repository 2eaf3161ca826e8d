"""Who goes when there are too many: the longest silent first, never who is being served."""

import asyncio
import resource
import socket
from collections.abc import Callable
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any

import pytest
from harness import PATIENCE, Running

from server.http import connection as one
from server.http import connections as module
from server.http.connections import Connections, most_connections
from server.metrics import Metrics
from server.settings import ServerSettings


class Fake:
    """As much of a connection as is asked about."""

    def __init__(self, address: str, since: float = 0.0, waiting: bool = True, disposable: bool = True) -> None:
        self.address, self.since, self.waiting, self.disposable = address, since, waiting, disposable
        self.gone = False
        self.why = ""

    def get_extra_info(self, name: str) -> Any:
        return (self.address, 1)

    def abort(self) -> None:
        self.gone = True

    def overdue(self) -> str:
        return self.why


def fill(settings: ServerSettings, *fakes: Fake) -> list[bool]:
    """Who of them has gone, when they have come in this order."""

    async def come() -> None:
        connections = Connections(settings, Metrics())
        for fake in fakes:
            connections.add(fake)  # type: ignore[arg-type]

    asyncio.run(come())
    return [fake.gone for fake in fakes]


@pytest.fixture
def settings(monkeypatch: pytest.MonkeyPatch) -> ServerSettings:
    monkeypatch.setattr(resource, "getrlimit", lambda _: (10_000, 10_000))
    return ServerSettings(max_connections=16, trusted_proxies=("10.1.0.0/16",))


def test_the_longest_silent_makes_room(settings: ServerSettings) -> None:
    come = [Fake("127.0.0.1", since=float(-number)) for number in range(16)]
    assert fill(settings, *come, Fake("127.0.0.1")) == [*[False] * 15, True, False]


def test_who_is_refused_goes_after_who_says_nothing(settings: ServerSettings) -> None:
    refused = [Fake("127.0.0.1", since=-99.0, waiting=False) for _ in range(15)]
    assert fill(settings, *refused, Fake("127.0.0.1"), Fake("127.0.0.1")) == [*[False] * 15, True, False]


def test_who_is_served_stays(settings: ServerSettings) -> None:
    served = [Fake("127.0.0.1", waiting=False, disposable=False) for _ in range(16)]
    assert fill(settings, *served, Fake("127.0.0.1")) == [*[False] * 16, True]


def test_one_address_has_half(settings: ServerSettings) -> None:
    assert sum(fill(settings, *[Fake("192.0.2.7") for _ in range(9)])) == 1
    assert sum(fill(settings, *[Fake(f"2001:db8::{number}") for number in range(9)])) == 1  # one network
    assert sum(fill(settings, *[Fake(f"192.0.2.{number}") for number in range(9)])) == 0


@pytest.mark.parametrize("address", ["127.0.0.1", "::1", "10.1.2.3", "::ffff:10.1.2.3"])
def test_a_proxy_and_this_machine_have_all(settings: ServerSettings, address: str) -> None:
    assert sum(fill(settings, *[Fake(address) for _ in range(16)])) == 0


def test_the_systems_limit_of_files_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1024, 1024))
    assert most_connections(2048) == 1024 - module.RESERVED_FILES
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    assert most_connections(2048) == 2048


@pytest.mark.parametrize(("hard", "wanted"), [(4096, 4096), (2**20, module.MOST_FILES)])
def test_the_limit_of_files_is_raised(monkeypatch: pytest.MonkeyPatch, hard: int, wanted: int) -> None:
    asked = SimpleNamespace(limits=(0, 0))
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1024, hard))
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: setattr(asked, "limits", limits))
    module.raise_file_limit()
    assert asked.limits == (wanted, hard)


def test_silence_and_half_heads_end(serve: Callable[..., Running], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SWEEP_SECONDS", 0.1)
    running = serve(ready=False)
    address = running.http.base_url.host, running.http.base_url.port
    sent = [b"", b"GET / HTTP/1.1\r\nHost: a\r\nX: "]
    silent = [socket.create_connection(address, timeout=PATIENCE) for _ in sent]
    for client, words in zip(silent, sent, strict=True):
        client.sendall(words)
    monkeypatch.setattr(one, "REQUEST_SECONDS", 0.3)
    ends = []
    for client in silent:
        with client:
            try:
                ends.append(client.recv(1))
            except ConnectionResetError:
                ends.append(b"")
    assert ends == [b"", b""]


def test_newcomers_are_answered_while_all_places_are_taken(
    serve: Callable[..., Running], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(one, "REQUEST_SECONDS", 1000.0)  # nobody makes room by being silent for long
    running = serve(ready=False, max_connections=16)
    address = running.http.base_url.host, running.http.base_url.port
    with ExitStack() as silent:
        for _ in range(40):
            silent.enter_context(socket.create_connection(address, timeout=PATIENCE))
        assert running.http.get("/healthz").status_code == 200
