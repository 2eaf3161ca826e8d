"""Times of the single kernels of a frame: `python -m tests.bench.kernels DEVICE METHOD SCENE [WIDTHxHEIGHT]`.

Medians [ms] of the frames of a walk, those of one name together, dearest first, and how often each is launched. Events
about each launch keep kernels from overlapping and being captured, so all together take longer than a frame.
"""

import json
import sys
from collections import Counter, defaultdict
from statistics import median

import warp as wp

from gpu.core.stages import Stages
from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.load import load_scene
from gpu.settings import Method, RenderSettings
from gpu.warm_up import warm_up

SIZE, FIRST, FRAMES, DEGREES = "1024x576", 3, 7, 0.5
Times = dict[str, tuple[float, int]]


def in_sum(launched: list[tuple[str, float]]) -> Times:
    """Milliseconds and launches by kernel, of names and milliseconds of each launch in a frame."""
    sums, launches = defaultdict[str, float](float), Counter[str]()
    for name, elapsed in launched:
        sums[name] += elapsed
        launches[name] += 1
    return {name: (sums[name], launches[name]) for name in sums}


def typical(frames: list[Times]) -> Times:
    """Medians over frames, dearest first; a kernel that a frame has not took nothing there."""
    names = {name for frame in frames for name in frame}
    found = {
        name: (
            median(frame.get(name, (0.0, 0))[0] for frame in frames),
            max(frame.get(name, (0.0, 0))[1] for frame in frames),
        )
        for name in names
    }
    return dict(sorted(found.items(), key=lambda item: -item[1][0]))


def _flush(stages: Stages) -> None:
    """In place of Stages.flush: kernels in a graph have no times of their own."""
    parts, stages._parts = stages._parts, []
    for part in parts:
        stages._note(part.key)
    stages._launch(parts)


def measure(device_scene: DeviceScene, settings: RenderSettings, size: tuple[int, int]) -> Times:
    """Of a walk's frames; the first, which have no others before them, do not count."""
    renderer, camera = Renderer(device_scene, size, settings), device_scene.scene.cameras[0]
    view, frames = renderer.new_view(), []
    for number in range(FIRST + FRAMES):
        wp.timing_begin(cuda_filter=wp.TIMING_KERNEL | wp.TIMING_KERNEL_BUILTIN)
        renderer.render(rotated(camera, DEGREES * number), view=view, walks=True)
        frames.append(in_sum([(each.name, each.elapsed) for each in wp.timing_end()]))
    return typical(frames[FIRST:])


def main(arguments: list[str]) -> None:
    device, method, scene, size, *_ = *arguments, SIZE
    width, height = (int(side) for side in size.split("x"))
    device_scene, settings = DeviceScene(load_scene(scene), device), RenderSettings(method=Method(method))
    warm_up(device_scene, settings)
    Stages.flush = _flush  # type: ignore[method-assign]
    for name, (elapsed, launches) in measure(device_scene, settings, (width, height)).items():
        print(json.dumps({"kernel": name, "ms": round(elapsed, 3), "launches": launches}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
