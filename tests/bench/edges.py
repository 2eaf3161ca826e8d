"""Edges in a walk: its last frame against path tracing spread over the pixels, with `antialias` and without.

A walk steps to its left, turns right and ends at the scene's camera; then it rests, as in the service: the mean begins
with the walk's last frame. Pictures of both last frames and of the reference, side by side, go into OUT/edges.
"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from gpu.renderer import Renderer
from gpu.scene.types import Floats
from gpu.settings import Component, RenderSettings
from tests.bench.figures import spread
from tests.bench.pictures import displayed
from tests.bench.still import tile_changes, trace_spread
from tests.bench.store import Row, Task
from tests.bench.subjects import Subject
from tests.bench.suite import Suite
from tests.bench.temporal import walk

# Frames of a walk, and how many of them times are the median of, when all kernels are loaded and graphs captured.
FRAMES, TIMED, QUICK_FRAMES = 32, 20, 4
# Frames of the view that rests, of which the last mean is compared with the walk's last frame.
RESTING, QUICK_RESTING = 64, 2


def measure_walk(subject: Subject, settings: RenderSettings, frames: int, resting: int) -> tuple[Floats, Floats, Row]:
    """The last frame of a walk, the mean of so many `resting` there, and the walk's times."""
    renderer = Renderer(subject.device_scene, subject.size, settings)
    extent = 1.0 / subject.device_scene.scene.placement.scale
    times, stages = [], []
    for camera in reversed(walk(subject.camera, extent, frames)):
        frame = renderer.render(camera, walks=True)
        stages.append(frame.stats.stage_ms)
        times.append(sum(frame.stats.stage_ms.values()))
    last = frame.radiance()  # before another frame is rendered into its array
    accumulation = subject.accumulation()
    for number in range(resting):
        frame = renderer.render(subject.camera, accumulation, walks=number == 0)
    named = {name: spread([one[name] for one in stages[-TIMED:]]) for name in stages[-1]}
    return last, frame.radiance(), {"frame_ms": spread(times[-TIMED:]), "stages": named}


def save_pictures(path: Path, pictures: list[Floats]) -> None:
    """Write them side by side; three times the mean of the last is white."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(displayed(np.concatenate(pictures, axis=1), 3.0 * float(pictures[-1].mean()))).save(path)


def changes_at_rest(last: Floats, rests: Floats) -> Row:
    """How much tiles of the `last` frame of a walk change as the view rests: of radiance, and as a display shows them,
    where three times the mean is white.
    """
    white = 3.0 * float(rests.mean())
    shown = displayed(last, white), displayed(rests, white)
    changes = {"radiance": tile_changes(last, rests), "shown": tile_changes(*shown)}
    return {name: {**spread(tiles), "worst": float(tiles.max())} for name, tiles in changes.items()}


def measure_row(suite: Suite, name: str, settings: RenderSettings) -> Row:
    """One scene: errors of the last frame and times of the walk with and without, and how much it changes at rest."""
    subject = suite.subject(name)
    reference = subject.spread_reference(partial(trace_spread, suite, subject))
    frames, resting = (QUICK_FRAMES, QUICK_RESTING) if suite.quick else (FRAMES, RESTING)
    row: dict[str, Any] = {"scene": name, "size": list(subject.size), "settings": settings.model_dump(mode="json")}
    pictures = []
    for label, antialias in (("with", True), ("without", False)):
        choice = settings.model_copy(update={"antialias": antialias})
        last, rests, times = measure_walk(subject, choice, frames, resting)
        pictures.append(last)
        errors = suite.errors(last, reference)
        row[label] = {**times, "errors": errors, "change_at_rest": changes_at_rest(last, rests)}
    save_pictures(suite.out / "edges" / f"{name}.png", [*pictures, reference])
    return row


def run(suite: Suite) -> None:
    """The part of the command line."""
    settings = suite.settings(component=Component.FULL)
    tasks = [Task(suite.label(name), partial(measure_row, suite, name, settings)) for name in suite.scene_names()]
    suite.run("edges", tasks)
