"""Kernels compiled and loaded side by side, before the frames that launch them; else each waits for the one before."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import cpu_count

import warp as wp

WORKERS = cpu_count() or 1

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


def load_imported(device: wp.Device, block: int) -> None:
    """Compile, or take from Warp's cache, every kernel that has been imported, for blocks of so many threads."""
    wp.force_load(device, block_dim=block, max_workers=WORKERS)


def load_kernels(kernels: Iterable[wp.Kernel], device: wp.Device, block: int) -> None:
    """As `load_imported`, of these kernels."""
    modules = list(dict.fromkeys(kernel.module for kernel in kernels))
    if modules:
        wp.force_load(device, modules, block_dim=block, max_workers=WORKERS)
