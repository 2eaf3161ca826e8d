"""Guards around every array on the CPU, which tell what is written beside one."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
import warp as wp

GUARD_BYTES = 1 << 14
UNTOUCHED = 0xA5


class GuardedAllocator:
    """Warp's own `inner`, with guards around each array; broken: sizes of those whose guards were written [bytes]."""

    deallocate_requires_context_guard = False

    def __init__(self, inner: Any) -> None:
        self._inner, self.memory_kind = inner, inner.memory_kind
        self._sizes: dict[int, int] = {}  # by address
        self.broken: list[int] = []

    def allocate(self, size: int) -> int:
        begin = int(self._inner.allocate(size + 2 * GUARD_BYTES)) + GUARD_BYTES
        for guard in (begin - GUARD_BYTES, begin + size):
            ctypes.memset(guard, UNTOUCHED, GUARD_BYTES)
        self._sizes[begin] = size
        return begin

    def deallocate(self, begin: int, size: int) -> None:
        self._look(begin)
        del self._sizes[begin]
        self._inner.deallocate(begin - GUARD_BYTES, size + 2 * GUARD_BYTES)

    def look(self) -> None:
        """At the guards of all arrays that there are."""
        for begin in self._sizes:
            self._look(begin)

    def _look(self, begin: int) -> None:
        for guard in (begin - GUARD_BYTES, begin + self._sizes[begin]):
            if (np.ctypeslib.as_array((ctypes.c_ubyte * GUARD_BYTES).from_address(guard)) != UNTOUCHED).any():
                self.broken.append(self._sizes[begin])


@contextmanager
def guarded(cpu: str) -> Iterator[GuardedAllocator]:
    """Arrays that are made within have guards, which are looked at as they are freed and in the end."""
    device = wp.get_device(cpu)
    allocator = GuardedAllocator(device.default_allocator)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(device, "default_allocator", allocator)
        yield allocator
    allocator.look()
