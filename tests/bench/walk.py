"""Frames a second of a walk at a device's default settings, display included, encoding not."""

from functools import partial
from time import perf_counter

import numpy as np

from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.settings import RenderSettings
from tests.bench.figures import spread
from tests.bench.store import Row, Task
from tests.bench.suite import Suite
from tests.bench.timing import WARM_UP

FRAMES, STEP_DEGREES = 40, 0.5


def measure_row(suite: Suite, name: str) -> Row:
    """One scene's walk: the camera turns a little each frame, so that the last one is nowhere the same."""
    subject = suite.subject(name)
    settings = RenderSettings()
    renderer = Renderer(subject.device_scene, suite.size, settings)
    seconds, stages = [], []
    for number in range(WARM_UP + (suite.frames if suite.quick else FRAMES)):
        begun = perf_counter()
        frame = renderer.render(rotated(subject.camera, STEP_DEGREES * number), walks=True)
        frame.pixels()
        if number >= WARM_UP:
            seconds.append(perf_counter() - begun)
            stages.append(frame.stats.stage_ms)
    return {
        "scene": name,
        "size": list(suite.size),
        "settings": settings.model_dump(mode="json"),
        "frames": len(seconds),
        "frames_a_second": 1.0 / float(np.median(seconds)),
        "wall_ms": spread([1e3 * second for second in seconds]),
        "stages": {stage: spread([run[stage] for run in stages]) for stage in stages[0]},
        "counts": frame.stats.counts,
        "skips": frame.stats.skips,
    }


def run(suite: Suite) -> None:
    """The part of the command line."""
    size = "x".join(map(str, suite.size))
    suite.run("walk", [Task(f"{name} {size}", partial(measure_row, suite, name)) for name in suite.scene_names()])
