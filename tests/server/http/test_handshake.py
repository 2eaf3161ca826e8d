import pytest

from server.http.handshake import is_handshake

HEADERS = {
    b"upgrade": b"WebSocket",
    b"connection": b"keep-alive, Upgrade",
    b"sec-websocket-version": b"13",
    b"sec-websocket-key": b"dGhlIHNhbXBsZSBub25jZQ==",
}


def test_a_handshake() -> None:
    assert is_handshake("GET", "1.1", HEADERS.items())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (b"upgrade", b"h2c"),
        (b"connection", b"keep-alive"),
        (b"sec-websocket-version", b"8"),
        (b"sec-websocket-key", b"short"),
        (b"sec-websocket-key", b"c2hvcnQ="),
        (b"content-length", b"5"),
        (b"transfer-encoding", b"chunked"),
    ],
)
def test_what_is_none(name: bytes, value: bytes) -> None:
    assert not is_handshake("GET", "1.1", {**HEADERS, name: value}.items())
    assert name not in HEADERS or not is_handshake(
        "GET", "1.1", {k: v for k, v in HEADERS.items() if k != name}.items()
    )


def test_only_get_of_http_1_1() -> None:
    assert not is_handshake("POST", "1.1", HEADERS.items())
    assert not is_handshake("GET", "1.0", HEADERS.items())


def test_a_key_is_given_once() -> None:
    twice = [*HEADERS.items(), (b"sec-websocket-key", HEADERS[b"sec-websocket-key"])]
    assert not is_handshake("GET", "1.1", twice)
