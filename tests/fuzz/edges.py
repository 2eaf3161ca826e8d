"""What of the readers a file reaches."""

import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

READERS = str(Path(__file__).resolve().parents[2] / "gpu" / "scene")
Edge = tuple[str, int, int]
"""A step in a file, from one line to another."""


class Edges:
    """Which steps from line to line of the readers have been seen, and by a number each."""

    def __init__(self) -> None:
        self.numbers: dict[Edge, int] = {}
        self._now: set[Edge] = set()

    def reached(self, do: Callable[[], bool]) -> tuple[bool, set[Edge]]:
        """What `do` returns, and the steps that it takes."""
        self._now = set()
        sys.settrace(self._watch)
        try:
            return do(), self._now
        finally:
            sys.settrace(None)

    def numbered(self, edges: set[Edge]) -> tuple[frozenset[int], bool]:
        """The numbers of `edges`, and whether any of them is new."""
        before = len(self.numbers)
        numbers = frozenset(self.numbers.setdefault(edge, len(self.numbers)) for edge in edges)
        return numbers, len(self.numbers) > before

    def _watch(self, frame: FrameType, _: str, __: Any) -> Any:
        """For sys.settrace: follow the readers alone."""
        if not frame.f_code.co_filename.startswith(READERS):
            return None
        file, last = frame.f_code.co_filename, [0]

        def line(at: FrameType, event: str, _: Any) -> Any:
            if event == "line":
                self._now.add((file, last[0], at.f_lineno))
                last[0] = at.f_lineno
            return line

        return line
