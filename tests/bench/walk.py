"""Frames a second of a walk: the camera turns a little each frame, so that nothing can be kept from the last one.

python -m tests.bench.walk [--scene cornell-box] [--size 512x288] [--device cpu] [--frames 40] --out results.json
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.scene import load_scene
from gpu.scene.types import Camera
from gpu.settings import RenderSettings
from tests.bench.indirect import environment

WARM_UP = 3


def turned(camera: Camera, degrees: float) -> Camera:
    """`camera` turned about its own vertical axis."""
    angle = np.radians(degrees)
    turn = np.eye(4)
    turn[0, 0] = turn[2, 2] = np.cos(angle)
    turn[0, 2], turn[2, 0] = np.sin(angle), -np.sin(angle)
    return replace(camera, to_world=camera.to_world @ turn)


def main() -> None:
    """Walk, and write frames a second and the stages' medians as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="cornell-box")
    parser.add_argument("--size", default="512x288")
    parser.add_argument("--device", default=None)
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    resident = ResidentScene(load_scene(options.scene), options.device)
    renderer = Renderer(resident, (width, height), RenderSettings())
    seconds, stages, counts = [], [], {}
    for number in range(WARM_UP + options.frames):
        begun = perf_counter()
        frame = renderer.render(turned(resident.scene.cameras[0], 0.5 * number))
        frame.pixels()
        if number >= WARM_UP:
            seconds.append(perf_counter() - begun)
            stages.append(frame.stats.stage_ms)
            counts = frame.stats.counts
    result = {
        "environment": environment(resident.device),
        "scene": options.scene,
        "size": [width, height],
        "frames_a_second": 1.0 / float(np.median(seconds)),
        "stage_ms": {name: float(np.median([times[name] for times in stages])) for name in stages[0]},
        "counts": counts,
    }
    options.out.write_text(json.dumps(result, indent=1) + "\n")
    print(f"{options.scene} {width}×{height}: {result['frames_a_second']:.1f} frames a second", result["stage_ms"])


if __name__ == "__main__":
    main()
