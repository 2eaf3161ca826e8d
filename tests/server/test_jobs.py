import asyncio
import gc
import logging
import weakref
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from engines import FakeEngine, order
from harness import PATIENCE

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, LightEdit, SceneEdits
from server.jobs import Jobs, JobState, RenderJob
from server.places import asker
from server.refusals import TooBusyError, UnknownJobError
from server.render.engine_pool import EnginePool
from server.render.films import Film
from server.scenes.checker import Checker
from server.scenes.residency import Residency
from server.settings import ServerSettings
from server.video.film_settings import FilmSettings
from server.wire.worker import AlongPath


def work(engine: FakeEngine, test: Callable[[Jobs], Awaitable[None]], **settings: Any) -> None:
    """Run a test with jobs that are worked on."""

    async def run() -> None:
        engines = EnginePool([engine])
        residency = Residency(engines, Checker(ServerSettings()), 0, tuple, lambda _: None, lambda *_: None)
        limits = {"max_jobs": 4, "keep_seconds": 60.0, "keep_bytes": 1000} | settings
        jobs = Jobs(engines, residency, engine.leave, **limits)
        task = asyncio.create_task(jobs.run())
        try:
            async with asyncio.timeout(PATIENCE):
                await test(jobs)
        finally:
            task.cancel()
            await asyncio.wait([task])

    asyncio.run(run())


async def ended(jobs: Jobs, job: RenderJob) -> list[tuple[JobState, int]]:
    """What a job was seen to be until it ended."""
    return [(now.state, now.samples) async for now in jobs.watch(job)]


def test_each_worker_has_a_job_at_a_time() -> None:
    first, second = FakeEngine(), FakeEngine()
    first.scenes = second.scenes = (order(7).scene,)

    async def run() -> None:
        engines = EnginePool([first, second])
        residency = Residency(engines, Checker(ServerSettings()), 0, tuple, lambda _: None, lambda *_: None)
        jobs = Jobs(engines, residency, engines.leave, max_jobs=4, keep_seconds=60.0, keep_bytes=1000)
        gates = first.gate, second.gate = asyncio.Event(), asyncio.Event()
        task = asyncio.create_task(jobs.run())
        added = [jobs.add(order(viewer), 2, "image/png") for viewer in (7, 8, 9)]
        async with asyncio.timeout(PATIENCE):
            while [job.state for job in added] != [JobState.RUNNING, JobState.RUNNING, JobState.QUEUED]:
                await asyncio.sleep(0)
            for gate in gates:
                gate.set()
            for job in added:
                assert (await ended(jobs, job))[-1] == (JobState.DONE, 2)
        assert first.orders
        assert second.orders
        task.cancel()
        await asyncio.wait([task])

    asyncio.run(run())


def test_a_job_is_rendered_frame_by_frame_and_leaves_the_worker() -> None:
    engine = FakeEngine()

    async def test(jobs: Jobs) -> None:
        job = jobs.add(order(viewer=9), 3, "image/png")
        assert (job.state, job.progress) == (JobState.QUEUED, 0.0)
        seen = await ended(jobs, job)
        assert seen[0] == (JobState.QUEUED, 0)
        assert seen[-1] == (JobState.DONE, 3)
        assert (job.result, job.progress) == (b"image", 1.0)
        assert jobs.find(job.id) is job
        await asyncio.sleep(0)
        assert engine.left == [9]

    work(engine, test)


def test_jobs_are_done_one_after_the_other() -> None:
    engine = FakeEngine()

    async def test(jobs: Jobs) -> None:
        both = [jobs.add(order(viewer), 2, "image/png") for viewer in (1, 2)]
        for job in both:
            await ended(jobs, job)
        assert [client for client, _, _ in engine.orders if client] == [1, 1, 2, 2]

    work(engine, test)


def add(jobs: Jobs, client: str, viewer: int) -> RenderJob:
    """A job that a client asks for."""
    asker.set(client)
    return jobs.add(order(viewer), 1, "image/png")


