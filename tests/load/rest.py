"""Stills over REST at a steady rate, whether earlier ones are answered or not."""

import asyncio
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import httpx

from tests.load.figures import Row, spread
from tests.load.target import Target

MAX_UNDER_WAY = 256
BUSY = (429, 503)  # the service says that it has enough to do: no error


@dataclass(frozen=True)
class Stills:
    """What is asked for, so many times a second."""

    rate: float = 1.0
    size: tuple[int, int] = (640, 360)
    scene: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def body(self) -> dict[str, Any]:
        """Of the request, for a picture that is rendered each time: all are of one view."""
        scene = {} if self.scene is None else {"scene": self.scene}
        return {"size": self.size, "settings": {"skip": {"unchanged_camera": False}, **self.settings}} | scene


@dataclass
class Answers:
    """What came back."""

    statuses: Counter[int] = field(default_factory=Counter)
    waits: list[float] = field(default_factory=list)  # of those that were rendered [ms]
    size: int = 0
    errors: Counter[str] = field(default_factory=Counter)
    asked: int = 0


async def ask(http: httpx.AsyncClient, stills: Stills, answers: Answers) -> None:
    """One still; `answers` has what came of it."""
    began = perf_counter()
    answers.asked += 1
    try:
        answer = await http.post("/api/v1/render", json=stills.body, headers={"Accept": "image/jpeg"})
    except httpx.HTTPError as error:
        answers.errors[f"render: {type(error).__name__}: {error}"] += 1
        return
    answers.statuses[answer.status_code] += 1
    if answer.status_code == 200:
        answers.waits.append(1e3 * (perf_counter() - began))
        answers.size += len(answer.content)
    elif answer.status_code not in BUSY:
        answers.errors[f"render: {answer.status_code}: {answer.text[:200]}"] += 1


async def drive(target: Target, stills: Stills, seconds: float, answers: Answers) -> None:
    """Ask for stills at their rate for so long, then wait for the last ones."""
    under_way: set[asyncio.Task[None]] = set()
    began = perf_counter()
    async with target.http() as http, asyncio.TaskGroup() as tasks:
        for number in range(int(seconds * stills.rate)):
            await asyncio.sleep(max(began + number / stills.rate - perf_counter(), 0.0))
            if len(under_way) >= MAX_UNDER_WAY:
                answers.errors["render: too many are under way to ask for more"] += 1
                continue
            task = tasks.create_task(ask(http, stills, answers))
            under_way.add(task)
            task.add_done_callback(under_way.discard)


def rest_row(answers: Answers, seconds: float) -> Row:
    """The answers in figures."""
    return {
        "seconds": seconds,
        "asked": answers.asked,
        "rendered_a_second": len(answers.waits) / seconds,
        "wait": spread(answers.waits),
        "bytes": answers.size,
        "statuses": {str(status): count for status, count in sorted(answers.statuses.items())},
        "errors": dict(answers.errors),
    }
