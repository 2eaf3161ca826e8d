"""Compilers in processes of their own, so that they work side by side and their memory goes with them.

Threads of one process that compile wait for each other: 108 kernels for an H100, 103 s of a core, take 16 threads 24 s
and 16 processes 13. Warp's own functions call its native compilers, which are replaced by calls in a process.
"""

import ctypes
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from pathlib import Path
from threading import Lock, Semaphore, Timer
from typing import Any

import warp as wp

from gpu.child_process import clean_environment

# Without work for so long they end: each has some hundred megabytes.
IDLE_SECONDS = 5.0
# Without an answer, after which a process hangs: a kernel takes a minute, and cores may be busy.
HANG_SECONDS = 600.0
# At once: of a picture's kernels the longest takes as long as all others of so many, which have 4 GB together.
MOST = 16
Process = subprocess.Popen[bytes]


class Compilers:
    """Processes that compile, as many as there are calls at once, but no more than MOST."""

    def __init__(self) -> None:
        self._lock, self._busy, self._room = Lock(), 0, Semaphore(MOST)
        self._idle: list[Process] = []

    def call(self, request: bytes) -> int:
        """What a native function returns that a pickled request names, by a process that waits or a new one.

        Raises RuntimeError where a new one ends without a word.
        """
        with self._lock:
            self._busy += 1
        try:
            with self._room:
                while waiting := self._take():
                    if answer := _answer(waiting, request):
                        return self._keep(waiting, answer)
                process = self.start()
                if answer := _answer(process, request):
                    return self._keep(process, answer)
                raise RuntimeError(f"the compiler's process ended with status {process.returncode}")
        finally:
            with self._lock:
                self._busy -= 1
                if self._busy == 0:
                    timer = Timer(IDLE_SECONDS, self.end)
                    timer.daemon = True
                    timer.start()

    def start(self) -> Process:
        """Another process."""
        script = Path(__file__).with_name("compiler_process.py")
        command = (sys.executable, "-I", "-S", str(script), str(os.getpid()))
        return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=clean_environment())

    def end(self) -> None:
        """End those that have nothing to do, unless there is work."""
        while not self._busy and (process := self._take()):
            with process:  # which closes its pipe, and waits
                pass

    def _take(self) -> Process | None:
        with self._lock:
            return self._idle.pop() if self._idle else None

    def _keep(self, process: Process, answer: bytes) -> int:
        with self._lock:
            self._idle.append(process)
        return int(answer)


COMPILERS = Compilers()


def _answer(process: Process, request: bytes) -> bytes:
    """What a process says; nothing where it has ended or hangs, or is ended by who interrupts this."""
    assert process.stdin is not None
    assert process.stdout is not None
    answer = b""
    hangs = Timer(HANG_SECONDS, process.kill)
    hangs.daemon = True
    hangs.start()
    try:
        process.stdin.write(request)
        process.stdin.flush()
        answer = process.stdout.readline()
    except BrokenPipeError:
        pass
    finally:
        hangs.cancel()
        if not answer:
            process.kill()
            process.wait()
            process.stdout.close()
            with suppress(BrokenPipeError):
                process.stdin.close()
    return answer


def _plain(argument: Any) -> Any:
    """An argument as it can be sent: arrays of texts, which end with a null, as tuples."""
    return tuple(text for text in argument if text is not None) if isinstance(argument, ctypes.Array) else argument


def _called_apart(library: ctypes.CDLL, name: str) -> Callable[..., int]:
    """A native function that is called in a process."""
    simple = {ctypes.c_char_p, ctypes.c_int, ctypes.c_bool, ctypes.c_size_t}
    types = [kind.__name__ if kind in simple else "c_void_p" for kind in getattr(library, name).argtypes]

    def call(*arguments: Any) -> int:
        return COMPILERS.call(pickle.dumps((library._name, name, types, tuple(map(_plain, arguments)))))

    return call


def _compiles_apart(build: Callable[..., None], library: str, name: str) -> Callable[..., None]:
    """A function of Warp's that compiles, by a native function that is called in a process."""

    @wraps(build)
    def built(*arguments: Any, **options: Any) -> None:
        native = getattr(wp._src.context.runtime, library)
        if hasattr(getattr(native, name), "argtypes"):
            setattr(native, name, _called_apart(native, name))
        build(*arguments, **options)

    return built


def compile_apart() -> None:
    """Have Warp compile so from now on. What compilers say is on stderr."""
    build = wp._src.build
    build.build_cuda = _compiles_apart(build.build_cuda, "core", "wp_cuda_compile_program")
    build.build_cpu = _compiles_apart(build.build_cpu, "llvm", "wp_compile_cpp")
