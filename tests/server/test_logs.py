import json
import logging
import os
import sys
from collections.abc import Iterator
from contextvars import copy_context
from threading import Thread

import pytest

from server.logs import bind, configure
from server.wire.log_format import LogFormat

log = logging.getLogger("lumenwalk.test")


@pytest.fixture(autouse=True)
def _root() -> Iterator[None]:
    """The root logger as it was, afterwards."""
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    root.handlers = []
    yield
    root.handlers, root.level = handlers, level


def event() -> None:
    bind(viewer=7)
    try:
        raise ValueError("of a test")
    except ValueError:
        log.exception("it failed\nbadly", extra={"frame": 12})


def test_json_is_one_object_a_line_with_ids_and_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    configure(LogFormat.JSON)
    copy_context().run(event)
    log.info("after %d", 1)
    first, second = capsys.readouterr().err.splitlines()
    told = json.loads(first)
    assert told["time"].endswith("Z")
    assert (told["level"], told["logger"], told["message"]) == ("error", "lumenwalk.test", "it failed\nbadly")
    assert (told["viewer"], told["frame"]) == (7, 12)
    assert "ValueError: of a test" in told["exception"]
    assert json.loads(second)["message"] == "after 1"
    assert "viewer" not in json.loads(second)


def test_text_has_the_fields_at_the_end_of_its_line(capsys: pytest.CaptureFixture[str]) -> None:
    configure(LogFormat.TEXT)
    copy_context().run(event)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].endswith(r"it failed\nbadly viewer=7 frame=12")
    assert lines[-1] == "ValueError: of a test"


def test_what_a_client_says_makes_no_line_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    configure(LogFormat.TEXT)
    log.info("viewer left", extra={"reason": "bye\n2026-01-01 ERROR all is lost\x1b[2J\u2028é"})
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(r"reason=bye\n2026-01-01 ERROR all is lost\x1b[2J\u2028é")


def test_questions_to_replicas_are_no_lines(capsys: pytest.CaptureFixture[str]) -> None:
    configure(LogFormat.TEXT)
    logging.getLogger("httpx").info("HTTP Request: GET http://10.0.0.2:8000/r/0/readyz")
    assert capsys.readouterr().err == ""


def test_a_pipe_that_nobody_reads_stops_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines are lost until it has room again; those of a long one's pieces that it has room for are there."""
    reads, writes = os.pipe()
    with open(writes, "w", buffering=1) as writer, open(reads, "rb", buffering=0) as reader:  # noqa: PTH123
        monkeypatch.setattr(sys, "stderr", writer)
        configure(LogFormat.TEXT)
        logs = Thread(target=lambda: [log.info("%d %s", number, "x" * 3000) for number in range(100)], daemon=True)
        logs.start()
        logs.join(20.0)
        assert not logs.is_alive()
        told = reader.read(1 << 20)
        assert 50_000 < len(told) < 100_000
        log.info("there is room")
        assert reader.read(1 << 20).endswith(b": there is room\n")
