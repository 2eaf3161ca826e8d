"""The real renderer with several lanes, tiny and on the CPU, where frames seem to be on their way for a while."""

import gc
import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import pytest
from harness import IDENTITY

import server.worker.renderer_pool
from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING
from gpu.renderer import Renderer
from gpu.settings import RenderSettings
from server.wire.worker import CameraMatrix, Render, SceneRef, Start
from server.worker.backend import GpuBackend
from server.worker.tasks import Tasks, Turn

BOX = SceneRef("box", "cornell-box")
SETTINGS = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)
LANES = 3
Pictures = list[bytes | Exception]


class Sky:
    """Where frames are: they land once it is open, unless their lane is broken."""

    open = True
    broken: int | None = None


class SlowLane(Lane):
    """Of a CPU."""

    count = 0

    def __init__(self, device: Any) -> None:
        super().__init__(device)
        self.number, SlowLane.count = SlowLane.count, SlowLane.count + 1

    def flight(self) -> Any:
        return self

    def is_over(self) -> bool:
        return Sky.open

    def wait(self) -> None:
        if Sky.broken == self.number:
            raise RuntimeError("an illegal access")


@pytest.fixture(scope="module")
def started(cpu: str) -> Iterator[GpuBackend]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server.worker.renderer_pool, "frames_at_once", lambda device: LANES)
        patch.setattr(server.worker.renderer_pool, "LANES_A_FRAME", 1)
        patch.setattr(server.worker.renderer_pool, "Lane", SlowLane)
        backend = GpuBackend()
        backend.start(Start(BOX, cpu), lambda what, fraction: None, Tasks())
        yield backend


@pytest.fixture
def backend(started: GpuBackend) -> Iterator[GpuBackend]:
    for viewer in range(9):
        started.leave(viewer)
    Frames.tasks = Tasks()
    DEVICE_SHARING.begin(Frames.tasks)
    yield started
    DEVICE_SHARING.begin(None)
    Sky.open, Sky.broken = True, None


def job(viewer: int, number: int = 0) -> Render:
    """A frame of a viewer's walk; each has its own way."""
    view = CameraMatrix((*IDENTITY[:12], 0.5 + 0.02 * number, 0.5, 3.0 - 0.4 * viewer, 1.0), 0.7)
    return Render(viewer, BOX, view, (32, 18), SETTINGS, ".npy", walks=True)


class Frames:
    """What becomes of jobs that a backend does by turns."""

    requests, tasks = 0, Tasks()

    def __init__(self, backend: GpuBackend) -> None:
        self._backend = backend
        self.pictures: Pictures = []

    def begin(self, *jobs: Render) -> list[Turn]:
        self.pictures = [b""] * len(jobs)
        return [self._start(partial(self._render, place, it)) for place, it in enumerate(jobs)]

    def end(self) -> Pictures:
        Sky.open = True
        while self.tasks.poll_seconds is not None:
            if (request := self.tasks.ready()) is not None:
                self.tasks.resume(request)
        return self.pictures

    def _start(self, work: Callable[[], None]) -> Turn:
        Frames.requests += 1
        return self.tasks.start(Frames.requests, work)

    def _render(self, place: int, it: Render) -> None:
        try:
            picture = self._backend.render(it, lambda what, fraction: None)
        except RuntimeError as error:
            self.pictures[place] = error
        else:
            assert picture.radiance is not None
            self.pictures[place] = picture.radiance.tobytes()


def alone(backend: GpuBackend, viewer: int, frames: int = 1) -> Pictures:
    """A walk while nobody else is there, who leaves then."""
    walk = Frames(backend)
    pictures = []
    for number in range(frames):
        walk.begin(job(viewer, number))
        pictures += walk.end()
    backend.leave(viewer)
    return pictures


def test_viewers_whose_frames_are_on_the_device_at_once_see_what_each_sees_alone(backend: GpuBackend) -> None:
    viewers, steps = (1, 2, 3, 4), 3
    expected = [alone(backend, viewer, steps) for viewer in viewers]
    assert backend.lanes == LANES
    frames, seen = Frames(backend), []
    for number in range(steps):
        Sky.open = False
        assert frames.begin(*(job(viewer, number) for viewer in viewers)) == [Turn.OPEN] * len(viewers)
        assert DEVICE_SHARING.in_flight == LANES  # the fourth shares the first one's lane
        seen.append(frames.end())
    assert [list(walk) for walk in zip(*seen, strict=True)] == expected
    assert len({picture for walk in expected for picture in walk}) == steps * len(viewers)


