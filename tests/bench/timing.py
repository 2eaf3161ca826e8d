"""Times of frames: each stage's spread over a walk that ends at the camera, so that nothing is kept from before."""

from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import Any

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.film.frame import FrameStats
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera, Floats
from gpu.settings import RenderSettings
from tests.bench.figures import spread

WARM_UP, FRAMES = 5, 25
STEP_DEGREES = 0.1
# Slow methods: no new frame after this, whatever number was asked for.
LONGEST_SECONDS = 6.0


@dataclass(frozen=True)
class Measured:
    """A frame from the camera, and the times [ms] of the frames that led there: of each stage and of all together."""

    radiance: Floats
    stats: FrameStats
    frames: int
    stages: dict[str, dict[str, float]]
    frame_ms: dict[str, float]

    def row(self) -> dict[str, Any]:
        """Times, counts and skips as they go into a results file."""
        return {
            "frames": self.frames,
            "frame_ms": self.frame_ms,
            "stages": self.stages,
            "counts": self.stats.counts,
            "skips": self.stats.skips,
        }


def measure_frames(
    renderer: Renderer,
    camera: Camera,
    frames: int = FRAMES,
    warm_up: int = WARM_UP,
    step: float = STEP_DEGREES,
    *,
    walks: bool = False,
) -> Measured:
    """Turn towards `camera` in `frames` steps after `warm_up` others; fewer when that takes LONGEST_SECONDS.

    step: [degrees]; with 0 all frames are of one view. walks: each may build on the one before.
    """
    begun = perf_counter()
    for number in range(warm_up, 0, -1):
        renderer.render(rotated(camera, step * (frames + number)), walks=walks)
        if number == warm_up:
            begun = perf_counter()  # the first frame loads its kernels, or compiles them
        elif perf_counter() - begun > LONGEST_SECONDS / 2.0:
            break
    runs: list[dict[str, float]] = []
    for number in range(frames - 1, 0, -1):
        if perf_counter() - begun > LONGEST_SECONDS:
            break
        runs.append(renderer.render(rotated(camera, step * number), walks=walks).stats.stage_ms)
    frame = renderer.render(camera, walks=walks)
    runs.append(frame.stats.stage_ms)
    stages = {name: spread([run[name] for run in runs]) for name in runs[-1]}
    return Measured(frame.radiance(), frame.stats, len(runs), stages, spread([sum(run.values()) for run in runs]))


def load_kernels(device_scene: DeviceScene, settings: RenderSettings) -> None:
    """Render a very small picture, so that a slow method's only frame does not count the loading of its kernels."""
    small = {"vpls": 64, "vpl_clusters": 8, "sp_clusters": 8, "samples": 1}
    Renderer(device_scene, (8, 8), settings.model_copy(update=small)).render(device_scene.scene.cameras[0])


def light_times(device_scene: DeviceScene, settings: RenderSettings, repeats: int) -> dict[str, dict[str, float]]:
    """Times [ms] of what is done once per light: tracing VPLs and clustering them, after one run to warm up."""
    moments: list[tuple[str, float]] = []

    def note(what: str, _: float) -> None:
        wp.synchronize_device(device_scene.device)
        moments.append((what, perf_counter()))

    runs: list[dict[str, float]] = []
    for _ in range(repeats + 1):
        moments.clear()
        Renderer(device_scene, (8, 8), settings, note)
        runs.append({what: 1e3 * (after - before) for (what, before), (_, after) in pairwise(moments)})
    return {what: spread([run[what] for run in runs[1:]]) for what in runs[-1]}
