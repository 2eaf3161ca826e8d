"""The real renderer, which breaks when a render has one of these seeds: as a driver or a kernel with a bug would.

It is the worker of `make_engines(settings, FAULT_WORKER)`.
"""

import os
import signal
import sys
import time
from pathlib import Path

import warp as wp

from server.wire.worker import Render
from server.worker.backend import GpuBackend
from server.worker.worker import Picture, Report, work

FAULT_WORKER = (sys.executable, str(Path(__file__).resolve()))
ILLEGAL_SEED = 2**31 - 1  # a CUDA kernel writes where nothing is; a CPU has SIGSEGV instead
HANG_SEED = 2**31 - 2  # a CUDA kernel never ends; on a CPU, its caller never does
NOWHERE = 64  # an address


@wp.kernel
def write_kernel(target: wp.array[int]) -> None:
    target[wp.tid()] = 1


@wp.kernel
def spin_kernel(flag: wp.array[int]) -> None:
    while wp.atomic_add(flag, 0, 0) == 0:
        pass


class FaultBackend(GpuBackend):
    """Breaks when it is told to, before it renders: the render is then the first to notice."""

    def render(self, job: Render, report: Report) -> Picture:
        if job.settings.seed == ILLEGAL_SEED:
            if self._device.is_cuda:
                nowhere = wp.array(ptr=NOWHERE, shape=(1,), dtype=int, device=self._device)
                wp.launch(write_kernel, dim=1, inputs=[nowhere], device=self._device)
            else:
                os.kill(os.getpid(), signal.SIGSEGV)
        if job.settings.seed == HANG_SEED:
            if self._device.is_cuda:
                wp.launch(spin_kernel, dim=1, inputs=[wp.zeros(1, dtype=int, device=self._device)], device=self._device)
            else:
                time.sleep(3600)
        return super().render(job, report)


if __name__ == "__main__":
    sys.exit(work(int(sys.argv[1]), lambda _: FaultBackend()))
