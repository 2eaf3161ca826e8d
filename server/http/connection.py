"""One connection below HTTP and WebSockets: what it may cost before a byte of it is understood.

To asyncio it is the protocol, to uvicorn's parsers the transport, so that it sees all that comes and goes:

- what comes is parsed a little at a time, and the time that takes is made up for by not reading: a connection gets its
  share of one core and no more, whatever it sends (one-byte chunks, pings, empty fragments, requests back to back);
- before a token was shown it is parsed only while the gate is open for all those who have shown none;
- who asks for nothing in time is cut off, and so is who does not read what it is sent;
- a request that is answered before its body has come is not read to its end.
"""

import asyncio
import select
import socket
from time import thread_time
from typing import Any, Protocol, cast

from starlette.types import Scope

from server.http.gate import Gate

KEY = "lumenwalk.connection"  # of an ASGI scope's extensions

REQUEST_SECONDS = 10.0  # for the head of a request to arrive
SLICE_BYTES, TRUSTED_SLICE_BYTES = 2048, 32_768  # read and parsed at once: some milliseconds of the worst there is
SHARE, TRUSTED_SHARE = 0.01, 0.1  # of a core, for one connection without and with the token
ALL_SHARE = 0.2  # and for all together that are held back
REQUEST_COST = 0.0005  # s of a core that answering takes at least, beside the parsing
GRACE_SECONDS = 0.01  # that need not be made up for at once
# Who does not read so many bytes in that time, while more wait for it, is cut off: a link may be slow, or rest.
UNREAD_SECONDS, UNREAD_BYTES = 20.0, 32_768
LINGER_SECONDS, LINGER_BYTES = 2.0, 2**20  # for the last words to be read, and what is thrown away meanwhile


class Parser(Protocol):
    """What stands behind a connection: uvicorn's protocol for HTTP, then the one for WebSockets."""

    def connection_made(self, transport: Any, /) -> None:
        """The connection is open."""

    def connection_lost(self, exc: Exception | None, /) -> None:
        """It is closed."""

    def data_received(self, data: bytes, /) -> None:
        """Parse what has come."""

    def eof_received(self) -> bool | None:
        """Nothing more will come."""

    def pause_writing(self) -> None:
        """Too much waits to be read by the peer."""

    def resume_writing(self) -> None:
        """The peer has read."""


class Registry(Protocol):
    """Who keeps account of all connections."""

    held: int  # connections that are held back for what they cost
    buffer: memoryview  # read into, by one connection at a time
    gate: Gate

    def add(self, connection: "Connection") -> None:
        """A connection has come; it, or another one in its place, may be cut off."""

    def discard(self, connection: "Connection") -> None:
        """It has gone."""


