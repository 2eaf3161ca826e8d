"""A film, rendered one picture after the other, each as a still is, and encoded in a thread as they come."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np

from server.folders import TemporaryFolder
from server.render.engine_pool import EnginePool
from server.render.schedule import Urgency
from server.render.stills import render_frames
from server.video.film_file import FilmFile
from server.video.film_settings import FilmSettings
from server.video.pictures import VideoError
from server.video.playing import played
from server.wire.worker import AlongPath, Render

Value = TypeVar("Value")


@dataclass(frozen=True)
class Film:
    """What each picture shows, and how they become a film; most_bytes: that it may have; animations: how long those of
    the scene last [s], by id.
    """

    views: Sequence[AlongPath]
    settings: FilmSettings
    most_bytes: int
    animations: Mapping[str, float] = field(default_factory=dict)


async def render_film(
    engines: EnginePool,
    job: Render,
    frames: int,
    film: Film,
    *,
    max_losses: int = 0,
    told: Callable[[int], None] = lambda _: None,
) -> bytes:
    """An MP4 of pictures that are each the mean of `frames` frames of `job`, from the film's views.

    told: hears how many frames are in, of all pictures. Raises what `render_frames` does; VideoError where the film
    cannot be made, or becomes too large.
    """
    try:
        folder = TemporaryFolder()
    except OSError as error:
        raise VideoError(f"there is no place for a film in this server's temporary folder: {error.strerror}") from None
    try:
        path = folder.path / "film.mp4"
        file = await _beside(partial(FilmFile, path, job.size, film.settings))
        try:
            for index, view in enumerate(film.views):
                edits = played(job.edits, film.animations, film.settings.play, view.time - film.views[0].time)
                order = replace(job, view=view, edits=edits, output="rgb")
                _, image = await render_frames(
                    engines,
                    order,
                    frames,
                    Urgency.REFINING,
                    max_losses=max_losses,
                    told=_after(index * frames, told),
                )
                pixels = np.frombuffer(image, np.uint8).reshape(job.size[1], job.size[0], 3)
                await _beside(partial(file.add, pixels))
                if file.encoded_bytes > film.most_bytes:
                    raise VideoError(
                        f"size: after {index + 1} of {len(film.views)} pictures the film has more than the "
                        f"{film.most_bytes} bytes that results may have here; make it smaller or shorter"
                    )
            await _beside(file.finish)
        finally:
            await _beside(file.abandon)  # which may have much to write and to delete
        return await _beside(path.read_bytes)
    finally:
        folder.remove()


def _after(before: int, told: Callable[[int], None]) -> Callable[[int], None]:
    """Tells of frames as so many more than `before`."""
    return lambda count: told(before + count)


async def _beside(work: Callable[[], Value]) -> Value:
    """What `work` returns, done in a thread; who is cancelled meanwhile waits for its end, to clean up after it."""
    task = asyncio.ensure_future(asyncio.to_thread(work))
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        while not task.done():  # who cancels may do so again
            with suppress(asyncio.CancelledError):
                await asyncio.wait([task])
        raise
