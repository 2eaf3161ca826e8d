"""Kernels compiled and loaded side by side, before the frames that launch them; else each waits for the one before."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import cpu_count

import warp as wp

WORKERS = cpu_count() or 1
PACKAGE = __name__.partition(".")[0]

_noted: set[wp.Kernel] | None = None


@contextmanager
def noted_kernels() -> Iterator[set[wp.Kernel]]:
    """The kernels that are launched within by gpu.core.device, which runs none of them meanwhile.

    Arrays stay as they are, so what is made of them is nothing to be shown. Not for two threads at a time.
    """
    global _noted
    _noted = kernels = set[wp.Kernel]()
    try:
        yield kernels
    finally:
        _noted = None


def is_noted(kernel: wp.Kernel) -> bool:
    """Whether launches are noted, not run, now: then this one was."""
    if _noted is None:
        return False
    _noted.add(kernel)
    return True


def imported_kernels(package: str = PACKAGE) -> list[wp.Kernel]:
    """Those at the top of the modules of a package that have been imported."""
    modules = [module for name, module in sys.modules.items() if name.startswith(f"{package}.")]
    return [value for module in modules for value in vars(module).values() if isinstance(value, wp.Kernel)]


def load_kernels(kernels: Iterable[wp.Kernel], device: wp.Device, block: int) -> None:
    """Compile these kernels, or take them from Warp's cache, for blocks of so many threads."""
    modules = list(dict.fromkeys(kernel.module for kernel in kernels))
    if modules:
        wp.force_load(device, modules, block_dim=block, max_workers=WORKERS)
