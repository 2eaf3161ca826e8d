"""What a process that reads a scene may still do: read that scene and Python's own files, and compute.

Three walls of the kernel, each where it has it: Landlock for files, seccomp for calls, and the end with its parent.
"""

import os
import sys
import sysconfig
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from signal import SIGKILL

import gpu
import server
from server.scenes import landlock, seccomp
from server.scenes.kernel import PR_SET_PDEATHSIG, process_control

# Where systems keep libraries and programs, and what libraries ask of the machine.
_SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/nix/store", "/gnu/store", "/etc/ld.so.cache", "/etc/localtime")
_MACHINE = ("/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/sys/devices/system/cpu", "/dev/urandom", "/dev/zero")
_MACHINE_ALSO = ("/dev/null", "/sys/devices/system/node", "/proc/sys/vm/overcommit_memory", "/sys/kernel/mm")


def end_with_parent(parent: int) -> None:
    """The kernel kills this process when the one that started it, `parent`, ends; it may have ended already."""
    with suppress(OSError):
        process_control(PR_SET_PDEATHSIG, SIGKILL)
    if os.getppid() != parent:
        sys.exit()


def open_only(readable: Iterable[Path], writable: Iterable[Path] = ()) -> bool:
    """From now on only these files and folders and Python's own can be opened, and written only in those said.

    False where the kernel has no Landlock.
    """
    return landlock.restrict([*_own(), *((path, landlock.READ) for path in readable)], writable)


def start_nothing(*, except_processes: bool = False) -> bool:
    """From now on there are no sockets, other processes or mounts; with `except_processes` others can be started.

    False where the kernel has no seccomp.
    """
    return seccomp.restrict(starts_processes=except_processes)


def missing() -> list[str]:
    """The walls that this kernel has not."""
    has = {"Landlock": landlock.version() > 0, "seccomp": seccomp.available()}
    return [name for name, it in has.items() if not it]


def _has_packages(path: Path) -> bool:
    """Whether this part of Python's path is where packages were installed, not a project's folder, which has more."""
    named = path.name in ("site-packages", "dist-packages") or path.suffix == ".zip"
    return named or any(path.glob("*.dist-info"))


def _own() -> list[tuple[Path, int]]:
    """Python, its packages, this project, and the system's libraries; of other folders on the way only the names."""
    listed = [Path(it) for it in sys.path if it and Path(it).is_dir()]
    prefixes = {sys.prefix, sys.base_prefix, sys.exec_prefix, *sysconfig.get_paths().values()}
    packages = [path for path in listed if _has_packages(path)]
    libraries = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    parts = [Path(module.__path__[0]) for module in (gpu, server)]
    run = [*map(Path, (*_SYSTEM, *prefixes, *filter(None, libraries))), *packages, *parts]
    read = map(Path, (*_MACHINE, *_MACHINE_ALSO))
    return [
        *((path, landlock.RUN) for path in run),
        *((path, landlock.READ) for path in read),
        *((path, landlock.LIST) for path in listed),
    ]
