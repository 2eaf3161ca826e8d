"""All connections of a service: how many there may be, and which of them go.

A newcomer is not turned away because others came before: who has waited the longest without asking for anything makes
room. So the service can be reached while somebody holds as many connections open as the service has.
"""

import asyncio
import logging
import resource
from collections import defaultdict
from typing import Any

from uvicorn.config import Config
from uvicorn.server import ServerState

from server.addresses import client_network, is_loopback, is_within
from server.http.connection import TRUSTED_SLICE_BYTES, Connection
from server.http.gate import Gate
from server.http.http_protocol import HttpProtocol
from server.metrics import Metrics
from server.settings import ServerSettings

RESERVED_FILES = 256  # descriptors that are for other than connections: files, pipes to children
MOST_FILES = 65_536
SWEEP_SECONDS = 1.0
log = logging.getLogger("lumenwalk.http")


def raise_file_limit() -> None:
    """Let this process open as many files as the system allows it, within reason."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = MOST_FILES if hard == resource.RLIM_INFINITY else min(hard, MOST_FILES)
    if soft != resource.RLIM_INFINITY and soft < most:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


def most_connections(wanted: int) -> int:
    """How many connections there can be, if the system's limit of open files leaves room for so many."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return wanted if files == resource.RLIM_INFINITY else max(min(wanted, files - RESERVED_FILES), 16)


class Connections:
    """Makes a connection of each that is accepted, as uvicorn asks, and cuts off those that have no business here."""

    def __init__(self, settings: ServerSettings, metrics: Metrics) -> None:
        self._most = most_connections(settings.max_connections)
        # Half of them: one address may be a proxy that nobody named, or a whole network behind one.
        self._most_of_an_address = max(self._most // 2, 1)
        self._proxies = settings.trusted_proxies
        self._metrics = metrics
        self._all: dict[Connection, None] = {}  # the oldest first
        self._of_address: defaultdict[str, dict[Connection, None]] = defaultdict(dict)
        self._sweep: asyncio.TimerHandle | None = None
        self.held = 0
        self.gate = Gate()
        self.buffer = memoryview(bytearray(TRUSTED_SLICE_BYTES))

    def __call__(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> Connection:
        """A connection that begins with HTTP."""
        loop = _loop or asyncio.get_running_loop()
        return Connection(self, HttpProtocol(config, server_state, app_state, loop), loop)

    def __len__(self) -> int:
        return len(self._all)

    def add(self, connection: Connection) -> None:
        """A connection has come: if there are too many now, one goes."""
        address = self._address(connection)
        alike = self._of_address[address]
        self._all[connection] = alike[connection] = None
        if address and len(alike) > self._most_of_an_address:
            self._make_room(alike, connection)
        elif len(self._all) > self._most:
            self._make_room(self._all, connection)
        if self._sweep is None:
            self._sweep = asyncio.get_running_loop().call_later(SWEEP_SECONDS, self._sweep_all)

    def discard(self, connection: Connection) -> None:
        """A connection has gone."""
        self._all.pop(connection, None)
        address = self._address(connection)
        alike = self._of_address[address]
        alike.pop(connection, None)
        if not alike:
            del self._of_address[address]

    def _address(self, connection: Connection) -> str:
        """Of whom a connection is, as far as one address may not take them all; nothing for those who bring others."""
        peer = connection.get_extra_info("peername")
        host = peer[0] if isinstance(peer, tuple) else ""
        return "" if is_loopback(host) or is_within(host, self._proxies) else client_network(host)

    def _make_room(self, among: dict[Connection, None], newcomer: Connection) -> None:
        others = (it for it in among if it is not newcomer and it.disposable)
        self._cut_off(min(others, key=lambda it: (not it.waiting, it.since), default=newcomer), "connections")

    def _sweep_all(self) -> None:
        for connection in list(self._all):
            if why := connection.overdue():
                self._cut_off(connection, why)
        again = bool(self._all)
        self._sweep = asyncio.get_running_loop().call_later(SWEEP_SECONDS, self._sweep_all) if again else None

    def _cut_off(self, connection: Connection, why: str) -> None:
        self._metrics.refused(why)
        log.info("a connection is cut off: %s", why)
        self.discard(connection)
        connection.abort()
