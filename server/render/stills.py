"""A picture of one frame or the mean of many, rendered one frame at a time, so that others have their turns between."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from server.render.engine_pool import EnginePool
from server.render.schedule import Urgency
from server.render.worker_link import InnocentLossError, WorkerLostError
from server.wire.worker import Done, Render

MOST_INNOCENT = 5  # losses of the worker by others, after which a picture is given up


async def render_frames(
    engines: EnginePool,
    job: Render,
    frames: int,
    urgency: Urgency,
    *,
    turn_seconds: float | None = None,
    max_losses: int = 0,
    told: Callable[[int], None] = lambda _: None,
) -> tuple[Done, bytes]:
    """The mean of `frames` frames of `job`, and their times together.

    If they are more than one, the job's viewer number must be the caller's own. told: hears how many are in.
    After a loss of the worker the frames start anew, up to `max_losses` times without a frame more than before, and
    MOST_INNOCENT times where it was lost in others' turns. Raises what the futures of `Engine.submit` do, and
    WorkerLostError also when a turn does not come within `turn_seconds`.
    """
    samples = most = losses = innocent = 0
    render_ms, encode_ms, stage_ms = 0.0, 0.0, Counter[str]()
    while True:
        last = samples + 1 == frames
        sample = None if frames == 1 else samples
        order = replace(job, sample=sample, output=job.output if last else "none")
        try:
            done, image = await engines.ask(order.viewer, order, urgency, turn_seconds)
            assert isinstance(done, Done)
            if done.samples <= samples:
                raise InnocentLossError("the renderer was started again, and what it had rendered was lost")
        except WorkerLostError as error:
            is_innocent = isinstance(error, InnocentLossError)
            innocent, losses = innocent + is_innocent, losses + (not is_innocent)
            if losses > max_losses or innocent > MOST_INNOCENT:
                raise
            samples = 0
            told(samples)
            continue
        samples = done.samples
        render_ms, encode_ms = render_ms + done.render_ms, encode_ms + done.encode_ms
        stage_ms.update(done.stage_ms)
        if samples > most:
            most, losses = samples, 0
            told(samples)
        if samples >= frames:
            return replace(done, render_ms=render_ms, encode_ms=encode_ms, stage_ms=dict(stage_ms)), image
