"""The worker process's program, `python -m server.backend DESCRIPTOR`: the only part of the service that imports Warp.

Scenes are shared by all viewers of them; each viewer has one renderer, of its size and settings, made anew when those
change. A scene that nobody looks at is dropped for another once `max_scenes` are loaded, the least recently used first.
"""

import sys
from dataclasses import dataclass, replace
from math import tan

import numpy as np
import warp as wp

from gpu.camera import look_at
from gpu.device import choose_device
from gpu.errors import SceneError, UserError
from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.scene import load_scene
from gpu.scene.types import Camera, Scene
from gpu.settings import RenderSettings
from server.messages import STILLS, LookAt, Placed, Render, SceneCamera, SceneRef, Start, View
from server.protocol import SceneInfo
from server.sceneinfo import describe_scene
from server.worker import Picture, Report, work

FIRST_SIZE = (64, 36)


@dataclass(frozen=True)
class _Loaded:
    scene: Scene
    resident: ResidentScene


@dataclass(frozen=True)
class _Seat:
    """A viewer's renderer and what it was made for."""

    scene: SceneRef
    size: tuple[int, int]
    settings: RenderSettings
    renderer: Renderer


class GpuBackend:
    """Renders with gpu/ on one device."""

    def __init__(self) -> None:
        self._start = Start(SceneRef("", ""))
        self._device: wp.Device = None
        self._scenes: dict[SceneRef, _Loaded] = {}  # in the order of their last use
        self._seats: dict[int, _Seat] = {}

    def start(self, start: Start, report: Report) -> str:
        """Choose a device, load the served scene, render one frame of it; return the device's name."""
        self._start = start
        self._device = choose_device(start.device)
        self.render(Render(STILLS, start.scene, SceneCamera(0), FIRST_SIZE, RenderSettings(), "none"), report)
        self.leave(STILLS)
        return str(self._device)

    def open(self, scene: SceneRef, report: Report) -> SceneInfo:
        """Make sure that a scene is on the device."""
        return describe_scene(scene.id, self._load(scene, report).scene)

    def render(self, job: Render, report: Report) -> Picture:
        """Render one picture with the viewer's renderer."""
        loaded = self._load(job.scene, report)
        camera = view_camera(loaded.scene, job.view, job.size)
        seat = self._seats.get(job.viewer)
        if seat is None or (seat.scene, seat.size, seat.settings) != (job.scene, job.size, job.settings):
            seat = None
            self.leave(job.viewer)  # before the new renderer takes memory
            renderer = Renderer(loaded.resident, job.size, job.settings, report)
            seat = self._seats[job.viewer] = _Seat(job.scene, job.size, job.settings, renderer)
        try:
            frame = seat.renderer.render(camera)
        except BaseException:
            self.leave(job.viewer)  # what it holds after an error is not known
            raise
        linear = job.output in (".exr", ".npy")
        pixels, radiance = (None, frame.radiance()) if linear else (frame.pixels(), None)
        stats = frame.stats
        return Picture(1, 1, None, 0.0, pixels, radiance, stats.stage_ms, stats.counts, stats.skips)

    def leave(self, viewer: int) -> None:
        """Free a viewer's renderer."""
        self._seats.pop(viewer, None)

    def healthy(self) -> bool:
        """Whether the device still answers."""
        try:
            wp.synchronize_device(self._device)
        except Exception:
            return False
        return True

    def _load(self, ref: SceneRef, report: Report) -> _Loaded:
        loaded = self._scenes.pop(ref, None)
        if loaded is None:
            self._make_room()
            report(f"reading {ref.id}", 0.0)
            try:
                scene = load_scene(ref.source, self._start.scene_limits)
            except SceneError as error:  # viewers know ids, not this machine's paths
                raise SceneError(ref.id, error.field, error.problem) from None
            report(f"building {ref.id}", 0.5)
            loaded = _Loaded(scene, ResidentScene(scene, str(self._device)))
        self._scenes[ref] = loaded
        return loaded

    def _make_room(self) -> None:
        while len(self._scenes) >= self._start.max_scenes:
            used = {seat.scene for viewer, seat in self._seats.items() if viewer != STILLS}
            idle = next((ref for ref in self._scenes if ref not in used), None)
            if idle is None:
                raise UserError(
                    f"{len(used)} scenes are being viewed, as many as this server keeps; choose one of those"
                )
            if STILLS in self._seats and self._seats[STILLS].scene == idle:
                self.leave(STILLS)
            del self._scenes[idle]


def view_camera(scene: Scene, view: View, size: tuple[int, int]) -> Camera:
    """The camera that a view means, for pictures of `size`; UserError when the scene has no such camera."""
    aspect = size[0] / size[1]
    match view:
        case LookAt(position, target, up, yfov_degrees):
            return look_at(position, target, up, yfov_degrees, aspect)
        case Placed(matrix, yfov):
            return Camera("", np.array(matrix).reshape(4, 4).T, tan(yfov / 2.0), aspect)
        case SceneCamera(int(index)) if 0 <= index < len(scene.cameras):
            return replace(scene.cameras[index], aspect=aspect)
        case SceneCamera(str(name)):
            for camera in scene.cameras:
                if camera.name == name:
                    return replace(camera, aspect=aspect)
    names = ", ".join(f"{index} ({camera.name})" for index, camera in enumerate(scene.cameras))
    raise UserError(f"camera: {scene.name} has no camera {view.camera!r}; it has {names}")


if __name__ == "__main__":
    sys.exit(work(int(sys.argv[1]), GpuBackend()))
