"""A worker process whose pictures are gradients made at once, so that the service is tested without kernels.

Its scene ids and seeds are levers: it obeys what a test asks for by them.
"""

import os
import signal
import sys
import time

import numpy as np

from gpu.errors import UserError
from server.messages import Placed, Render, SceneCamera, SceneRef, Start
from server.protocol import Bounds, CameraInfo, SceneInfo
from server.worker import Picture, Report, work

SLOW_SEED, WRONG_SEED, BUG_SEED, DEADLY_SEED, FAULT_SEED = 1001, 1002, 1003, 1004, 1005
SLOW_SECONDS = 0.25
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


class GradientBackend:
    """Pictures whose blue is the viewer's number and whose brightness follows the x of the camera's position."""

    def __init__(self) -> None:
        self._healthy = True

    def start(self, start: Start, report: Report) -> str:
        report("warming up", 0.5)
        if start.device == "none":
            raise UserError("no device 'none' here")
        time.sleep(0.05)
        return "gradient"

    def open(self, scene: SceneRef, report: Report) -> SceneInfo:
        if scene.source.endswith("deadly.glb"):
            os.kill(os.getpid(), signal.SIGKILL)
        if scene.source.endswith("deadly.glb"):
            os.kill(os.getpid(), signal.SIGKILL)
        if scene.source.endswith("broken.glb"):
            raise UserError(f"{scene.id}: accessors[0]: is cut off")
        camera = CameraInfo(name="front", matrix=IDENTITY, yfov=1.0, aspect=16 / 9, orthographic=False)
        bounds = Bounds(min=(-1.0, -1.0, -1.0), max=(1.0, 1.0, 1.0))
        return SceneInfo(id=scene.id, name=scene.id, cameras=(camera,), bounds=bounds, triangles=12)

    def render(self, job: Render, report: Report) -> Picture:
        match job.settings.seed:
            case seed if seed == SLOW_SEED:
                time.sleep(SLOW_SECONDS)
            case seed if seed == WRONG_SEED:
                raise UserError("settings.seed: is the wrong one")
            case seed if seed == BUG_SEED:
                raise RuntimeError("a bug")
            case seed if seed == FAULT_SEED:
                self._healthy = False
                raise RuntimeError("an illegal access")
            case seed if seed == DEADLY_SEED:
                os.kill(os.getpid(), signal.SIGKILL)
        if job.view == SceneCamera("missing"):
            raise UserError("camera: there is no 'missing'")
        x = job.view.matrix[12] if isinstance(job.view, Placed) else 0.0
        width, height = job.size
        radiance = np.zeros((height, width, 3), np.float32)
        radiance[..., 0] = np.linspace(0.0, 1.0, width)
        radiance[..., 1] = np.clip(x, 0.0, 1.0)
        radiance[..., 2] = job.viewer / 255.0
        stats = ({"gbuffer": 0.5, "shade": 1.5, "extra": 2.0}, {"pixels": width * height}, {"specular": 1})
        return Picture(1, 1, None, 0.0, (255 * radiance).astype(np.uint8), radiance, *stats)

    def leave(self, viewer: int) -> None:
        pass

    def healthy(self) -> bool:
        return self._healthy


if __name__ == "__main__":
    sys.exit(work(int(sys.argv[1]), GradientBackend()))
