"""Rows of measurements in JSON files that a later run goes on with, and the budget of time that a run has."""

import json
import os
import platform
import subprocess
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from time import monotonic
from typing import Any

import warp as wp

from gpu.errors import UserError

Row = dict[str, Any]
# Rows whose errors are still being computed while the next ones are rendered.
WAITING = 12


def environment(device: wp.Device) -> dict[str, str]:
    """What the figures were measured on and with; $COMMIT names the commit of a tree that came without git."""
    describe = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    git = subprocess.run(describe, capture_output=True, text=True, check=False).stdout.strip()
    return {
        "device": device.name,
        "cores": str(os.cpu_count()),
        "warp": wp.config.version,
        "python": platform.python_version(),
        "commit": os.environ.get("COMMIT") or git or "unknown",
    }


class Budget:
    """A number of seconds from now on; None is no limit."""

    def __init__(self, seconds: float | None, clock: Callable[[], float] = monotonic) -> None:
        self._clock, self._end = clock, None if seconds is None else clock() + seconds

    def spent(self) -> bool:
        """Whether the time is over."""
        return self._end is not None and self._clock() >= self._end

    def share(self, parts: int) -> "Budget":
        """One of `parts` equal shares of what is left."""
        return Budget(None if self._end is None else (self._end - self._clock()) / parts, self._clock)

    def at_most(self, seconds: float) -> "Budget":
        """So many seconds from now on, or what is left if that is less."""
        return Budget(seconds if self._end is None else min(seconds, self._end - self._clock()), self._clock)


class Results:
    """The rows of one part in a JSON file, each with a `key` of its own, saved whenever one is added.

    Values of a row may be futures. Rows of other commits stay until they are measured again; rows of another device
    do not mix with these. Raises UserError when the file is of another device, or not of this suite.
    """

    def __init__(self, path: Path, surroundings: dict[str, str]) -> None:
        self._path, self._environment = path, surroundings
        self._rows: dict[str, Row] = {}
        self._waiting: list[Row] = []
        if path.exists():
            rows = read_rows(path)
            devices = {row["environment"]["device"] for row in rows} - {surroundings["device"]}
            if devices:
                raise UserError(f"{path}: has rows of {', '.join(devices)}; give this device another --out")
            self._rows = {row["key"]: row for row in rows}

    def has(self, key: str) -> bool:
        """Whether this commit's row is there already."""
        row = self._rows.get(key)
        return row is not None and row["environment"]["commit"] == self._environment["commit"]

    def add(self, key: str, row: Row) -> None:
        """Add a row, or put it in place of an older commit's."""
        self._waiting.append({"key": key, **row, "environment": self._environment})
        while self._waiting and (len(self._waiting) > WAITING or _ready(self._waiting[0])):
            self._save_first()

    def close(self) -> None:
        """Wait for the rows that are not finished and save them."""
        while self._waiting:
            self._save_first()

    def _save_first(self) -> None:
        row = _settled(self._waiting.pop(0))
        self._rows[row["key"]] = row
        self._path.parent.mkdir(parents=True, exist_ok=True)
        partial = self._path.with_suffix(".partial")
        partial.write_text(json.dumps({"rows": list(self._rows.values())}, indent=1, allow_nan=False) + "\n")
        partial.replace(self._path)


@dataclass(frozen=True)
class Task:
    """One row to be measured, and the key that tells it from all others of its part."""

    key: str
    measure: Callable[[], Row]


def run_tasks(tasks: Iterable[Task], results: Results, budget: Budget, say: Callable[[str], None] = print) -> int:
    """Measure what `results` lack, in order, until the budget is spent; returns how many were left out."""
    left = 0
    try:
        for task in tasks:
            if results.has(task.key):
                continue
            if budget.spent():
                left += 1
                continue
            say(task.key)
            results.add(task.key, task.measure())
    finally:
        results.close()
    if left:
        say(f"the time is over; {left} rows are left for another run")
    return left


def read_rows(path: Path) -> list[Row]:
    """The rows of a results file. Raises UserError when it is none."""
    try:
        rows: list[Row] = json.loads(path.read_text())["rows"]
        if not all("key" in row and "environment" in row for row in rows):
            raise KeyError("key")
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: is not a results file of this suite; give another --out or remove it") from error
    return rows


def _ready(value: Any) -> bool:
    """Whether no future in `value` is still running."""
    if isinstance(value, dict):
        return all(_ready(item) for item in value.values())
    if isinstance(value, list):
        return all(map(_ready, value))
    return not isinstance(value, Future) or value.done()


def _settled(value: Any) -> Any:
    """`value` with the results of its futures, and None for numbers that JSON does not have."""
    if isinstance(value, Future):
        return _settled(value.result())
    if isinstance(value, dict):
        return {name: _settled(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_settled(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return value
