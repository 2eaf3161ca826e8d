"""What less of small pictures costs and gains: `python -m tests.bench.sparse [DEVICE] [SCENE …]`, a line of JSON each.

Every pixel shaded or one of four, with the usual choices and with cheaper ones: frames a second of all the viewers of
tests.bench.overlap in as many lanes as a GPU has frames at once, and errors of the last frame of a walk that one viewer
has alone, beside the mean of many there.
"""

import json
import sys
from dataclasses import asdict, replace
from typing import Any

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.film.metrics import measure
from gpu.gbuffer import sparse_shading
from gpu.renderer import Renderer
from gpu.scene.load import load_scene
from gpu.scene.types import Floats
from gpu.settings import Quality, RenderSettings, Skips
from gpu.vpl.light_sets import LightSets
from tests.bench.overlap import FRAMES, LANES, VIEWERS, WARM_UP, Crowd, Place
from tests.bench.still import mean_at_rest

SCENES = ("living-room",)
SIZES = ((320, 180), (480, 270))
CHOICES: dict[str, dict[str, Any]] = {
    "balanced": {},
    "balanced, 1 sample": {"samples": 1},
    "draft": {"quality": Quality.DRAFT},
    "draft, 1 sample": {"quality": Quality.DRAFT, "samples": 1},
}
SHADED = {"every pixel": Skips(interpolated=False), "one of four": Skips()}
WALKED, RESTING = 10, 300  # frames of a walk, and of the mean that its last one is compared with
COMPARED = (0, 5)  # viewers


def walked(place: Place, viewer: int) -> Floats:
    """The last frame of a viewer's walk."""
    renderer = Renderer(place.device_scene, place.size, place.settings, None, place.light_sets)
    for number in range(WALKED):
        frame = renderer.render(place.camera(viewer, number), walks=True)
    return frame.radiance()


def rested(place: Place, viewer: int) -> Floats:
    """The mean of many frames where that walk ends."""
    renderer = Renderer(place.device_scene, place.size, place.settings, None, place.light_sets)
    mean = Accumulation(place.size[0] * place.size[1], place.device_scene.device)
    return mean_at_rest(renderer, place.camera(viewer, WALKED - 1), mean, RESTING)


def measure_choice(place: Place, references: dict[int, Floats]) -> dict[str, Any]:
    """Frames a second and the host's part of them; errors beside `references`, of viewers by their numbers."""
    errors = [asdict(measure(walked(place, viewer), reference)) for viewer, reference in references.items()]
    crowd = Crowd(place, range(VIEWERS), LANES[-1])
    crowd.run(WARM_UP)
    seconds, frames = crowd.run(FRAMES), FRAMES * VIEWERS
    return {
        "frames_a_second": round(frames / seconds, 1),
        "host_ms": round(1e3 * crowd.host_seconds / frames, 3),
        "errors": errors,
    }


def main(device: str, scenes: tuple[str, ...], settings: RenderSettings) -> None:
    """Print a line for each scene, size and choice. From here on pictures of any size may have one of four shaded."""
    sparse_shading.ANCHOR_PARAMETERS = replace(sparse_shading.ANCHOR_PARAMETERS, min_pixels=0)
    for scene in scenes:
        device_scene = DeviceScene(load_scene(scene), device)
        light_sets = LightSets(device_scene)
        for size in SIZES:
            usual = Place(device_scene, light_sets, size, settings)
            references = {viewer: rested(usual, viewer) for viewer in COMPARED}
            for choice, changes in CHOICES.items():
                for shaded, skip in SHADED.items():
                    chosen = settings.model_copy(update={**changes, "skip": skip})
                    row = measure_choice(replace(usual, settings=chosen), references)
                    row = {"scene": scene, "size": list(size), "choice": choice, "shaded": shaded, **row}
                    print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "cuda:0", tuple(sys.argv[2:]) or SCENES, RenderSettings())
