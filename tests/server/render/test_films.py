import asyncio
import io
from pathlib import Path
from threading import Event, get_ident

import pytest
from engines import FakeEngine, order
from harness import PATIENCE

from server.render.engine_pool import EnginePool
from server.render.films import Film, render_film
from server.render.schedule import Urgency
from server.video.film_file import FilmFile
from server.video.film_settings import FilmSettings
from server.video.pictures import VideoError
from server.wire.worker import AlongPath, Render, SceneCamera

av = pytest.importorskip("av", reason="the extra video is not installed")
KEYFRAMES = ((0.0, SceneCamera(0)), (1.0, SceneCamera(1)))
VIEWS = [AlongPath(KEYFRAMES, index / 4) for index in range(4)]
FILM = Film(VIEWS, FilmSettings(fps=4), 1 << 20)


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of temporary files."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_a_film_is_rendered_picture_by_picture(temporary: Path) -> None:
    engine, told = FakeEngine(), list[int]()
    work = render_film(EnginePool([engine]), order(viewer=9), 3, FILM, told=told.append)
    film = asyncio.run(work)
    jobs = [job for _, _, job in engine.orders if isinstance(job, Render)]
    assert [(job.view, job.sample) for job in jobs] == [(view, sample) for view in VIEWS for sample in range(3)]
    assert [job.output for job in jobs] == ["none", "none", "rgb"] * 4
    assert {(client, urgency) for client, urgency, _ in engine.orders} == {(9, Urgency.REFINING)}
    assert not any(job.walks for job in jobs)
    assert told == list(range(1, 13))
    with av.open(io.BytesIO(film)) as container:
        assert [(frame.width, frame.height) for frame in container.decode(video=0)] == [(8, 4)] * 4
    assert list(temporary.iterdir()) == []


def test_the_animation_runs_along(temporary: Path) -> None:
    engine, views = (
        FakeEngine(),
        [AlongPath(((1.0, SceneCamera(0)), *KEYFRAMES[1:]), 1.0 + view.time) for view in VIEWS],
    )
    film = Film(views, FilmSettings(fps=4), 1 << 20, {"walk": 0.5})
    asyncio.run(render_film(EnginePool([engine]), order(), 1, film))
    jobs = [job for _, _, job in engine.orders if isinstance(job, Render)]
    assert [job.edits.time for job in jobs] == [0.0, 0.25, 0.0, 0.25]


def test_a_picture_that_is_lost_is_rendered_again() -> None:
    engine, told = FakeEngine(deaths=(5,)), list[int]()
    asyncio.run(render_film(EnginePool([engine]), order(), 3, FILM, max_losses=1, told=told.append))
    assert told == [1, 2, 3, 4, 3, 5, 6, 7, 8, 9, 10, 11, 12]  # anew from the second one's first frame


def test_a_film_that_becomes_too_large_ends(temporary: Path) -> None:
    small = Film(VIEWS * 40, FilmSettings(fps=4), 100)
    with pytest.raises(VideoError, match=r"^size: after \d+ of 160 pictures the film has more than the 100 bytes"):
        asyncio.run(render_film(EnginePool([FakeEngine()]), order(), 1, small))
    assert list(temporary.iterdir()) == []


def test_a_film_that_there_is_no_place_for_is_said(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(temporary / "gone"))
    with pytest.raises(VideoError, match="temporary folder: No such file"):
        asyncio.run(render_film(EnginePool([FakeEngine()]), order(), 1, FILM))


def test_a_film_that_nobody_wants_leaves_nothing(temporary: Path) -> None:
    engine = FakeEngine()

    async def cancelled() -> None:
        engine.gate = asyncio.Event()
        task = asyncio.create_task(render_film(EnginePool([engine]), order(), 1, FILM))
        engine.gate.set()
        while len(engine.orders) < 2:
            await asyncio.sleep(0)
        assert [found.name for found in temporary.glob("*/.lumenwalk.lock")] == [".lumenwalk.lock"]
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert list(temporary.iterdir()) == []

    asyncio.run(cancelled())


def test_a_picture_is_encoded_to_its_end_however_often_the_film_is_cancelled(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on, threads = Event(), Event(), list[int]()

    def add(_film: FilmFile, _pixels: object) -> None:
        begun.set()
        go_on.wait(PATIENCE)

    def abandon(film: FilmFile) -> None:
        threads.append(get_ident())
        real_abandon(film)

    real_abandon = FilmFile.abandon
    monkeypatch.setattr(FilmFile, "add", add)
    monkeypatch.setattr(FilmFile, "abandon", abandon)

    async def cancelled() -> None:
        task = asyncio.create_task(render_film(EnginePool([FakeEngine()]), order(), 1, FILM))
        while not begun.is_set():
            await asyncio.sleep(0)
        for _ in range(3):
            task.cancel()
            for _ in range(5):
                await asyncio.sleep(0)
        assert not task.done()
        assert threads == []
        go_on.set()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert get_ident() not in threads

    asyncio.run(cancelled())
    assert threads
    assert list(temporary.iterdir()) == []
