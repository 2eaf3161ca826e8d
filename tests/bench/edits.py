"""What an edit of a scene costs: `python -m tests.bench.edits [DEVICE] [SCENE …]` prints a line of JSON a scene.

Medians [ms] of ROUNDS dimmings of a light, each a state that was never seen before: putting it on the device, its
table of lights, a renderer with VPLs and their clusters, and the first frame; beside a frame of a walk that nothing
changed for.
"""

import json
import sys
from statistics import median
from time import perf_counter
from typing import Any

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.edits import LightEdit, SceneEdits, edited
from gpu.scene.load import load_scene
from gpu.scene.parts import lights_of
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets

SCENES = ("cornell-box", "living-room", "conference-room")
SIZE, ROUNDS, WALK = (1024, 576), 9, 12


class Clock:
    """Splits of what a device has finished [ms]."""

    def __init__(self, device: wp.Device) -> None:
        self._device = device
        self.splits: dict[str, list[float]] = {}
        self.start()

    def start(self) -> None:
        wp.synchronize_device(self._device)
        self._at = perf_counter()

    def split(self, name: str) -> None:
        wp.synchronize_device(self._device)
        now = perf_counter()
        self.splits.setdefault(name, []).append(1e3 * (now - self._at))
        self._at = now


def measure(
    base: DeviceScene, settings: RenderSettings, size: tuple[int, int] = SIZE, rounds: int = ROUNDS
) -> dict[str, float]:
    """Medians of each part [ms]; the first round, which loads kernels, does not count."""
    clock, light = Clock(base.device), lights_of(base.scene)[0].id
    camera = base.scene.cameras[0]
    for number in range(rounds + 1):
        dimmed = SceneEdits(lights={light: LightEdit(intensity=0.5 + number / 100.0)})
        clock.start()
        state = base.edited(edited(base.scene, dimmed))
        clock.split("state")
        lights = LightSets(state)
        clock.split("table")
        renderer = Renderer(state, size, settings, light_sets=lights)
        view = renderer.new_view()
        clock.split("renderer")
        renderer.render(camera, view=view, walks=True)
        clock.split("frame")
    for step in range(WALK):
        turned = rotated(camera, 0.1 * (step + 1))
        clock.start()
        renderer.render(turned, view=view, walks=True)
        clock.split("walking")
    parts = {name: median(times[1:]) for name, times in clock.splits.items()}
    return {**parts, "edit": sum(parts[name] for name in ("state", "table", "renderer", "frame"))}


def main(arguments: list[str]) -> None:
    device, scenes = (arguments or ["cuda:0"])[0], arguments[1:] or SCENES
    for name in scenes:
        found = measure(DeviceScene(load_scene(name), device), RenderSettings())
        line: dict[str, Any] = {"scene": name, **{part: round(ms, 2) for part, ms in found.items()}}
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
