"""Flicker: how a walk's frames change beyond what those of `exact-vpl` with the same VPLs do."""

from dataclasses import asdict, replace
from functools import cache, partial
from typing import Any

import numpy as np

from gpu.film.metrics import rel_mse
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera, Floats
from gpu.settings import Method, RenderSettings
from tests.bench import paper
from tests.bench.figures import flicker
from tests.bench.store import Row, Task
from tests.bench.subjects import Subject
from tests.bench.suite import CLUSTERS, Suite
from tests.bench.sweep import title

FRAMES, QUICK_FRAMES = 12, 3
STEP_DEGREES, STEP_LENGTH = 0.5, 1e-3
SETTINGS: tuple[dict[str, Any], ...] = (
    CLUSTERS,
    *({"sp_clusters": sps, "vpl_clusters": vpls} for sps, vpls in paper.SETTINGS),
    {**CLUSTERS, "fuzziness": 1},
    {**CLUSTERS, "weighting": "average"},
)


def walk(camera: Camera, extent: float, frames: int) -> list[Camera]:
    """A walk from `camera` to its right, turning left; a step is STEP_LENGTH of the scene's `extent` in world units."""
    path = []
    for number in range(frames):
        forth = camera.to_world.copy()
        forth[:3, 3] += camera.to_world[:3, 0] * (STEP_LENGTH * extent * number)
        path.append(rotated(replace(camera, to_world=forth), STEP_DEGREES * number))
    return path


def render_walk(subject: Subject, settings: RenderSettings, frames: int) -> Floats:
    """The walk's frames by one renderer, (frame, height, width, 3)."""
    renderer = Renderer(subject.device_scene, subject.size, settings)
    extent = 1.0 / subject.device_scene.scene.placement.scale
    return np.stack([renderer.render(camera, walks=True).radiance() for camera in walk(subject.camera, extent, frames)])


def run(suite: Suite) -> None:
    """The part of the command line: one scene after the other, so that only one reference walk is in memory."""
    frames = QUICK_FRAMES if suite.quick else FRAMES
    vpls = suite.count(paper.VPLS)

    @cache
    def reference_of(name: str) -> Floats:
        settings = suite.settings(method=Method.EXACT_VPL, vpls=vpls)
        return render_walk(suite.subject(name), settings, frames)

    def measure_row(name: str, settings: RenderSettings) -> Row:
        subject = suite.subject(name)
        renders, references = render_walk(subject, settings, frames), reference_of(name)
        errors = [rel_mse(x, r) for x, r in zip(renders, references, strict=True)]
        return {
            "scene": name,
            "size": list(subject.size),
            "frames": frames,
            "settings": settings.model_dump(mode="json"),
            "clustering_rel_mse": {"mean": float(np.mean(errors)), "worst": float(np.max(errors))},
            **asdict(flicker(renders, references)),
        }

    for name in suite.scene_names():
        choices = [
            suite.settings(**changes | {key: suite.count(changes[key]) for key in CLUSTERS}, vpls=vpls)
            for changes in SETTINGS
        ]
        tasks = [Task(f"{suite.label(name)} {title(choice)}", partial(measure_row, name, choice)) for choice in choices]
        suite.run("temporal", tasks)
        reference_of.cache_clear()
