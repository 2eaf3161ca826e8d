"""Noise of a view that rests, of all light and of direct and indirect light apart.

Means of frames by two seeds, beside the mean of many by a third: what the first two have in common is bias, which
smoothing and clusters leave and later frames take away, what differs between them is noise.
"""

from functools import partial

from gpu.renderer import Renderer
from gpu.settings import Component, RenderSettings
from tests.bench.figures import bias_and_noise
from tests.bench.still import mean_at_rest, resting
from tests.bench.store import Row, Task
from tests.bench.suite import Suite
from tests.bench.timing import load_kernels

# Frames of a mean that is looked at, and of the one that it is compared with.
MARKS, FRAMES = (1, 4, 16, 64), 300
QUICK_MARKS, QUICK_FRAMES = (1, 2), 4
SEEDS, SEED_OF_MANY = (1, 2), 3


def measure_row(suite: Suite, name: str, settings: RenderSettings) -> Row:
    """One component of a scene's light: errors of the first seed's means, and noise and bias of both seeds'."""
    subject = suite.subject(name)
    marks, frames = (QUICK_MARKS, QUICK_FRAMES) if suite.quick else (MARKS, FRAMES)
    load_kernels(subject.device_scene, settings)
    one, other = (
        [
            (seconds, frame.radiance())
            for number, seconds, frame in resting(subject, settings.model_copy(update={"seed": seed}), marks[-1])
            if number in marks
        ]
        for seed in SEEDS
    )
    many = settings.model_copy(update={"seed": SEED_OF_MANY})
    renderer = Renderer(subject.device_scene, subject.size, many)
    reference = mean_at_rest(renderer, subject.camera, subject.accumulation(), frames)
    points = []
    for number, (seconds, picture), (_, second) in zip(marks, one, other, strict=True):
        bias, noise = bias_and_noise([picture, second], reference)
        errors = suite.errors(picture, reference)
        points.append({"frames": number, "seconds": seconds, "errors": errors, "bias": bias, "noise": noise})
    return {
        "scene": name,
        "size": list(subject.size),
        "settings": settings.model_dump(mode="json"),
        "points": points,
    }


def run(suite: Suite) -> None:
    """The part of the command line."""
    settings = [suite.settings(component=component) for component in Component]
    suite.run(
        "noise",
        [
            Task(f"{suite.label(name)} {one.component.value}", partial(measure_row, suite, name, one))
            for name in suite.scene_names()
            for one in settings
        ],
    )
