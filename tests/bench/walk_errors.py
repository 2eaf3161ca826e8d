"""Times of a walk's stages and errors of its last frame: `python -m tests.bench.walk_errors DEVICE SCENE [REFERENCE]`.

Half a degree a frame up to the scene's camera, default settings, a line of JSON for each of a few seeds. SCENE: a file
or a built-in scene; REFERENCE: an .npz of its picture from the camera, `full`, with the file's own materials, whose
size the walk has, too. Means of ratios hang on few pixels, in glass and at lamps: `trimmed` is without the worst.
"""

import json
import sys
from pathlib import Path
from statistics import median

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.load import load_scene
from gpu.scene.types import Camera, Doubles, Floats
from gpu.settings import RenderSettings
from gpu.warm_up import warm_up
from tests.bench.walk import STEP_DEGREES

SIZE, SEEDS, FIRST, FRAMES = (1024, 576), 3, 10, 55
# Of the pixels, those whose error is the largest.
WORST = 0.005


def trimmed(render: Floats, reference: Doubles) -> float:
    """relMSE of all pixels but the worst, which count as right; (height, width, 3) each."""
    mean = reference.mean(axis=-1)
    squares = ((render.astype(np.float64) - reference) ** 2).mean(axis=-1)
    parts = np.sort((squares / (mean**2 + 0.01 * mean.mean() ** 2)).ravel())
    return float(parts[: round(len(parts) * (1.0 - WORST))].sum() / len(parts))


def measure(renderer: Renderer, camera: Camera, reference: Doubles | None) -> dict[str, object]:
    """A row of one walk: medians [ms] of the stages' sum and of each."""
    view, stages = renderer.new_view(), []
    for number in range(FRAMES - 1, -1, -1):
        frame = renderer.render(rotated(camera, STEP_DEGREES * number), view=view, walks=True)
        stages.append(frame.stats.stage_ms)
    stages, radiance = stages[FIRST:], frame.radiance()
    row: dict[str, object] = {
        "sum_ms": round(median(sum(each.values()) for each in stages), 3),
        "stages_ms": {name: round(median(each[name] for each in stages), 3) for name in stages[-1]},
        "mean": float(radiance.mean()),
    }
    if reference is not None:
        row["trimmed"] = round(trimmed(radiance, reference), 6)
        row["energy"] = round(float(radiance.mean() / reference.mean()), 5)
    return row


def main(device: str, name: str, file: str | None = None) -> None:
    reference, size = None, SIZE
    if file:
        with np.load(file) as arrays:
            reference = arrays["full"].astype(np.float64)
        size = reference.shape[1], reference.shape[0]
    device_scene = DeviceScene(load_scene(name), device)
    warm_up(device_scene, RenderSettings())
    for seed in range(SEEDS):
        renderer = Renderer(device_scene, size, RenderSettings(seed=seed))
        row = {
            "scene": Path(name).name,
            "size": list(size),
            "seed": seed,
            **measure(renderer, device_scene.scene.cameras[0], reference),
        }
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
