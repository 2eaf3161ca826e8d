"""Reads a file in a copy of this process, since libraries that are not Python may end it, or never end."""

import os
import pickle
import signal
import traceback
from collections.abc import Callable
from pathlib import Path
from resource import RLIMIT_CPU, setrlimit
from typing import TypeVar

MOST_SECONDS = 20  # of processor time
T = TypeVar("T")


class FaultError(Exception):
    """What was raised in a copy: where, and its traceback."""

    def __init__(self, place: str, why: str) -> None:
        super().__init__(place, why)
        self.place, self.why = place, why


def place_of(error: Exception) -> str:
    """The kind of an error and where it was raised, as a name for a folder."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}-{Path(last.filename).stem}-{last.lineno}"


def told(error: Exception) -> str:
    """An error with its traceback."""
    return "".join(traceback.format_exception(error))


class EndedError(Exception):
    """A library ended the process: `args` has by which signal."""


def apart(do: Callable[[], T]) -> T:
    """What `do` returns, in a copy of this process. Raises FaultError for what it raises, or EndedError."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        _answer(do, writing)
    os.close(writing)
    with os.fdopen(reading, "rb") as answer:
        read = answer.read()
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status) or not read:
        ended = os.WTERMSIG(status) if os.WIFSIGNALED(status) else signal.SIGABRT
        raise EndedError(signal.Signals(ended).name)
    result, error = pickle.loads(read)
    if error is not None:
        raise error
    return result  # type: ignore[no-any-return]


def _answer(do: Callable[[], T], writing: int) -> None:
    """In the child: tell and end, whatever happens."""
    try:
        setrlimit(RLIMIT_CPU, (MOST_SECONDS, MOST_SECONDS))
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)  # libraries complain there
        os.dup2(null, 2)
        try:
            result = pickle.dumps((do(), None))
        except Exception as error:
            result = pickle.dumps((None, FaultError(place_of(error), told(error))))
        with os.fdopen(writing, "wb") as answer:
            answer.write(result)
    finally:
        os._exit(0)
