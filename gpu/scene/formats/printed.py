"""What libraries in C++ print, which would spoil the output of the command that called them."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_STANDARD_OUTPUT = 1
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")


@contextmanager
def printed_lines() -> Iterator[list[str]]:
    """A list that has, once the block is left, the lines that the process printed on its standard output within it.

    They end after as much as a pipe holds, 64 KiB.
    """
    lines: list[str] = []
    sys.stdout.flush()
    reading, writing = os.pipe()
    os.set_blocking(writing, False)  # more than the pipe holds is lost, and nobody waits
    kept = os.dup(_STANDARD_OUTPUT)
    os.dup2(writing, _STANDARD_OUTPUT)
    try:
        yield lines
    finally:
        os.dup2(kept, _STANDARD_OUTPUT)
        os.close(kept)
        os.close(writing)
        with os.fdopen(reading, "rb") as pipe:
            text = pipe.read().decode(errors="replace")
        lines += [line.strip() for line in _COLOURS.sub("", text).splitlines() if line.strip()]
