"""A worker process whose pictures are gradients made at once, so that the service is tested without kernels.

Its scene ids and seeds are levers: it obeys what a test asks for by them.
"""

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import OutOfMemoryError, UserError
from gpu.scene.edits import LightEdit, ObjectEdit
from gpu.scene.parts import LightForm
from server.wire.browser import Bounds, CameraInfo, LightInfo, MaterialInfo, ObjectInfo, PickedPart, SceneInfo
from server.wire.worker import (
    HEARTBEAT,
    MAX_TEXT_BYTES,
    CameraMatrix,
    Export,
    Pick,
    Render,
    SceneCamera,
    SceneRef,
    Start,
)
from server.worker.tasks import Tasks
from server.worker.worker import Picture, Report, work

SLOW_SEED, WRONG_SEED, BUG_SEED, DEADLY_SEED, FAULT_SEED = 1001, 1002, 1003, 1004, 1005
HANG_SEED, HANG_LATER_SEED, BUG_LATER_SEED, FAULT_LATER_SEED = 1011, 1012, 1013, 1014
MEMORY_SEED, LONG_SEED, LATE_FAULT_SEED, SLICED_SEED, GATHER_SEED = 1015, 1016, 1017, 1018, 1019
SLOW_SECONDS = 0.25
LONG_SECONDS = 3.0
LATER = {HANG_LATER_SEED: HANG_SEED, BUG_LATER_SEED: BUG_SEED, FAULT_LATER_SEED: FAULT_SEED}
MEMORY = (1_000_000_000, 8_000_000_000)
SLICES, SLICE_SECONDS = 10_000, 0.005  # of what is SLICED, at most
ENOUGH = 3  # others' pictures between its slices, after which it ends
TARGET = 4  # frames that a still view is averaged of
CHAIR = Bounds(min=(-0.1, -0.1, -0.9), max=(0.1, 0.1, -0.7))
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


