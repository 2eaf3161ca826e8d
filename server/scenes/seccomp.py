"""Seccomp: a filter of system calls that lets a process read and compute, and neither talk, start others nor trace.

The filter is a program in classic BPF (Linux, Documentation/userspace-api/seccomp_filter.rst). What it refuses fails
with EPERM, so that a library that tries in vain goes on.
"""

import ctypes
import os
from errno import ENOSYS, EPERM

from server.scenes.kernel import PR_SET_NO_NEW_PRIVS, machine, process_control, system_call

_SET_MODE_FILTER, _GET_ACTION_AVAIL, _ALL_THREADS = 1, 2, 1
_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_NUMBER, _MACHINE, _FIRST_ARGUMENT = 0, 4, 16  # places in what the filter is given [bytes]
_ALLOW, _ERROR = 0x7FFF0000, 0x00050000
_OTHER_ABI = 0x40000000  # numbers of x86-64's x32 begin there
_THREAD, _NEW_NAMESPACES = 0x00010000, 0x7E020000  # flags of clone
_MACHINES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_SECCOMP = {"x86_64": 317, "aarch64": 277}
# Numbers by kind of machine; those from 424 on are the same everywhere.
_TALK = {
    "x86_64": (41, 53, 42, 49, 50, 43, 288),  # socket, socketpair, connect, bind, listen, accept, accept4
    "aarch64": (198, 199, 203, 200, 201, 202, 242),
}
_SHARED = {
    "x86_64": (29, 30, 31, 64, 65, 66, 68, 69, 70, 71, 240),  # System V memory, semaphores and messages, mq_open
    "aarch64": (194, 195, 196, 190, 191, 193, 186, 187, 188, 189, 180),
}
_POWER = {
    # ptrace, process_vm_*, tkill, rt_(tg)sigqueueinfo, unshare, setns, mount, umount2, pivot_root, chroot, bpf,
    # perf_event_open, userfaultfd, keys (3), kexec (2), modules (3), file handles (2), personality, kcmp, reboot,
    # swapon, acct
    "x86_64": (
        *(101, 310, 311, 200, 129, 297, 272, 308, 165, 166, 155, 161, 321, 298, 323, 248, 249, 250, 246, 320),
        *(175, 313, 176, 303, 304, 135, 312, 169, 167, 163),
    ),
    "aarch64": (
        *(117, 270, 271, 130, 138, 240, 97, 268, 40, 39, 41, 51, 280, 241, 282, 217, 218, 219, 104, 294),
        *(105, 273, 106, 264, 265, 92, 272, 142, 224, 89),
    ),
}
# pidfds, io_uring, mounts by file descriptor, process_madvise, mount_setattr
_POWER_EVERYWHERE = (424, 425, 426, 427, 428, 429, 430, 431, 432, 433, 434, 438, 440, 442)
_RUN = {"x86_64": (59, 322, 57, 58), "aarch64": (221, 281)}  # execve, execveat; fork, vfork
_CLONE, _CLONE3 = {"x86_64": 56, "aarch64": 220}, 435
_KILL = {"x86_64": (62, 234), "aarch64": (129, 131)}  # kill, tgkill
_PRLIMIT = {"x86_64": 302, "aarch64": 261}

Instruction = tuple[int, int, int, int]  # code, jump if true, jump if false, value


class _Instruction(ctypes.Structure):
    _fields_ = (("code", ctypes.c_uint16), ("yes", ctypes.c_uint8), ("no", ctypes.c_uint8), ("value", ctypes.c_uint32))


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_uint16), ("filter", ctypes.POINTER(_Instruction)))


def available() -> bool:
    """Whether this kernel has it and the machine is of a kind that is known here."""
    if machine() not in _MACHINES:
        return False
    try:
        system_call(_SECCOMP[machine()], _GET_ACTION_AVAIL, 0, ctypes.byref(ctypes.c_uint32(_ERROR)))
    except OSError:
        return False
    return True


def restrict(*, starts_processes: bool) -> bool:
    """From now on this process has no sockets, traces and signals no other, mounts nothing, and starts threads only.

    starts_processes: it may start others, which this holds for too. False where that cannot be: nothing has changed.
    """
    if machine() not in _MACHINES:
        return False
    lines = program(machine(), os.getpid(), starts_processes=starts_processes)
    filled = (_Instruction * len(lines))(*(_Instruction(*line) for line in lines))
    try:
        process_control(PR_SET_NO_NEW_PRIVS, 1)
        system_call(_SECCOMP[machine()], _SET_MODE_FILTER, _ALL_THREADS, ctypes.byref(_Program(len(lines), filled)))
    except OSError:
        return False
    return True


def program(kind: str, process: int, *, starts_processes: bool) -> list[Instruction]:
    """The filter for a kind of machine and the process of that number."""
    refused = [*_TALK[kind], *_SHARED[kind], *_POWER[kind], *_POWER_EVERYWHERE]
    refused += () if starts_processes else _RUN[kind]
    wrong_clone = (_ANY_BIT, 0, 1, _NEW_NAMESPACES) if starts_processes else (_ANY_BIT, 1, 0, _THREAD)
    lines: list[Instruction] = [
        (_LOAD, 0, 0, _MACHINE),
        (_EQUAL, 1, 0, _MACHINES[kind]),
        _failed(EPERM),
        (_LOAD, 0, 0, _NUMBER),
        (_AT_LEAST, 0, 1, _OTHER_ABI),
        _failed(EPERM),
    ]
    for number in refused:
        lines += [(_EQUAL, 0, 1, number), _failed(EPERM)]
    # Its flags are in memory, where a filter cannot look; threads are then made by clone.
    lines += [(_EQUAL, 0, 1, _CLONE3), _failed(ENOSYS)]
    lines += _unless(_CLONE[kind], wrong_clone)
    for number in _KILL[kind]:
        lines += _unless(number, (_EQUAL, 1, 0, process))
    lines += _unless(_PRLIMIT[kind], (_EQUAL, 1, 0, 0))
    return [*lines, (_RETURN, 0, 0, _ALLOW)]


def _unless(number: int, test: Instruction) -> list[Instruction]:
    """Refuse the call of that number when `test` of its first argument goes on instead of over the next line."""
    return [
        (_EQUAL, 0, 4, number),
        (_LOAD, 0, 0, _FIRST_ARGUMENT),
        test,
        _failed(EPERM),
        (_LOAD, 0, 0, _NUMBER),
    ]


def _failed(error: int) -> Instruction:
    return (_RETURN, 0, 0, _ERROR | error)
