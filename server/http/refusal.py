"""An answer that is written below the application, to what it never sees."""

from collections.abc import Iterable
from http import HTTPStatus

from server.errors import ErrorBody


def refusal(status: int, code: str, message: str, headers: Iterable[tuple[bytes, bytes]]) -> bytes:
    """An HTTP/1.1 answer {code, message} after which the connection ends; headers: what each answer has."""
    body = ErrorBody(code=code, message=message).model_dump_json().encode()
    lines = [
        f"HTTP/1.1 {status} {HTTPStatus(status).phrase}".encode(),
        *(name + b": " + value for name, value in headers),
        b"content-type: application/json",
        f"content-length: {len(body)}".encode(),
        b"cache-control: no-store",
        b"connection: close",
    ]
    return b"\r\n".join(lines) + b"\r\n\r\n" + body
