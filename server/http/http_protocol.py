"""HTTP/1.1 of one connection: uvicorn's protocol over llhttp, with ends to what a request may be before it is one."""

from typing import Any, cast

from uvicorn.config import Config
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol
from uvicorn.server import ServerState

from server.errors import ErrorBody
from server.http.connection import KEY, Connection

# Of a head, of chunks' extensions or of trailers, before anything comes of them; as many as other servers take.
MAX_HEAD_BYTES = 65_536


class HttpProtocol(HttpToolsProtocol):
    """Tells its connection what it is about: waiting for a request, serving one, and whether its body has come."""

    def __init__(self, config: Config, server_state: ServerState, app_state: dict[str, Any], _loop: Any = None) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self._fruitless = 0  # bytes that nothing has come of
        self._fruitful = False  # something has come of the last ones
        self._in_head = False

    @property
    def _connection(self) -> Connection:
        return cast(Connection, self.transport)

    def data_received(self, data: bytes) -> None:
        """Parse it; 431 when too much comes before a head or trailers end."""
        self._fruitful = False
        super().data_received(data)
        self._fruitless = 0 if self._fruitful else self._fruitless + len(data)
        if self._fruitless > MAX_HEAD_BYTES:
            self.refuse(431, "too-large", f"a request's headers may take up to {MAX_HEAD_BYTES} bytes")

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
        """The head has come: the request begins to be served. ValueError when it does not say for whom it is."""
        self._in_head = False
        self._fruitful = True
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
        self._connection.unread = False
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """A request is answered: the next one may come, unless the body of this one still does."""
        super().on_response_complete()
        if not self.pipeline:
            self._connection.expect()

    def send_400_response(self, msg: str) -> None:
        """What has come is no HTTP."""
        self.refuse(400, "bad-request", msg)

    def refuse(self, status: int, code: str, message: str) -> None:
        """Say what is wrong with a request that the application never sees, and close."""
        if self.cycle is not None and not self.cycle.response_complete:
            self.transport.abort()  # it would be taken for the answer to the request before
            return
        body = ErrorBody(code=code, message=message).model_dump_json().encode()
        headers = [
            *self.server_state.default_headers,
            (b"content-type", b"application/json"),
            (b"content-length", str(len(body)).encode()),
            (b"connection", b"close"),
        ]
        lines = [name + b": " + value + b"\r\n" for name, value in headers]
        self.transport.write(b"".join([STATUS_LINE[status], *lines, b"\r\n", body]))
        self._connection.unread = True  # whatever it is
        self.transport.close()
