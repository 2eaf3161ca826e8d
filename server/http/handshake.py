"""Which requests begin a WebSocket (RFC 6455, section 4.2.1); others are like any, whatever they upgrade to."""

import binascii
from base64 import b64decode
from collections.abc import Iterable

VERSION = b"13"
KEY_BYTES = 16


def is_handshake(method: str, version: str, headers: Iterable[tuple[bytes, bytes]]) -> bool:
    """Whether a request, with its method, version of HTTP and headers in lower case, begins a WebSocket."""
    given: dict[bytes, list[bytes]] = {}
    for name, value in headers:
        given.setdefault(name, []).append(value.strip())
    return (
        method == "GET"
        and version == "1.1"
        and b"websocket" in _tokens(given.get(b"upgrade", []))
        and b"upgrade" in _tokens(given.get(b"connection", []))
        and given.get(b"sec-websocket-version") == [VERSION]
        and _is_key(given.get(b"sec-websocket-key", []))
        and not given.keys() & {b"content-length", b"transfer-encoding"}
    )


def _tokens(values: Iterable[bytes]) -> list[bytes]:
    return [token.strip().lower() for value in values for token in value.split(b",")]


def _is_key(values: list[bytes]) -> bool:
    try:
        return len(values) == 1 and len(b64decode(values[0], validate=True)) == KEY_BYTES
    except binascii.Error:
        return False
