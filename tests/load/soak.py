"""Hours of a service in minutes: viewers come and go and change their minds, stills and uploads; memory is watched."""

import asyncio
import random
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import httpx
import trimesh
from websockets.exceptions import WebSocketException

from tests.load import probe
from tests.load.crowd import walking
from tests.load.figures import Row, slope
from tests.load.rest import Answers, Stills, ask
from tests.load.target import Target
from tests.load.viewer import Plan, Viewer

SAMPLE_SECONDS = 1.0
WARM_UP = 0.25  # share of the time until memory must be flat: caches fill
SCENE_SECONDS = 20.0  # that most newcomers choose the same scene
UPLOAD_SECONDS = 20.0
AWAY_SECONDS, STAY_SECONDS, CHANGE_SECONDS = (0.5, 5.0), (10.0, 40.0), (3.0, 8.0)
MB = 1e6
# What viewers change their settings to, beside what the plan wants.
CHANGES: tuple[dict[str, Any], ...] = (
    {},
    {"component": "indirect"},
    {"component": "direct"},
    {"fuzziness": 3},
    {"smooth": False},
    {"clustering": "sps"},
    {"method": "path"},
)


@dataclass(frozen=True)
class Soak:
    """What goes on: for how long, with how many viewers at most, each as of `plan`; stills a second; MB a minute."""

    plan: Plan
    seconds: float
    viewers: int = 6
    rest_rate: float = 0.2
    growth: float = 1.0


@dataclass
class Record:
    """What has happened. samples: memory [MB] by what has it, viewers and frames so far, each second."""

    samples: list[dict[str, float]] = field(default_factory=list)
    errors: Counter[str] = field(default_factory=Counter)
    frames: int = 0
    visits: int = 0
    changes: int = 0
    uploads: int = 0
    answers: Answers = field(default_factory=Answers)


