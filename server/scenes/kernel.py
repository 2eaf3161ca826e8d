"""Calls to the Linux kernel that Python has no functions for."""

import ctypes
import os
import platform
import sys

PR_SET_PDEATHSIG, PR_SET_NO_NEW_PRIVS = 1, 38
_libc = ctypes.CDLL(None, use_errno=True)


def machine() -> str:
    """The processor's name as the kernel has it, "" where this process is not one of 64 bits on Linux."""
    return platform.machine() if sys.platform == "linux" and sys.maxsize > 2**32 else ""


def system_call(number: int, *arguments: object) -> int:
    """Call the kernel by number, with integers and pointers. Raises OSError when it refuses."""
    given = [ctypes.c_long(it) if isinstance(it, int) else it for it in arguments]
    return _checked(_libc.syscall(ctypes.c_long(number), *given))


def process_control(option: int, value: int) -> None:
    """Set an attribute of this process (prctl). Raises OSError when the kernel refuses."""
    _checked(_libc.prctl(option, *(ctypes.c_ulong(it) for it in (value, 0, 0, 0))))


def _checked(result: int) -> int:
    if result < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result
