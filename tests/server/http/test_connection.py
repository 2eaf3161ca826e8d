"""What a connection may cost: shares of a core, deadlines, what waits to be read. Against a transport in memory."""

import asyncio
import socket
from collections.abc import Iterator
from typing import Any

import pytest

from server.http import connection as module
from server.http.connection import Connection, connection_of
from server.http.gate import Gate


class Tcp(asyncio.Transport):
    """A socket's transport that only remembers."""

    def __init__(self) -> None:
        super().__init__()
        self.waiting = b""
        self.reading = True
        self.ended = ""

    def write(self, data: Any) -> None:
        self.waiting += data

    def get_write_buffer_size(self) -> int:
        return len(self.waiting)

    def pause_reading(self) -> None:
        self.reading = False

    def resume_reading(self) -> None:
        self.reading = True

    def can_write_eof(self) -> bool:
        return True

    def write_eof(self) -> None:
        self.ended = "half"

    def is_closing(self) -> bool:
        return self.ended in ("closed", "aborted")

    def close(self) -> None:
        self.ended = "closed"

    def abort(self) -> None:
        self.ended = "aborted"


class Parser:
    def __init__(self) -> None:
        self.data: list[bytes] = []

    def connection_made(self, transport: Any, /) -> None: ...
    def connection_lost(self, exc: Exception | None, /) -> None: ...
    def eof_received(self) -> bool | None: ...
    def pause_writing(self) -> None: ...
    def resume_writing(self) -> None: ...

    def data_received(self, data: bytes, /) -> None:
        self.data.append(data)


class Registry:
    def __init__(self) -> None:
        self.held = 0
        self.gate = Gate()
        self.buffer = memoryview(bytearray(module.TRUSTED_SLICE_BYTES))

    def add(self, connection: Connection) -> None: ...
    def discard(self, connection: Connection) -> None: ...


class Clock(asyncio.SelectorEventLoop):
    """A loop whose time passes when it is told to."""

    now = 1000.0

    def time(self) -> float:
        return self.now

    def pass_(self, seconds: float) -> None:
        self.now += seconds
        self.call_soon(self.stop)
        self.run_forever()


@pytest.fixture
def clock() -> Iterator[Clock]:
    loop = Clock()
    yield loop
    loop.close()


@pytest.fixture
def tcp() -> Tcp:
    return Tcp()


@pytest.fixture
def parser() -> Parser:
    return Parser()


@pytest.fixture
def connection(clock: Clock, tcp: Tcp, parser: Parser) -> Connection:
    made = Connection(Registry(), parser, clock)
    made.connection_made(tcp)
    return made


def feed(connection: Connection, data: bytes) -> None:
    buffer = connection.get_buffer(-1)
    buffer[: len(data)] = data
    connection.buffer_updated(len(data))


def costs(monkeypatch: pytest.MonkeyPatch, seconds: float) -> None:
    """Parsing takes so long from now on."""
    times = iter(seconds * number for number in range(1000))
    monkeypatch.setattr(module, "thread_time", lambda: next(times))