class Life:
    """All that goes on at the same time; each method does its part until it is cancelled."""

    def __init__(self, target: Target, http: httpx.AsyncClient, what: Soak, scenes: Sequence[str]) -> None:
        self.record = Record()
        self._target = target
        self._http = http
        self._what = what
        self._scenes = scenes
        self._began = perf_counter()

    async def come_and_go(self, slot: int) -> None:
        """One viewer after the other, by the seed and the slot."""
        plan, record = self._what.plan, self.record
        chance = random.Random(1000 * plan.seed + slot)
        while True:
            await asyncio.sleep(chance.uniform(*AWAY_SECONDS))
            mine = replace(plan, seed=chance.randrange(10**6), scene=self._scene(), decode=slot == 0)
            try:
                async with walking(self._target, mine) as viewer:
                    record.visits += 1
                    try:
                        await self._stay(viewer, chance)
                    finally:
                        record.frames += len(viewer.log.seen)
                        record.errors.update(viewer.log.errors)
                        if viewer.log.closed:
                            record.errors[f"closed with {viewer.log.closed}"] += 1
            except (OSError, WebSocketException) as error:
                record.errors[f"{type(error).__name__}: {error}"] += 1

    async def stills(self) -> None:
        """Stills at their rate."""
        async with asyncio.TaskGroup() as tasks:
            while self._what.rest_rate:
                await asyncio.sleep(1.0 / self._what.rest_rate)
                plan = self._what.plan
                stills = Stills(self._what.rest_rate, plan.size, self._scene(), plan.settings)
                tasks.create_task(ask(self._http, stills, self.record.answers))

    async def uploads(self) -> None:
        """A box is brought, looked at and taken away, again and again."""
        box = bytes(trimesh.creation.box().export(file_type="glb"))
        while True:
            await asyncio.sleep(UPLOAD_SECONDS)
            answer = await self._http.post("/api/v1/scenes", params={"name": "box.glb"}, content=box)
            if self._refused("upload", answer):
                continue
            scene = answer.json()["scene"]["id"]
            await ask(self._http, Stills(size=(64, 36), scene=scene), self.record.answers)
            self._refused("delete", await self._http.delete(f"/api/v1/scenes/{scene}"))
            self.record.uploads += 1

    async def watch(self) -> None:
        """A sample of memory each second."""
        samples = self.record.samples
        while True:
            due = self._began + SAMPLE_SECONDS * (len(samples) + 1)
            await asyncio.sleep(max(due - perf_counter(), 0.0))
            samples.append(await self._memory() | {"seconds": perf_counter() - self._began})

    async def _stay(self, viewer: Viewer, chance: random.Random) -> None:
        """Walk for a while and change something now and then."""
        leave = perf_counter() + chance.uniform(*STAY_SECONDS)
        while perf_counter() < leave and viewer.log.closed is None:
            await asyncio.sleep(chance.uniform(*CHANGE_SECONDS))
            await viewer.change(**self._change(chance))
            self.record.changes += 1

    def _change(self, chance: random.Random) -> dict[str, Any]:
        plan = self._what.plan
        match chance.randrange(4):
            case 0:
                return {"scene": self._scene()}
            case 1:
                half = chance.choice([1, 2])
                return {"size": [plan.size[0] // half, plan.size[1] // half]}
            case 2:
                return {"settings": {**plan.settings, "seed": chance.randrange(2)}}  # few: light is kept
            case _:
                return {"settings": {**plan.settings, **chance.choice(CHANGES)}}

    def _scene(self) -> str:
        """The scene of the moment: they take turns, so that each is loaded again and again."""
        return self._scenes[int((perf_counter() - self._began) / SCENE_SECONDS) % len(self._scenes)]

    def _refused(self, what: str, answer: httpx.Response) -> bool:
        if answer.is_error:
            self.record.errors[f"{what}: {answer.status_code}: {answer.text[:200]}"] += 1
        return answer.is_error

    async def _memory(self) -> dict[str, float]:
        metrics = await probe.scrape(self._http)
        sample = {"web_mb": metrics["process_resident_memory_bytes"] / MB, "viewers": metrics["lumenwalk_viewers"]}
        if metrics.get("lumenwalk_device_memory_bytes"):
            sample["device_mb"] = metrics["lumenwalk_device_memory_used_bytes"] / MB
        process = self._target.process
        if process is not None and (workers := probe.workers_of(process.pid)):
            sample["worker_mb"] = sum(map(probe.rss_bytes, workers)) / MB
        return sample


async def soak(target: Target, what: Soak) -> Row:
    """Do it all, and return what became of it. First all is rendered once: kernels are compiled once in a process."""
    async with target.http() as http:
        scenes = [scene["id"] for scene in (await http.get("/api/v1/scenes")).json()]
        restarts = (await probe.state(http))["restarts"]
        answers = Answers()
        for scene, change in [(scene, {}) for scene in scenes] + [(scenes[0], change) for change in CHANGES]:
            await ask(http, Stills(size=(64, 36), scene=scene, settings={**what.plan.settings, **change}), answers)
        life = Life(target, http, what, scenes)
        life.record.errors.update(answers.errors)
        with suppress(TimeoutError):
            async with asyncio.timeout(what.seconds), asyncio.TaskGroup() as tasks:
                for task in (life.watch(), life.stills(), life.uploads()):
                    tasks.create_task(task)
                for slot in range(what.viewers):
                    tasks.create_task(life.come_and_go(slot))
        if again := (await probe.state(http))["restarts"] - restarts:
            life.record.errors["the renderer was lost"] += again
    life.record.errors.update(life.record.answers.errors)
    return soak_row(life.record, what)


def soak_row(record: Record, what: Soak) -> Row:
    """The record in figures: how memory grows after the warm-up, in MB a minute, and what is wrong."""
    settled = [sample for sample in record.samples if sample["seconds"] >= WARM_UP * what.seconds]
    growth, missed = {}, []
    for name in sorted({name for sample in settled for name in sample if name.endswith("_mb")}):
        having = [sample for sample in settled if name in sample]
        line = slope([sample["seconds"] / 60.0 for sample in having], [sample[name] for sample in having])
        growth[name] = {"mb_a_minute": line.gain, "error": line.error, "last": having[-1][name]}
        if line.gain > what.growth and line.significant:
            missed.append(f"{name[:-3]} memory grows by {line.gain:.2f} ± {line.error:.2f} MB a minute")
    missed += [f"{count} × {error}" for error, count in record.errors.items()]
    return {
        "seconds": what.seconds,
        "frames": record.frames,
        "visits": record.visits,
        "changes": record.changes,
        "uploads": record.uploads,
        "stills": {str(status): count for status, count in record.answers.statuses.items()},
        "growth": growth,
        "missed": missed,
        "samples": record.samples,
    }
