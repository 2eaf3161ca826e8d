from collections.abc import Iterator

import pytest
from harness import Running


def test_a_body_that_is_too_large_is_refused(running: Running) -> None:
    body = b" " * (running.service.settings.max_message_bytes + 1)
    response = running.http.post("/api/v1/render", content=body)
    assert (response.status_code, response.json()["code"]) == (413, "too-large")


def test_a_body_without_a_length_is_counted(running: Running) -> None:
    def chunks() -> Iterator[bytes]:
        for _ in range(running.service.settings.max_message_bytes // 1000 + 1):
            yield b" " * 1000

    assert running.http.post("/api/v1/render", content=chunks()).status_code == 413


@pytest.mark.parametrize("chunked", [True, False])
def test_a_body_within_the_limit_arrives_whole(running: Running, chunked: bool) -> None:
    body = b'{"size": [8, 8]}' + b" " * 5000
    content = iter([body[:7], body[7:]]) if chunked else body
    response = running.http.post("/api/v1/render", content=content, headers={"Content-Type": "application/json"})
    assert response.status_code == 200