def test_clients_have_turns_however_many_jobs_one_has() -> None:
    engine = FakeEngine()

    async def test(jobs: Jobs) -> None:
        engine.gate = asyncio.Event()
        asked = [add(jobs, client, viewer) for viewer, client in enumerate("aaabab", 1)]
        engine.gate.set()
        for job in asked:
            await ended(jobs, job)
        assert [client for client, _, _ in engine.orders if client] == [1, 4, 2, 6, 3, 5]

    work(engine, test, max_jobs=6)


def test_one_client_has_so_many_jobs_and_all_have_twice_as_many() -> None:
    async def test(jobs: Jobs) -> None:
        for client in "ab":
            for viewer in (1, 2):
                add(jobs, client, viewer)
            with pytest.raises(TooBusyError):
                add(jobs, client, 3)
        with pytest.raises(TooBusyError):
            add(jobs, "c", 4)

    engine = FakeEngine()
    engine.gate = asyncio.Event()
    work(engine, test, max_jobs=2)


def test_what_rendering_took_goes_with_the_end_of_a_job() -> None:
    async def test(jobs: Jobs) -> None:
        edits = SceneEdits(lights={"lamp": LightEdit(on=False)})
        job = jobs.add(replace(order(), edits=edits), 1, "video/mp4", Film([AlongPath((), 0.0)] * 9, FilmSettings(), 1))
        await ended(jobs, job)
        assert job.state is JobState.FAILED
        await asyncio.sleep(0)
        assert (job.film, job.render.edits, job.pictures) == (None, NO_EDITS, 9)

    work(FakeEngine(failure=UserError("camera: there is none")), test)


@pytest.mark.parametrize(
    "error", [UserError("camera: there is none"), TooBusyError("too many scenes are read already")]
)
def test_a_failed_job_says_why(error: Exception, caplog: pytest.LogCaptureFixture) -> None:
    async def test(jobs: Jobs) -> None:
        job = jobs.add(order(), 3, "image/png")
        with caplog.at_level(logging.INFO):
            await ended(jobs, job)
        assert (job.state, job.error) == (JobState.FAILED, str(error))
        (record,) = (it for it in caplog.records if it.name == "lumenwalk.jobs")
        said = record.getMessage(), *(vars(record)[name] for name in ("job", "scene", "error"))
        assert said == ("job failed", job.id, job.render.scene.id, str(error))

    work(FakeEngine(failure=error), test)


def test_a_job_survives_the_loss_of_its_worker() -> None:
    async def test(jobs: Jobs) -> None:
        job = jobs.add(order(), 3, "image/png")
        assert (await ended(jobs, job))[-1] == (JobState.DONE, 3)

    work(FakeEngine(deaths=(3,)), test)


def test_a_job_that_ends_every_worker_fails_in_the_end() -> None:
    async def test(jobs: Jobs) -> None:
        job = jobs.add(order(), 3, "image/png")
        assert (await ended(jobs, job))[-1][0] is JobState.FAILED

    work(FakeEngine(deaths=tuple(range(2, 100))), test)


def test_too_many_jobs_are_turned_away() -> None:
    async def test(jobs: Jobs) -> None:
        for _ in range(4):
            jobs.add(order(), 1, "image/png")
        with pytest.raises(TooBusyError, match="4 jobs"):
            jobs.add(order(), 1, "image/png")

    work(FakeEngine(), test)


def test_a_running_job_can_be_cancelled_and_the_next_one_runs() -> None:
    engine = FakeEngine()

    async def test(jobs: Jobs) -> None:
        engine.gate = asyncio.Event()
        first, second = (jobs.add(order(viewer), 2, "image/png") for viewer in (1, 2))
        while first.state is JobState.QUEUED:
            await asyncio.sleep(0)
        jobs.remove(first.id)
        assert first.state is JobState.CANCELLED
        with pytest.raises(UnknownJobError):
            jobs.find(first.id)
        engine.gate.set()
        assert (await ended(jobs, second))[-1][0] is JobState.DONE
        assert engine.left == [1, 2]
        assert all(client != 1 for client, _, _ in engine.orders)

    work(engine, test)


