import asyncio

import pytest
from engines import FakeEngine, order

from gpu.errors import UserError
from server.render.engine_pool import EnginePool
from server.render.schedule import Urgency
from server.render.stills import MOST_INNOCENT, render_frames
from server.render.worker_link import InnocentLossError, WorkerLostError
from server.wire.worker import Render


def picture(engine: FakeEngine, frames: int, max_losses: int = 0) -> tuple[list[int], float, bytes]:
    """What was told, the time of all frames, and the image."""
    told: list[int] = []
    render = render_frames(
        EnginePool([engine]), order(), frames, Urgency.REFINING, max_losses=max_losses, told=told.append
    )
    done, image = asyncio.run(render)
    return told, done.render_ms, image


def ordered(engine: FakeEngine) -> list[tuple[int | None, str]]:
    return [(job.sample, job.output) for _, _, job in engine.orders if isinstance(job, Render)]


def test_a_lone_frame_is_no_average() -> None:
    engine = FakeEngine()
    assert picture(engine, 1) == ([1], 2.0, b"image")
    assert ordered(engine) == [(None, ".png")]


def test_only_the_last_of_many_frames_is_encoded() -> None:
    engine = FakeEngine()
    assert picture(engine, 3) == ([1, 2, 3], 6.0, b"image")
    assert ordered(engine) == [(0, "none"), (1, "none"), (2, ".png")]
    assert {(client, urgency) for client, urgency, _ in engine.orders} == {(7, Urgency.REFINING)}


def test_a_lost_worker_means_starting_anew() -> None:
    engine = FakeEngine(deaths=(3,))
    told, _, image = picture(engine, 3, max_losses=1)
    assert (told, image) == ([1, 2, 0, 3], b"image")
    assert [sample for sample, _ in ordered(engine)] == [0, 1, 2, 0, 1, 2]


def test_losses_are_bounded() -> None:
    with pytest.raises(WorkerLostError):
        picture(FakeEngine(deaths=(2,)), 3)
    engine = FakeEngine(deaths=tuple(range(2, 100, 2)))
    with pytest.raises(WorkerLostError):
        picture(engine, 3, max_losses=3)
    assert len(engine.orders) == 8


def test_losses_in_the_turns_of_others_do_not_count() -> None:
    engine = FakeEngine(deaths=(2, 5), lost=InnocentLossError)
    assert picture(engine, 3)[0] == [1, 0, 2, 0, 3]
    engine = FakeEngine(deaths=tuple(range(1, 100)), lost=InnocentLossError)
    with pytest.raises(InnocentLossError):
        picture(engine, 1)
    assert len(engine.orders) == MOST_INNOCENT + 1


def test_an_error_ends_it() -> None:
    engine = FakeEngine(failure=UserError("camera: there is none"))
    with pytest.raises(UserError, match="camera"):
        picture(engine, 3, max_losses=3)
    assert len(engine.orders) == 1


def test_a_turn_is_not_waited_for_longer_than_told() -> None:
    engine = FakeEngine()

    async def stuck() -> None:
        engine.gate = asyncio.Event()
        await render_frames(EnginePool([engine]), order(), 2, Urgency.STILL, turn_seconds=0.01)

    with pytest.raises(WorkerLostError, match=r"no turn within 0\.01 s"):
        asyncio.run(stuck())
