"""HTTP/1.1 of one connection: uvicorn's protocol over llhttp, with ends to what a request may be before it is one."""

from collections.abc import Sequence
from typing import Any, cast

from httptools import HttpParserError, HttpParserUpgrade, HttpRequestParser
from uvicorn.config import Config
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.server import ServerState

from server.http.connection import KEY, Connection
from server.http.handshake import is_handshake
from server.http.refusal import refusal

# Of a head, of chunks' extensions or of trailers, before anything comes of them; as many as other servers take.
MAX_HEAD_BYTES = 65_536
# Of a request: what each takes to be understood adds up before a token is looked for.
MAX_PATH_BYTES = 8192
MAX_PARTS = 200  # headers, parameters, or cookies
MAX_PIPELINED = 3  # requests that may come before the one that is being answered is
HOP_BY_HOP = (b"connection", b"upgrade", b"http2-settings")  # that ask for an upgrade


class HttpProtocol(HttpToolsProtocol):
    """Tells its connection what it is about: waiting for a request, serving one, and whether its body has come."""

    def __init__(self, config: Config, server_state: ServerState, app_state: dict[str, Any], _loop: Any = None) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self._fruitless = 0  # bytes that nothing has come of
        self._fruitful = False  # something has come of the last ones
        self._in_head = False
        self._broken = False  # nothing more is understood

    @property
    def _connection(self) -> Connection:
        return cast(Connection, self.transport)

    def data_received(self, data: bytes) -> None:
        """Parse it; 431 when too much comes before a head or trailers end."""
        if self._broken:
            return
        self._fruitful = False
        self._unset_keepalive_if_required()
        self._parse(data)
        self._fruitless = 0 if self._fruitful else self._fruitless + len(data)
        if self._fruitless > MAX_HEAD_BYTES:
            self.refuse(431, "too-large", f"a request's headers may take up to {MAX_HEAD_BYTES} bytes")

    def _parse(self, data: bytes) -> None:
        while data and not self._broken:
            try:
                self.parser.feed_data(data)
                return
            except HttpParserUpgrade as upgrade:
                if self._should_upgrade():
                    self.handle_websocket_upgrade()
                    return
                if self.scope["method"] == "CONNECT":
                    self.refuse(400, "bad-request", "CONNECT is for proxies")
                    return
                data = self._plain_head() + data[upgrade.args[0] :]
                self._renew_parser()
            except HttpParserError:
                self.logger.warning("Invalid HTTP request received.")
                self.refuse(400, "bad-request", "this is no HTTP/1.1 request")
                return

    def _renew_parser(self) -> None:
        self.parser = HttpRequestParser(self)
        # What follows a request that ends the connection is no fault (as uvicorn has it).
        self.parser.set_dangerous_leniencies(lenient_data_after_close=True)

    def _should_upgrade(self) -> bool:
        return is_handshake(self.scope["method"], self.parser.get_http_version(), self.headers)

    def _plain_head(self) -> bytes:
        """The head of a request that asks for an upgrade which there is not, without that (RFC 9110, 7.8)."""
        first = f"{self.scope['method']} ".encode() + self.url + f" HTTP/{self.parser.get_http_version()}".encode()
        kept = [name + b": " + value for name, value in self.headers if name not in HOP_BY_HOP]
        return b"\r\n".join([first, *kept]) + b"\r\n\r\n"

    @property
    def _elsewhere(self) -> bool:
        """Whether what is parsed asks for an upgrade that there is not: it comes again, without that."""
        return self.parser.should_upgrade() and not self._should_upgrade()

    def on_message_begin(self) -> None:
        """The first bytes of a request."""
        super().on_message_begin()
        self._in_head = True
        cast(dict[str, Any], self.scope)["extensions"] = {KEY: self.transport}

    def on_header(self, name: bytes, value: bytes) -> None:
        """One header; what comes behind a body is left out."""
        if self._in_head:
            super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """The head has come: the request begins to be served.

        ValueError when it does not say for whom it is, has too many parts, or too many before it are not answered.
        """
        self._in_head = False
        self._fruitful = True
        self.scope["method"] = self.parser.get_method().decode("ascii")
        if self._elsewhere:
            return
        if len(self.pipeline) >= MAX_PIPELINED:
            raise ValueError("too many requests at once")
        _check_parts(self.url, self.headers)
        hosts = sum(name == b"host" for name, _ in self.headers)
        if hosts > 1 or (hosts == 0 and self.parser.get_http_version() == "1.1"):
            raise ValueError("a request names one host")
        self._connection.serve()
        before = self.cycle
        super().on_headers_complete()
        self._connection.unread = self.cycle is not before

    def on_body(self, body: bytes) -> None:
        """A piece of a body."""
        self._fruitful = True
        super().on_body(body)

    def on_message_complete(self) -> None:
        """All of a request has come."""
        self._fruitful = True
        if self._elsewhere:
            return
        self._connection.unread = False
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """A request is answered: the next one may come, unless the body of this one still does."""
        super().on_response_complete()
        if not self.pipeline:
            self._connection.expect()

    def refuse(self, status: int, code: str, message: str) -> None:
        """Say what is wrong with a request that the application does not see, or not to its end, and close.

        Where an answer to an earlier request, or a part of this one's, is on its way, that is all there will be.
        """
        self._broken = True
        cycle = self.cycle
        if cycle is not None and not cycle.response_complete:
            if cycle.more_body and cycle.response_started:
                self.transport.abort()  # what would come now would be taken for the rest of the answer
                return
            if not cycle.more_body or self.pipeline:
                cycle.keep_alive = False
                return
            cycle.disconnected = True  # to the application, the client has left
            cycle.message_event.set()
        self.transport.write(refusal(status, code, message, self.server_state.default_headers))
        self._connection.unread = True  # whatever it is
        self.transport.close()


def _check_parts(url: bytes, headers: Sequence[tuple[bytes, bytes]]) -> None:
    """ValueError where a request has too long a path, or too many headers, parameters or cookies."""
    path, _, query = url.partition(b"?")
    cookies = sum(value.count(b";") + 1 for name, value in headers if name == b"cookie")
    if len(path) > MAX_PATH_BYTES or max(len(headers), query.count(b"&") + 1, cookies) > MAX_PARTS:
        raise ValueError("a request has too many parts")