def test_what_parsing_takes_is_made_up_for(
    connection: Connection, tcp: Tcp, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    costs(monkeypatch, 0.004)
    feed(connection, b"x")
    assert not tcp.reading
    clock.pass_(0.9 * 0.004 / module.SHARE)
    assert not tcp.reading
    clock.pass_(0.2 * 0.004 / module.SHARE)
    assert tcp.reading


def test_who_is_trusted_waits_less(
    connection: Connection, tcp: Tcp, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    costs(monkeypatch, 0.004)
    connection.trust()
    feed(connection, b"x")
    assert not tcp.reading
    clock.pass_(1.1 * 0.004 / module.TRUSTED_SHARE)
    assert tcp.reading


def test_a_request_that_may_come_in_is_not_held_up_for_what_it_cost(connection: Connection, tcp: Tcp) -> None:
    connection.serve()
    assert not tcp.reading
    connection.trust()
    assert tcp.reading


def test_what_was_made_up_for_with_the_token_counts_so(connection: Connection, tcp: Tcp, clock: Clock) -> None:
    for _ in range(20):  # a request in a while, of a connection that stays
        connection.serve()
        connection.trust()
        assert tcp.reading
        clock.pass_(1.1 * module.REQUEST_COST / module.TRUSTED_SHARE)


def test_many_who_are_held_back_share_what_there_is(
    connection: Connection, tcp: Tcp, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    costs(monkeypatch, 0.004)
    connection._registry.held = 99
    feed(connection, b"x")
    clock.pass_(0.9 * 99 * 0.004 / module.ALL_SHARE)
    assert not tcp.reading


def test_the_parser_can_stop_reading_too(connection: Connection, tcp: Tcp, parser: Parser, clock: Clock) -> None:
    connection.serve()
    connection.trust()
    connection.pause_reading()
    assert tcp.reading  # the next message mostly comes when this one is dealt with
    feed(connection, b"x")
    assert not tcp.reading
    assert not parser.data
    connection.resume_reading()
    clock.pass_(0.0)
    assert tcp.reading
    assert parser.data == [b"x"]


def test_what_the_parser_has_not_taken_goes_with_a_connection_that_closes(
    connection: Connection, tcp: Tcp, parser: Parser
) -> None:
    connection.unread = True
    connection.pause_reading()
    feed(connection, b"x")
    connection.close()
    assert tcp.reading  # to throw away what still comes
    connection.resume_reading()
    assert not parser.data


def test_only_bodies_that_may_come_in_are_read_in_large_pieces(connection: Connection) -> None:
    assert len(connection.get_buffer(-1)) == module.SLICE_BYTES
    connection.trust()
    assert len(connection.get_buffer(-1)) == module.SLICE_BYTES  # a WebSocket's messages are small
    connection.unread = True
    assert len(connection.get_buffer(-1)) == module.TRUSTED_SLICE_BYTES


def test_who_asks_for_nothing_is_overdue(connection: Connection, clock: Clock) -> None:
    clock.pass_(module.REQUEST_SECONDS - 1.0)
    feed(connection, b"GET / HTTP/1.1\r\n")  # half a head is no request
    assert connection.overdue() == ""
    clock.pass_(2.0)
    assert connection.overdue() == "silent"
    connection.serve()
    assert connection.overdue() == ""


def test_who_does_not_read_is_overdue(connection: Connection, tcp: Tcp, clock: Clock) -> None:
    connection.serve()
    connection.write(bytes(10 * module.UNREAD_BYTES))
    assert connection.overdue() == ""
    clock.pass_(module.UNREAD_SECONDS + 1.0)
    tcp.waiting = tcp.waiting[100:]  # is no progress worth the name
    assert connection.overdue() == "unread"


def test_who_reads_slowly_is_not(connection: Connection, tcp: Tcp, clock: Clock) -> None:
    connection.serve()
    connection.write(bytes(10 * module.UNREAD_BYTES))
    for _ in range(10):
        assert connection.overdue() == ""
        clock.pass_(module.UNREAD_SECONDS)
        tcp.waiting = tcp.waiting[module.UNREAD_BYTES :]
    clock.pass_(module.UNREAD_SECONDS + 1.0)
    assert connection.overdue() == ""  # nothing waits any more


def test_it_gives_its_place_up_unless_it_serves_who_may_come_in(connection: Connection) -> None:
    assert connection.disposable
    connection.serve()
    assert connection.disposable
    connection.trust()
    assert not connection.disposable
    connection.expect()
    assert connection.disposable


def test_a_body_that_still_comes_is_thrown_away_for_a_moment(connection: Connection, tcp: Tcp, clock: Clock) -> None:
    connection.unread = True
    connection.write(b"no")
    connection.close()
    assert tcp.ended == "half"
    parser = connection.get_protocol()
    for _ in range(module.LINGER_BYTES // module.SLICE_BYTES + 1):
        assert tcp.reading
        feed(connection, bytes(module.SLICE_BYTES))
    assert not tcp.reading
    assert isinstance(parser, Parser)
    assert parser.data == []
    clock.pass_(module.LINGER_SECONDS + 0.1)
    assert tcp.ended == "aborted"


def test_what_has_come_whole_is_closed_at_once(connection: Connection, tcp: Tcp) -> None:
    connection.close()
    assert tcp.ended == "closed"
    connection.write(b"more")
    assert tcp.waiting == b""


def test_a_scope_leads_to_its_connection(connection: Connection) -> None:
    assert connection_of({"extensions": {module.KEY: connection}}) is connection
    assert connection_of({}) is None


def shut(connection: Connection) -> Gate:
    gate: Gate = connection._registry.gate
    gate.charge(60.0)
    return gate


def test_before_a_token_everybody_waits_for_one_gate(
    connection: Connection, tcp: Tcp, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate = connection._registry.gate
    monkeypatch.setattr(gate, "wait", lambda waiting: None)  # which needs a loop that runs
    costs(monkeypatch, 60.0)
    feed(connection, b"first")
    assert not gate.is_open  # what that took is taken from all
    connection._release()
    feed(connection, b"second")
    assert connection._parser.data == [b"first"]  # type: ignore[attr-defined]
    assert not tcp.reading
    connection.proceed()
    assert connection._parser.data == [b"first", b"second"]  # type: ignore[attr-defined]


def test_with_a_token_nobody_waits_for_it(
    connection: Connection, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate = shut(connection)
    left = []
    monkeypatch.setattr(gate, "wait", lambda waiting: None)
    monkeypatch.setattr(gate, "leave", left.append)
    feed(connection, b"body")
    connection.trust()
    monkeypatch.setattr(gate, "charge", pytest.fail)
    clock.pass_(0.0)
    feed(connection, b"more")
    assert connection._parser.data == [b"body", b"more"]  # type: ignore[attr-defined]
    assert left == [connection]


def test_who_has_left_does_not_wait(connection: Connection, monkeypatch: pytest.MonkeyPatch) -> None:
    gate = shut(connection)
    monkeypatch.setattr(gate, "wait", lambda waiting: None)
    left = []
    monkeypatch.setattr(gate, "leave", left.append)
    feed(connection, b"last")
    connection.connection_lost(None)
    connection.proceed()
    assert left == [connection]
    assert connection._parser.data == []  # type: ignore[attr-defined]


def test_who_fails_behind_the_gate_is_cut_off(
    connection: Connection, tcp: Tcp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shut(connection), "wait", lambda waiting: None)
    feed(connection, b"data")
    monkeypatch.setattr(connection._parser, "data_received", lambda data: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        connection.proceed()
    assert tcp.ended == "aborted"


def test_who_has_gone_needs_no_last_words(connection: Connection, tcp: Tcp, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone() -> None:
        raise OSError

    monkeypatch.setattr(tcp, "write_eof", gone)
    connection.unread = True
    connection.close()
    assert tcp.ended == "aborted"


def test_who_left_while_waiting_is_not_parsed(
    connection: Connection, tcp: Tcp, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours, theirs = socket.socketpair()
    monkeypatch.setattr(tcp, "get_extra_info", lambda name, default=None: ours)
    monkeypatch.setattr(shut(connection), "wait", lambda waiting: None)
    with ours:
        feed(connection, b"first")
        connection.proceed()
        feed(connection, b"second")
        theirs.close()
        connection.proceed()
    assert connection._parser.data == [b"first"]  # type: ignore[attr-defined]
    assert tcp.ended == "aborted"


def test_who_shows_the_token_has_taken_nothing_of_the_others(
    connection: Connection, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate = connection._registry.gate
    costs(monkeypatch, 60.0)
    feed(connection, b"refused")
    connection.serve()
    connection.expect()
    left = gate._bucket.level
    connection._release()
    monkeypatch.setattr(gate, "wait", lambda waiting: None)
    connection.serve()
    feed(connection, b"let in")
    connection.proceed()
    assert gate._bucket.level < left - 50.0
    connection.trust()
    assert gate._bucket.level == pytest.approx(left, abs=1.0)
