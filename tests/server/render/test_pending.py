import asyncio

import pytest

from gpu.errors import UserError
from gpu.settings import RenderSettings
from server.render.pending import PIXEL_BYTES, Answer, PendingJob
from server.wire.browser import Bounds, PickedPart, SceneInfo
from server.wire.worker import (
    MAX_EXPORT_BYTES,
    Closed,
    CloseScene,
    Done,
    Export,
    Exported,
    Job,
    Opened,
    OpenScene,
    Pick,
    Picked,
    Render,
    SceneCamera,
    SceneRef,
)

HALL = SceneRef("hall", "hall")
RENDER = Render(1, HALL, SceneCamera(0), (8, 4), RenderSettings(), "jpeg")
INFO = SceneInfo(id="hall", name="hall", cameras=(), bounds=Bounds(min=(0, 0, 0), max=(1, 1, 1)), triangles=1)
DONE, OPENED, CLOSED = Done(1, (8, 4), 1.0, 1.0, 1, 1, {}, {}, {}), Opened(1, INFO), Closed(1)
EXPORT, EXPORTED = Export(HALL), Exported(1)
PICK, PICKED = Pick(HALL, SceneCamera(0), (8, 4), (0.5, 0.5)), Picked(1, PickedPart())
JOBS = [(RENDER, DONE), (OpenScene(HALL), OPENED), (CloseScene(HALL), CLOSED), (PICK, PICKED), (EXPORT, EXPORTED)]


def pending(job: Job) -> PendingJob:
    return PendingJob(job, asyncio.get_running_loop().create_future())


@pytest.mark.parametrize(("job", "right"), JOBS)
def test_a_job_has_one_kind_of_answer(job: Job, right: Answer) -> None:
    async def main() -> None:
        other_size = Done(1, (4, 8), 1.0, 1.0, 1, 1, {}, {}, {})
        answers = (DONE, other_size, OPENED, CLOSED, PICKED, EXPORTED)
        assert [answer for answer in answers if pending(job).answered_by(answer)] == [right]

    asyncio.run(main())


def test_only_a_render_and_an_export_are_answered_with_bytes() -> None:
    async def main() -> None:
        assert pending(RENDER).most_bytes > PIXEL_BYTES * 8 * 4
        assert pending(EXPORT).most_bytes == MAX_EXPORT_BYTES
        assert pending(OpenScene(HALL)).most_bytes == pending(CloseScene(HALL)).most_bytes == 0

    asyncio.run(main())


def test_the_reply_comes_or_the_error_that_takes_its_place() -> None:
    async def main() -> None:
        good, bad, gone = pending(RENDER), pending(RENDER), pending(RENDER)
        good.resolve((DONE, b"image"))
        assert await good.reply == (DONE, b"image")
        bad.resolve(UserError("wrong"))
        with pytest.raises(UserError, match="wrong"):
            await bad.reply
        gone.reply.cancel()
        gone.resolve((DONE, b"image"))
        gone.resolve(UserError("wrong"))
        assert gone.reply.cancelled()

    asyncio.run(main())
