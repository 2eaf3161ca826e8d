"""The worker process's program, `python -m server.worker.program DESCRIPTOR`.

What renders takes seconds to be imported; the served scene is read meanwhile.
"""

import sys

from gpu.scene.builtin import MADE_AT_ONCE
from server.importing import kept_imports
from server.wire.worker import Start
from server.worker.scene_reading import SceneReading
from server.worker.worker import Backend, work


def backend_for(start: Start) -> Backend:
    """What renders on a GPU or a CPU, and begins with the served scene."""
    served = None if start.scene.source in MADE_AT_ONCE else SceneReading(start.scene, start)
    with kept_imports():
        from server.worker.backend import GpuBackend

    return GpuBackend(served)


if __name__ == "__main__":
    sys.exit(work(int(sys.argv[1]), backend_for))