def test_a_viewer_that_leaves_and_a_scene_that_is_closed_take_nothing_from_a_frame(backend: GpuBackend) -> None:
    expected = [*alone(backend, 1), *alone(backend, 2)]
    frames = Frames(backend)
    Sky.open = False
    frames.begin(job(1), job(2))
    scene = weakref.ref(backend._scenes[BOX].device_scene)
    backend.leave(1)
    backend.close(BOX)
    assert backend.scenes() == ()
    assert frames.end() == expected
    frames.begin()
    gc.collect()
    assert scene() is None
    assert alone(backend, 1) == expected[:1]


def test_a_frame_that_fails_takes_nothing_from_those_of_other_lanes(backend: GpuBackend) -> None:
    expected = [*alone(backend, 1), *alone(backend, 2)]
    frames, Sky.open = Frames(backend), False
    frames.begin(job(1), job(2))
    Sky.broken = SlowLane.count - LANES  # the first viewer's
    failure, picture = frames.end()
    assert isinstance(failure, RuntimeError)
    assert picture == expected[1]
    Sky.broken = None
    frames.begin(job(1))
    assert frames.end() == expected[:1]  # by arrays that are new


def test_who_walks_does_not_wait_for_another_s_renderer_to_be_made(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    Frames(backend).begin(job(1))
    found = False

    class SlowRenderer(Renderer):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            DEVICE_SHARING.leave_until(lambda: found)
            super().__init__(*args, **kwargs)

    monkeypatch.setattr(server.worker.renderer_pool, "Renderer", SlowRenderer)
    frames = Frames(backend)
    frames.begin(replace(job(2), size=(40, 20)), job(1, 1))
    while (request := Frames.tasks.ready()) is not None:
        Frames.tasks.resume(request)
    assert frames.pictures[0] == b""
    assert frames.pictures[1]
    found = True
    assert frames.end()[0]


def test_one_who_needs_light_while_another_s_is_made_has_that_made_in_its_own_turns(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who refines a picture gets no turn beside one who walks."""
    tasks, said, done = Frames.tasks, list[str](), list[int]()
    monkeypatch.setattr(tasks, "turn_seconds", 0.0)
    anew = SETTINGS.model_copy(update={"skip": SETTINGS.skip.model_copy(update={"unchanged_lights": False})})

    def render(viewer: int, number: int, settings: RenderSettings) -> None:
        picture = replace(job(viewer, number), settings=settings)
        backend.render(picture, lambda words, _: said.append(words))
        done.append(viewer)

    render(1, 0, anew)
    said.clear()
    Frames.requests += 2
    first, second = Frames.requests - 1, Frames.requests
    tasks.ask_back(first)
    turn = tasks.start(first, partial(render, 1, 1, anew))
    while "tracing virtual point lights" not in said:
        tasks.ask_back(first)
        turn = tasks.resume(first)
    assert turn is Turn.GIVEN_BACK
    turn = tasks.start(second, partial(render, 2, 0, SETTINGS.model_copy(update={"vpls": 300})))
    for _ in range(1000):
        if turn is Turn.OPEN:
            turn = tasks.resume(second)
    assert turn is Turn.ENDED
    while tasks.knows(first):
        tasks.resume(first)
    assert sorted(done) == [1, 1, 2]


def test_turns_of_a_frame_that_another_waits_for_are_no_time_of_that_one_s_own(
    backend: GpuBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    now, own, tasks = [0.0], list[float](), Frames.tasks
    monkeypatch.setattr("gpu.core.sharing.perf_counter", lambda: now[0])
    monkeypatch.setattr(tasks, "turn_seconds", 0.0)

    def render(number: int) -> None:
        begun = DEVICE_SHARING.own_time()
        backend.render(job(1, number), lambda what, fraction: None)
        own.append(DEVICE_SHARING.own_time() - begun)

    Frames.requests += 2
    first, second = Frames.requests - 1, Frames.requests
    tasks.ask_back(first)
    assert tasks.start(first, partial(render, 0)) is Turn.GIVEN_BACK
    now[0] += 100.0
    turn = tasks.start(second, partial(render, 1))
    while turn is Turn.OPEN:
        now[0] += 1.0
        turn = tasks.resume(second)
    assert own == [0.0, 0.0]
