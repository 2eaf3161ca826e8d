"""Views that nobody tuned for, of all light and the scene's own materials, beside path tracing.

`python -m tests.bench.elsewhere DEVICE FOLDER [SCENE …]`: a line of JSON for each view, and its pictures in FOLDER, to
look at. SCENE: as for `lumenwalk render`, or one of `tests.bench.unseen`. A view is a camera of the latter, of others
the first, or that turned, tilted or moved; measured are the last frame of a walk that ends there, a single frame, and a
mean at rest.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, replace
from math import cos, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.film.metrics import measure
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.load import load_scene
from gpu.scene.types import Camera, Doubles, Floats, Scene
from gpu.settings import Method, RenderSettings
from tests.bench.figures import error_beyond_noise
from tests.bench.pictures import displayed
from tests.bench.still import mean_at_rest, tile_change
from tests.bench.timing import load_kernels
from tests.bench.unseen import ROOMS
from tests.bench.walk import STEP_DEGREES

SCENES = ("living-room", "conference-room", "atrium", *ROOMS)
SIZE = (960, 612)
WALKED, RESTING = 10, 60  # frames of a walk, and of a mean at rest
# The reference: two means of so many frames, of so many paths a pixel each.
PATH_FRAMES, PATHS, SEEDS = 120, 4, (1, 2)
WHITE = 95.0  # percentile of the reference that is shown as white
# Blotches are what is left after a blur over this share of the width (its standard deviation is half of that).
BLOTCH = 1.0 / 30.0
# A pixel stands out that is so many times as bright as all of the reference's around it, or as dark.
STANDS_OUT, AROUND = 2.5, 5
# Degrees to the left and upwards, and of the scene's diagonal ahead.
VIEWS = {
    "own": (0.0, 0.0, 0.0),
    "left": (75.0, -8.0, 0.0),
    "back": (170.0, 5.0, 0.0),
    "right": (-70.0, -15.0, 0.0),
    "near": (25.0, -12.0, 0.06),
}


def scene_of(name: str) -> Scene:
    """One of ROOMS, or what `load_scene` finds."""
    return ROOMS[name]() if name in ROOMS else load_scene(name)


def views_of(name: str, scene: Scene) -> Iterator[tuple[str, Camera]]:
    """The views of the scene called so, by name."""
    if name in ROOMS:
        return ((camera.name, camera) for camera in scene.cameras)
    return views(scene.cameras[0], float(np.linalg.norm(np.subtract(*scene.bounds))))


def views(camera: Camera, diagonal: float) -> Iterator[tuple[str, Camera]]:
    """The views of VIEWS by name; diagonal: of the scene [m]."""
    for name, (left, upwards, ahead) in VIEWS.items():
        angle, change = radians(upwards), np.eye(4)
        change[1, 1] = change[2, 2] = cos(angle)
        change[2, 1], change[1, 2] = sin(angle), -sin(angle)
        step = np.eye(4)
        step[2, 3] = -ahead * diagonal
        turned = rotated(replace(camera, to_world=camera.to_world @ step), left)
        yield name, replace(turned, to_world=turned.to_world @ change)


def pictures(device_scene: DeviceScene, camera: Camera, settings: RenderSettings) -> dict[str, Floats]:
    """What is measured and two means of paths, (height, width, 3) by name."""

    def rested(chosen: RenderSettings, frames: int) -> Floats:
        mean = Accumulation(SIZE[0] * SIZE[1], device_scene.device)
        return mean_at_rest(Renderer(device_scene, SIZE, chosen), camera, mean, frames)

    renderer = Renderer(device_scene, SIZE, settings)
    for number in range(1 - WALKED, 1):
        walk = renderer.render(rotated(camera, STEP_DEGREES * number), walks=True)
    found = {"walk": walk.radiance(), "single": renderer.render(camera).radiance(), "rest": rested(settings, RESTING)}
    for seed in SEEDS:
        paths = settings.model_copy(update={"method": Method.PATH, "samples": PATHS, "seed": seed})
        found[f"path {seed}"] = rested(paths, PATH_FRAMES)
    return found


def blotches(picture: Floats, reference: Doubles) -> tuple[float, float]:
    """How much darker and brighter than a reference a picture is where that is worst, relatively, both blurred."""
    deviation = 0.5 * BLOTCH * reference.shape[1]
    seen, right = (gaussian_filter(image.mean(axis=2), deviation, mode="nearest") for image in (picture, reference))
    change = (seen - right) / np.maximum(right, 0.05 * right.mean())
    return float(change.min()), float(change.max())


def specks(picture: Floats, reference: Doubles) -> tuple[int, int]:
    """How many pixels are darker, and brighter, than all of the reference around them by STANDS_OUT."""
    seen, right = picture.mean(axis=2), gaussian_filter(reference.mean(axis=2), 0.7)
    least, mean = minimum_filter(right, AROUND), right.mean()
    dark = (seen * STANDS_OUT < least) & (least > 0.05 * mean)
    bright = seen > STANDS_OUT * np.maximum(maximum_filter(right, AROUND), 0.05 * mean)
    return int(dark.sum()), int(bright.sum())


def measure_view(found: dict[str, Floats]) -> dict[str, Any]:
    """Errors of each picture beside the mean of both of paths, and that mean's noise as relMSE; tile: the most that the
    mean of one of 8×8 tiles differs by. No more than that it is `black`, where paths find no light.
    """
    one, other = (found.pop(f"path {seed}").astype(np.float64) for seed in SEEDS)
    reference = (one + other) / 2.0
    found["path"] = np.asarray(reference, np.float32)
    if not np.percentile(reference, 99) > 0.0:
        return {"black": True}
    row: dict[str, Any] = {"noise": measure(one, other).rel_mse / 4.0}
    for name in ("walk", "single", "rest"):
        row[name] = asdict(measure(found[name], reference)) | {
            "beyond_noise": error_beyond_noise(found[name], one, other),
            "tile": tile_change(reference, found[name]),
            "blotches": blotches(found[name], reference),
            "specks": specks(found[name], reference),
        }
    return row


def main(device: str, folder: Path, scenes: tuple[str, ...], settings: RenderSettings) -> None:
    """Print a line for each scene and view, and write its pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    for scene in scenes:
        device_scene = DeviceScene(scene_of(scene), device)
        for method in (settings.method, Method.PATH):
            load_kernels(device_scene, settings.model_copy(update={"method": method}))
        for view, camera in views_of(scene, device_scene.scene):
            found = pictures(device_scene, camera, settings)
            print(json.dumps({"scene": Path(scene).stem, "view": view, **measure_view(found)}), flush=True)
            white = max(float(np.percentile(found["path"], WHITE)), 1e-9)
            for name, picture in found.items():
                Image.fromarray(displayed(picture, white)).save(folder / f"{Path(scene).stem}-{view}-{name}.png")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), tuple(sys.argv[3:]) or SCENES, RenderSettings())
