"""The log, on stderr: one line an event, readable or JSON, with the ids of the viewer and request that it is about.

`bind` attaches fields to all that a task logs from then on, and the tasks that it starts; `extra` of a single call adds
others, such as `frame`. Nothing that is logged holds a query string or a header, so no token either. What a pipe has no
room for is lost: who started the service and does not read it must not stop it.
"""

import json
import logging
import sys
import time
from collections.abc import Mapping
from contextvars import ContextVar
from select import PIPE_BUF, select
from types import MappingProxyType
from typing import Any, TextIO

from server.wire.log_format import LogFormat

_bound: ContextVar[Mapping[str, Any]] = ContextVar("lumenwalk_log_fields", default=MappingProxyType({}))
_STANDARD = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName", "color_message"}


PIECE = PIPE_BUF // 4  # characters: bytes that a pipe takes at once if it takes any


def bind(**fields: Any) -> None:
    """Add fields to everything that the current task logs from now on."""
    _bound.set({**_bound.get(), **fields})


def configure(format_: LogFormat) -> None:
    """Write the log of this process to stderr in this format."""
    handler = _PipeHandler(sys.stderr)
    handler.setFormatter(JsonFormatter() if format_ is LogFormat.JSON else TextFormatter())
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
    logging.getLogger("httpx").setLevel(logging.WARNING)  # else each question to a replica is a line


def has_room(stream: TextIO) -> bool:
    """Whether a piece can be written without waiting for somebody to read."""
    try:
        return bool(select([], [stream], [], 0.0)[1])
    except OSError:  # it is no file of the system
        return True


class _PipeHandler(logging.StreamHandler[TextIO]):
    """Writes what there is room for."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line, or as much of it as there is room for."""
        line = f"{self.format(record)}\n"
        try:
            for begin in range(0, len(line), PIECE):
                if not has_room(self.stream):
                    return
                self.stream.write(line[begin : begin + PIECE])
                self.flush()
        except OSError:
            self.handleError(record)


class TextFormatter(logging.Formatter):
    """`time LEVEL logger: message viewer=3 frame=7`, and the traceback in lines of its own."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 (logging's own name)
        """The first line."""
        line = " ".join([super().formatMessage(record), *(f"{name}={it}" for name, it in _fields(record).items())])
        # Clients have a say in some of it, such as why they close, and must not write lines of their own.
        return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)


class JsonFormatter(logging.Formatter):
    """An object with time (UTC), level, logger, message, the fields, and a traceback under `exception`."""

    def format(self, record: logging.LogRecord) -> str:
        """One line."""
        seconds = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        event: dict[str, Any] = {
            "time": f"{seconds}.{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        event |= {name: it for name, it in _fields(record).items() if name not in event}
        if record.exc_info:
            event["exception"] = self.formatException(record.exc_info)
        return json.dumps(event, default=str)


def _fields(record: logging.LogRecord) -> dict[str, Any]:
    return {**_bound.get()} | {name: it for name, it in vars(record).items() if name not in _STANDARD}