class GradientBackend:
    """Pictures whose blue is the viewer's number, whose green follows the x of the camera's position, and whose red is
    as bright as the scene's lamp.
    """

    lanes = 1

    def __init__(self) -> None:
        self._healthy = True
        self._later = 0  # a seed whose fault shows in the next heartbeat
        self._scenes: dict[SceneRef, None] = {}
        self._averaged: dict[int, int] = {}
        self._pictures = self._gathered = 0

    def start(self, start: Start, report: Report, tasks: Tasks) -> str:
        report("warming up", 0.5)
        if start.device == "none":
            raise UserError("no device 'none' here")
        if start.device and start.device.startswith("lanes "):
            self.lanes = int(start.device.removeprefix("lanes "))
        time.sleep(0.05)
        self._scenes[start.scene] = None
        return "gradient"

    def open(self, scene: SceneRef, report: Report, packed: str = "") -> SceneInfo:
        if scene.source.endswith("deadly.glb"):
            os.kill(os.getpid(), signal.SIGKILL)
        if scene.source.endswith("broken.glb"):
            raise UserError(f"{scene.id}: accessors[0]: is cut off")
        self._scenes[scene] = None
        camera = CameraInfo(name="front", matrix=IDENTITY, yfov=1.0, aspect=16 / 9, orthographic=False, near=0.0)
        bounds = Bounds(min=(-1.0, -1.0, -1.0), max=(1.0, 1.0, 1.0))
        options = scene.options
        name = MAX_TEXT_BYTES * "n" if scene.source.endswith("verbose.glb") else scene.id
        white = (1.0, 1.0, 1.0)
        return SceneInfo(
            id=scene.id,
            name=name,
            cameras=(camera,),
            bounds=bounds,
            options=options,
            lights=(LightInfo(id="lamp", form=LightForm.SURFACE, color=white),),
            materials=(MaterialInfo(id="wall", color=white, roughness=1.0, metallic=0.0, emission=(0.0, 0.0, 0.0)),),
            objects=(ObjectInfo(id="chair", box=CHAIR), ObjectInfo(id="room", box=bounds)),
            triangles=12,
        )

    def beside(self, scene: SceneRef) -> dict[str, int]:
        """All pictures in its folder."""
        return {file.name: file.stat().st_mtime_ns for file in Path(scene.source).parent.glob("*.png")}

    def close(self, scene: SceneRef) -> None:
        self._scenes.pop(scene, None)

    def scenes(self) -> tuple[SceneRef, ...]:
        return tuple(self._scenes)

    def render(self, job: Render, report: Report) -> Picture:
        self._scenes[job.scene] = None
        match self._later if job.viewer == HEARTBEAT and self._later else job.settings.seed:
            case seed if seed == SLOW_SEED:
                time.sleep(SLOW_SECONDS)
            case seed if seed == LONG_SEED:  # and says so
                for step in range(30):
                    time.sleep(LONG_SECONDS / 30)
                    report("long", step / 30)
            case seed if seed == SLICED_SEED:
                before = self._pictures
                for _ in range(SLICES):
                    if self._pictures - before >= ENOUGH:
                        break
                    time.sleep(SLICE_SECONDS)
                    DEVICE_SHARING.pause()
            case seed if seed == GATHER_SEED:  # they are over once there have been as many as lanes
                self._gathered += 1
                DEVICE_SHARING.leave_until(lambda: self._gathered >= self.lanes)
            case seed if seed == HANG_SEED:
                time.sleep(3600)
            case seed if seed == MEMORY_SEED:
                raise OutOfMemoryError("ask for less")
            case seed if seed in LATER:
                self._later = LATER[seed]
            case seed if seed == WRONG_SEED:
                raise UserError("settings.seed: is the wrong one")
            case seed if seed == BUG_SEED:
                raise RuntimeError("a bug")
            case seed if seed == FAULT_SEED:
                self._healthy = False
                raise RuntimeError("an illegal access")
            case seed if seed == LATE_FAULT_SEED:  # the device fails, and the first to notice is told otherwise
                self._healthy = False
                raise OutOfMemoryError("ask for less")
            case seed if seed == DEADLY_SEED:
                os.kill(os.getpid(), signal.SIGKILL)
        if job.view == SceneCamera("missing"):
            raise UserError("camera: there is no 'missing'")
        x = job.view.matrix[12] if isinstance(job.view, CameraMatrix) else 0.0
        width, height = job.size
        radiance = np.zeros((height, width, 3), np.float32)
        radiance[..., 0] = np.linspace(0.0, 1.0, width) * job.edits.lights.get("lamp", LightEdit()).factor
        radiance[..., 1] = np.clip(x, 0.0, 1.0)
        radiance[..., 2] = job.viewer / 255.0
        counts, skips, estimates = {"pixels": width * height}, {"specular": 1}, {"target_ms": 4.0}
        stats = ({"gbuffer": 0.5, "shade": 1.5, "extra": 2.0}, counts, skips, estimates)
        self._pictures += 1
        samples = 1
        if job.sample is not None:
            samples = self._averaged.get(job.viewer, 0) + 1 if job.sample else 1
            self._averaged[job.viewer] = samples
        pixels = None if job.output == "none" else (255 * radiance).astype(np.uint8)
        return Picture(samples, job.settings.frames or TARGET, None, 0.0, pixels, radiance, *stats)

    def pick(self, job: Pick, report: Report) -> PickedPart:
        """The chair on the left of a picture, where it is visible; the lamp, of no object, on the right."""
        if job.place[0] >= 0.75:
            return PickedPart(material="wall", light="lamp", point=(1.0, 0.0, -1.0), distance=1.0)
        chair = job.edits.objects.get("chair", ObjectEdit())
        return PickedPart() if chair.visible is False else PickedPart(object="chair", material="wall", distance=0.7)

    def export(self, job: Export, report: Report) -> bytes:
        return f"glTF with {', '.join(job.edits.lights) or 'no edits'}".encode()

    def leave(self, viewer: int) -> None:
        self._averaged.pop(viewer, None)

    def memory(self) -> tuple[int, int]:
        return MEMORY

    def healthy(self) -> bool:
        return self._healthy


if __name__ == "__main__":
    sys.exit(work(int(sys.argv[1]), lambda _: GradientBackend()))
