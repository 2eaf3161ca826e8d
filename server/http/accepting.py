"""Listening, and taking in connections: one at a time, for a share of a core."""

import asyncio
import logging
import socket
from collections.abc import Callable
from errno import EADDRINUSE

from gpu.errors import UserError
from server.http.gate import Gate

WAITING = 128  # connections that the system keeps until they are taken in: a longer queue is a longer wait
SHARE = 0.1  # of a core, however many come
ACCEPT_COST, GONE_COST = 0.0003, 0.00005  # s of a core for one before a byte of it is read, and for one that has left
RETRY_SECONDS = 0.2  # after the system could give no connection
log = logging.getLogger("lumenwalk.http")


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens; on `::` for IPv4 too, where the system can. Raises UserError when it cannot."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        both = address[0] == "::" and socket.has_dualstack_ipv6()
        return socket.create_server(address, family=family, backlog=WAITING, dualstack_ipv6=both)
    except OSError as error:
        if error.errno == EADDRINUSE:
            raise UserError(f"port {port} of {host} is in use: stop what uses it, or choose another port") from None
        raise UserError(f"cannot listen on {host}, port {port}: {error.strerror or error}") from None
    except UnicodeError:  # of the codec that names of hosts go through
        raise UserError(f"cannot listen on {host[:60]!r}, which is no name of a host") from None


async def accept_all(listener: socket.socket, protocol: Callable[[], asyncio.BaseProtocol]) -> None:
    """Take in whoever comes, each with a `protocol` of its own, until this is cancelled."""
    loop = asyncio.get_running_loop()
    listener.setblocking(False)
    gate = Gate(SHARE)
    while True:
        await gate.opened()
        try:
            client, _ = await loop.sock_accept(listener)
        except OSError as error:  # no descriptors, no memory, or the client has left
            log.warning("a connection cannot be taken in: %s", error.strerror or error)
            await asyncio.sleep(RETRY_SECONDS)
            continue
        if _has_left(client):
            gate.charge(GONE_COST)
            client.close()
            await asyncio.sleep(0)  # others have a turn
            continue
        gate.charge(ACCEPT_COST)
        try:
            await loop.connect_accepted_socket(protocol, client)
        except OSError:
            client.close()


def _has_left(client: socket.socket) -> bool:
    """Whether a client has closed its connection before it said anything."""
    try:
        return not client.recv(1, socket.MSG_PEEK)
    except BlockingIOError:
        return False
    except OSError:
        return True
