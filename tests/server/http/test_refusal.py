import json

from server.http.refusal import refusal


def test_an_answer_that_ends_the_connection() -> None:
    head, _, body = refusal(431, "too-large", "no", [(b"X-Name", b"value")]).partition(b"\r\n\r\n")
    first, *lines = head.split(b"\r\n")
    assert first == b"HTTP/1.1 431 Request Header Fields Too Large"
    assert {b"X-Name: value", b"connection: close", b"content-length: %d" % len(body)} <= set(lines)
    assert json.loads(body) == {"code": "too-large", "message": "no"}
