"""A view that rests: error over time while its frames are averaged, against path tracing spread over the pixels.

Such a picture has noise of its own, which a view that converges ends at: so there is also the error beyond that noise,
by a second picture of other paths.
"""

from collections.abc import Iterator
from functools import partial
from time import perf_counter

import numpy as np

from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera, Floats
from gpu.settings import Component, Method, RenderSettings
from gpu.warm_up import warm_up
from tests.bench.figures import error_beyond_noise
from tests.bench.goals import STILL_SECONDS
from tests.bench.store import Row, Task
from tests.bench.subjects import Subject
from tests.bench.suite import Suite

# A view is looked at for so long, or so many frames.
MOST_SECONDS, FRAMES, QUICK_FRAMES = 10.0, 2048, 4
TILES = 8  # in each direction, in which the first frame is compared with the mean
REFERENCE_PATHS = 16  # paths a pixel in each frame of a reference that is rendered here
SECOND_PATHS, SECOND_SEED = 256, 303  # of the second one


def run(suite: Suite) -> None:
    """The part of the command line."""
    settings = suite.settings(component=Component.FULL)
    tasks = [Task(suite.label(name), partial(measure_row, suite, name, settings)) for name in suite.scene_names()]
    suite.run("still", tasks)


def tile_changes(first: np.ndarray, picture: np.ndarray) -> np.ndarray:
    """How much the mean of each of TILES × TILES tiles of a picture differs from that of the first, relatively.

    Tiles that are nearly black are taken to have a hundredth of the picture's mean.
    """

    def means(image: np.ndarray) -> np.ndarray:
        rows = np.array_split(image, TILES, axis=0)
        return np.array([[tile.mean() for tile in np.array_split(row, TILES, axis=1)] for row in rows])

    before = means(first)
    return np.abs(means(picture) - before) / np.maximum(before, 0.01 * first.mean())


def tile_change(first: np.ndarray, picture: np.ndarray) -> float:
    """The most that any of `tile_changes` is."""
    return float(np.max(tile_changes(first, picture)))


def is_kept(number: int, seconds: float, following: float) -> bool:
    """Whether frame `number`, ready after so many `seconds`, is a power of two or the last within the goal's.

    following: seconds after which the next one is ready.
    """
    return number & (number - 1) == 0 or seconds <= STILL_SECONDS < following


def trace_spread(suite: Suite, subject: Subject, samples: int, seed: int = 0) -> Floats:
    """All light by about so many paths a pixel, spread over the pixels."""
    number = min(samples, REFERENCE_PATHS)
    paths = suite.settings(component=Component.FULL, method=Method.PATH, samples=number, seed=seed)
    renderer = Renderer(subject.device_scene, subject.size, paths)
    return mean_at_rest(renderer, subject.camera, subject.accumulation(), max(1, samples // REFERENCE_PATHS))


def mean_at_rest(renderer: Renderer, camera: Camera, mean: Accumulation, frames: int) -> Floats:
    """What is left in `mean` by so many frames of a view, (height, width, 3)."""
    for _ in range(frames):
        frame = renderer.render(camera, mean)
    return frame.radiance()


def resting(subject: Subject, settings: RenderSettings, frames: int) -> Iterator[tuple[int, float, Frame]]:
    """Number, from 1, of each frame of a view that rests, seconds of rendering until it is ready, and the mean so far.

    That lies in the arrays that the next frame is rendered into.
    """
    renderer, mean = Renderer(subject.device_scene, subject.size, settings), subject.accumulation()
    # The first frame's kernels and arrays are not the rest's; of another view, since this one's would be kept.
    renderer.render(rotated(subject.camera, 1.0), mean)
    mean.restart()
    seconds = 0.0
    for number in range(1, frames + 1):
        begun = perf_counter()
        frame = renderer.render(subject.camera, mean)
        seconds += perf_counter() - begun
        yield number, seconds, frame


def measure_row(suite: Suite, name: str, settings: RenderSettings) -> Row:
    """One scene: seconds since the view came to rest, and errors, at each power of two of frames and after one."""
    subject = suite.subject(name)
    trace = partial(trace_spread, suite, subject)
    reference, second = subject.spread_reference(trace), trace(suite.count(SECOND_PATHS), SECOND_SEED)
    warm_up(subject.device_scene, settings)
    seconds, pictures = 0.0, []
    for number, following, frame in resting(subject, settings, QUICK_FRAMES if suite.quick else FRAMES):
        if number > 1 and not is_kept(number - 1, seconds, following):
            pictures.pop()
        seconds = following
        pictures.append((number, seconds, frame.radiance()))
        if seconds > MOST_SECONDS:
            break
    return {
        "scene": name,
        "size": list(subject.size),
        "settings": settings.model_dump(mode="json"),
        "points": [
            {
                "frames": number,
                "seconds": time,
                "errors": suite.errors(picture, reference),
                "rel_mse_beyond_noise": error_beyond_noise(picture, reference, second),
                "tile_change": tile_change(pictures[0][2], picture),
            }
            for number, time, picture in pictures
        ],
    }
