"""Frames a second of a walk at default settings, and of two walks on one renderer; display included, not encoding.

All light and the files' own materials, half a degree a frame, at the size of a reference where a scene has one.
"""

from functools import partial
from time import perf_counter

import numpy as np

from gpu.film.frame import Frame
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera
from gpu.settings import RenderSettings
from tests.bench.figures import spread
from tests.bench.store import Row, Task
from tests.bench.suite import Suite
from tests.bench.timing import WARM_UP

FRAMES, STEP_DEGREES = 40, 0.5
# Of two who walk on one renderer: what either sees is hardly seen by the other.
APART_DEGREES = 75.0


def walk(renderer: Renderer, camera: Camera, frames: int, walkers: int = 1) -> tuple[Frame, list[Frame], list[float]]:
    """The last frame, all of them and how long each took [s], of walkers who take turns.

    Cameras turn a little each frame, so that the last one is nowhere the same.
    """
    views = [renderer.new_view() for _ in range(walkers)]
    timed, seconds = [], []
    for number in range(WARM_UP + frames):
        for walker, view in enumerate(views):
            begun = perf_counter()
            turned = rotated(camera, APART_DEGREES * walker + STEP_DEGREES * number)
            frame = renderer.render(turned, view=view, walks=True)
            frame.pixels()
            if number >= WARM_UP:
                seconds.append(perf_counter() - begun)
                timed.append(frame)
    return frame, timed, seconds


def measure_row(suite: Suite, name: str) -> Row:
    """One scene's walk, and two such walks on one renderer beside the second of them alone."""
    subject = suite.subject(name)
    settings = RenderSettings()
    frames = suite.frames if suite.quick else FRAMES
    renderer = Renderer(subject.device_scene, subject.size, settings)
    frame, timed, seconds = walk(renderer, subject.camera, frames)
    stages = [one.stats.stage_ms for one in timed]
    _, apart, apart_seconds = walk(renderer, rotated(subject.camera, APART_DEGREES), frames)
    _, together, together_seconds = walk(renderer, subject.camera, frames, walkers=2)
    walkers = {
        "alone_ms": [1e3 * float(np.median(times)) for times in (seconds, apart_seconds)],
        "together_ms": [1e3 * float(np.median(together_seconds[walker::2])) for walker in range(2)],
        "kept_clusters_alone": [median_skip(alone) for alone in (timed, apart)],
        "kept_clusters_together": [median_skip(together[walker::2]) for walker in range(2)],
    }
    return {
        "scene": name,
        "size": list(subject.size),
        "settings": settings.model_dump(mode="json"),
        "frames": len(seconds),
        "frames_a_second": 1.0 / float(np.median(seconds)),
        "wall_ms": spread([1e3 * second for second in seconds]),
        "stages": {stage: spread([run[stage] for run in stages]) for stage in stages[0]},
        "two_walkers": walkers,
        "counts": frame.stats.counts,
        "skips": frame.stats.skips,
    }


def median_skip(frames: list[Frame]) -> float:
    """Pairs of clusters whose visibility was kept, in the median frame."""
    return float(np.median([frame.stats.skips["kept_clusters"] for frame in frames]))


def run(suite: Suite) -> None:
    """The part of the command line."""
    suite.run("walk", [Task(suite.label(name), partial(measure_row, suite, name)) for name in suite.scene_names()])