def test_a_job_that_ends_while_one_who_watches_is_busy_is_still_seen_to_end() -> None:
    engine = FakeEngine()

    async def test(jobs: Jobs) -> None:
        job = jobs.add(order(), 1, "image/png")
        seen = []
        async for now in jobs.watch(job):
            seen.append(now.state)
            while job.state is not JobState.DONE:
                await asyncio.sleep(0)
        assert seen == [JobState.QUEUED, JobState.DONE]

    work(engine, test)


def test_a_job_that_waits_can_be_cancelled() -> None:
    engine = FakeEngine()

    async def test(jobs: Jobs) -> None:
        first, second, third = (jobs.add(order(viewer), 1, "image/png") for viewer in (1, 2, 3))
        jobs.remove(second.id)
        await ended(jobs, third)
        assert (first.state, second.state) == (JobState.DONE, JobState.CANCELLED)
        assert all(client != 2 for client, _, _ in engine.orders)

    work(engine, test)


def test_results_are_kept_for_a_time_only() -> None:
    async def test(jobs: Jobs) -> None:
        job = jobs.add(order(), 1, "image/png")
        await ended(jobs, job)
        while jobs.all:
            await asyncio.sleep(0.01)

    work(FakeEngine(), test, keep_seconds=0.02)


def test_the_oldest_results_go_when_they_are_too_large() -> None:
    async def test(jobs: Jobs) -> None:
        made = [jobs.add(order(), 1, "image/png") for _ in range(3)]
        await ended(jobs, made[-1])
        while len(jobs.all) == len(made):
            await asyncio.sleep(0)
        assert jobs.all == made[1:]

    work(FakeEngine(), test, keep_bytes=len(b"image") * 2)


def test_a_forgotten_result_takes_no_memory() -> None:
    async def test(jobs: Jobs) -> None:
        held = []
        for viewer in range(3):
            job = jobs.add(order(viewer=viewer), 1, "image/png")
            held.append(weakref.ref(job))
            await ended(jobs, job)
            del job
        await asyncio.sleep(0)
        gc.collect()
        assert [job() is None for job in held] == [True, True, False]

    work(FakeEngine(), test, keep_bytes=5)


def test_jobs_that_ended_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.jobs.MAX_ENDED", 2)

    async def test(jobs: Jobs) -> None:
        for viewer in range(5):
            await ended(jobs, jobs.add(order(viewer=viewer), 1, "image/png"))
        await asyncio.sleep(0)
        assert len(jobs.all) == 2
        assert jobs.ended[JobState.FAILED] == 5

    work(FakeEngine(failure=UserError("no")), test)


def test_the_end_of_the_service_is_told() -> None:
    engine = FakeEngine()
    engine.gate = asyncio.Event()  # never opens

    async def test(jobs: Jobs) -> None:
        running, waiting = (jobs.add(order(), 1, "image/png") for _ in range(2))
        watch = asyncio.create_task(ended(jobs, running))
        while running.state is JobState.QUEUED:
            await asyncio.sleep(0)
        jobs.stop()
        assert (await watch)[-1] == (JobState.FAILED, 0)
        assert [job.state for job in (running, waiting)] == [JobState.FAILED] * 2
        assert "stopped" in waiting.error

    work(engine, test)


def test_results_are_there_for_the_next_service(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def before(jobs: Jobs) -> None:
        job = jobs.add(order(), 3, "image/png")
        await ended(jobs, job)
        (tmp_path / "file").touch()
        jobs.save(tmp_path / "file")
        assert "results of 1 jobs are lost with the service\n" in caplog.text
        jobs.save(None)
        assert "results of 1 jobs are lost with the service; `uploads_dir` would keep them" in caplog.text
        jobs.save(tmp_path / "results")
        found.append(job)

    async def after(jobs: Jobs) -> None:
        jobs.restore(tmp_path / "results")
        (job,) = jobs.all
        (was,) = found
        assert (job.id, job.state, job.result, job.media_type) == (was.id, JobState.DONE, b"image", "image/png")
        assert (job.render.scene.id, job.render.size, job.progress) == (was.render.scene.id, was.render.size, 1.0)

    found: list[RenderJob] = []
    work(FakeEngine(), before)
    work(FakeEngine(), after)
    assert list((tmp_path / "results").iterdir()) == []