class Connection(asyncio.BufferedProtocol, asyncio.Transport):
    """A TCP connection. `trusted`: its request, or its WebSocket, has the token, or none is needed.

    `since` is when it began to wait for a request, or to serve one, on the loop's clock [s].
    """

    def __init__(self, registry: Registry, parser: Parser, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__()
        self._registry = registry
        self._parser = parser
        self._loop = loop
        self._tcp = cast(asyncio.Transport, None)
        self.trusted = False
        self.waiting = True  # for a request
        self.unread = False  # the rest of its body
        self.since = loop.time()
        self._debt, self._debt_at = 0.0, self.since  # s of a core
        self._timer: asyncio.TimerHandle | None = None  # until it is read again
        self._stopped = False  # by the parser
        self._kept = b""  # what has come and waits for the gate, or for the parser
        self._gated = 0.0  # s of a core that this request has taken of what those without a token may
        self._closing = False
        self._thrown = 0  # bytes, since then
        self._written = 0
        self._mark: tuple[float, int] | None = None  # when, and of how many bytes sent, progress was seen last

    # --- what HTTP tells of itself ---

    def expect(self) -> None:
        """A request is answered: the next one may come."""
        self.waiting, self.since = True, self._loop.time()
        self._gated = 0.0

    def serve(self) -> None:
        """The head of a request has come."""
        self._settle()  # by the share that it has had until now
        self.waiting, self.trusted, self.since = False, False, self._loop.time()
        self.charge(REQUEST_COST)

    def trust(self) -> None:
        """The request may come in."""
        self._settle()
        self._registry.gate.charge(-self._gated)  # it has the token
        self._gated = 0.0
        self.trusted = True
        if self._timer is not None:
            self._release()
            self.charge(0.0)
        if self._kept:
            self._registry.gate.leave(self)
            self._loop.call_soon(self.proceed)

    # --- limits ---

    @property
    def disposable(self) -> bool:
        """Whether this may give its place to another one: it does nothing, or nothing that it has a right to."""
        return self.waiting or not self.trusted

    def overdue(self) -> str:
        """Why this should be cut off now: a word for the metrics, or nothing."""
        now = self._loop.time()
        if self.waiting and now - self.since > REQUEST_SECONDS:
            return "silent"
        if (size := self._tcp.get_write_buffer_size()) == 0:
            self._mark = None
            return ""
        sent = self._written - size
        if self._mark is None or sent - self._mark[1] >= UNREAD_BYTES:
            self._mark = now, sent
        return "unread" if now - self._mark[0] > UNREAD_SECONDS else ""

    def _settle(self) -> None:
        """Take off the debt what was made up for since."""
        now = self._loop.time()
        self._debt, self._debt_at = max(self._debt - self._share() * (now - self._debt_at), 0.0), now

    def _share(self) -> float:
        return min(TRUSTED_SHARE if self.trusted else SHARE, ALL_SHARE / max(self._registry.held, 1))

    def charge(self, seconds: float) -> None:
        """What came has taken so much of a core: read nothing until that is made up for."""
        if not self.trusted:
            self._gated += seconds
            self._registry.gate.charge(seconds)
        self._settle()
        self._debt += seconds
        if self._timer is None and not self._closing and (rest := self._debt / self._share()) > GRACE_SECONDS:
            self._registry.held += 1
            self._timer = self._loop.call_later(rest, self._release)
            self._set_reading()

    def _release(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
            self._registry.held -= 1
            self._set_reading()

    def _set_reading(self) -> None:
        if self._timer is not None or self._kept or self._thrown > LINGER_BYTES:
            self._tcp.pause_reading()
        else:
            self._tcp.resume_reading()

    # --- to asyncio: the protocol ---

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """A client has come."""
        self._tcp = cast(asyncio.Transport, transport)
        self._parser.connection_made(self)
        self._registry.add(self)

    def get_buffer(self, sizehint: int) -> memoryview:
        """Where to read into, which is all that is read at once."""
        large = self.trusted and self.unread
        return self._registry.buffer[: TRUSTED_SLICE_BYTES if large else SLICE_BYTES]

    def buffer_updated(self, nbytes: int) -> None:
        """Parse what has come, now or when the gate is open, and count what that takes."""
        if self._closing:
            self._thrown += nbytes
            self._set_reading()
            return
        data = bytes(self._registry.buffer[:nbytes])
        if not self._stopped and (self.trusted or self._registry.gate.is_open):
            self._parse(data)
        else:
            self._kept = data
            self._set_reading()
            if not self._stopped:
                self._registry.gate.wait(self)

    def proceed(self) -> None:
        """The gate is open, or the parser goes on. Who has no token and has left meanwhile, which is not heard while
        nothing is read, is not parsed.
        """
        if self._stopped:
            return
        data, self._kept = self._kept, b""
        if data and not self.trusted and _has_left(self._tcp.get_extra_info("socket")):
            self._tcp.abort()
            return
        try:
            if data and not self._closing:
                self._parse(data)
        except Exception:  # as asyncio ends a connection whose protocol fails
            self._tcp.abort()
            raise
        self._set_reading()

    def _parse(self, data: bytes) -> None:
        began = thread_time()
        self._parser.data_received(data)
        self.charge(thread_time() - began)

    def eof_received(self) -> bool | None:
        """The client says no more, which ends the connection."""
        return None if self._closing else self._parser.eof_received()

    def connection_lost(self, exc: Exception | None) -> None:
        """The connection is closed."""
        self._closing = True
        self._registry.gate.leave(self)
        self._release()
        self._registry.discard(self)
        self._parser.connection_lost(exc)

    def pause_writing(self) -> None:
        """The client does not read as fast as it is sent to."""
        self._parser.pause_writing()

    def resume_writing(self) -> None:
        """The client has read."""
        self._parser.resume_writing()

    # --- to the parser: the transport ---

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        """From now on another parser gets what comes: a WebSocket."""
        self._parser = cast(Parser, protocol)

    def get_protocol(self) -> asyncio.BaseProtocol:
        """The parser."""
        return cast(asyncio.BaseProtocol, self._parser)

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        """As of the socket's transport."""
        return self._tcp.get_extra_info(name, default)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Send it, now or when the client has read what is before it."""
        if not self._closing:
            self._written += len(data)
            self._tcp.write(data)

    def get_write_buffer_size(self) -> int:
        """What waits to be sent [bytes]."""
        return self._tcp.get_write_buffer_size()

    def pause_reading(self) -> None:
        """Until `resume_reading`: what comes first meanwhile is kept, and the system is asked for no more. A WebSocket
        pauses at each message, most of which are dealt with before the next one comes.
        """
        self._stopped = True

    def resume_reading(self) -> None:
        """As far as this connection may."""
        self._stopped = False
        if self._kept and (self.trusted or self._registry.gate.is_open):
            self._loop.call_soon(self.proceed)
        elif self._kept:
            self._registry.gate.wait(self)

    def is_closing(self) -> bool:
        """Whether nothing can be written any more."""
        return self._closing or self._tcp.is_closing()

    def close(self) -> None:
        """Send what waits, then close. What still comes is thrown away for a moment: closed with that unread, a socket
        may lose its last words.
        """
        if self.is_closing():
            return
        self._closing = True
        self._kept = b""
        if not self.unread or not self._tcp.can_write_eof():
            self._tcp.close()
            return
        try:
            self._tcp.write_eof()
        except OSError:  # the client has gone
            self._tcp.abort()
            return
        self._release()
        self._set_reading()
        self._loop.call_later(LINGER_SECONDS, self._tcp.abort)

    def abort(self) -> None:
        """Close at once."""
        self._tcp.abort()


def _has_left(tcp: socket.socket | None) -> bool:
    """Whether the client has closed its side."""
    if tcp is None or tcp.fileno() < 0:
        return tcp is not None
    poll = select.poll()
    poll.register(tcp.fileno(), select.POLLRDHUP)
    return bool(poll.poll(0))


def connection_of(scope: Scope) -> Connection | None:
    """The connection of a request or a handshake; None where there is none below, as in tests."""
    found = scope.get("extensions", {}).get(KEY)
    return found if isinstance(found, Connection) else None
