"""Compilers of kernels in a process of their own, which ends when there is nothing more to compile.

A worker has one heap (server.render.worker_link): sixteen compilers in it would wait for each other, and what they
leave free in it would stay.
"""

from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from itertools import count
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from subprocess import DEVNULL, Popen
from threading import Lock, Thread
from time import monotonic
from typing import Any

import warp as wp

from gpu.child_process import clean_environment, module_command

IDLE_SECONDS = 30.0  # that it waits for more
# Without an answer to anything that was asked, after which it hangs: a kernel takes a minute, and may have to wait.
HANG_SECONDS = 600.0
# By Warp's names: one for CPUs, one for GPUs.
COMPILERS = ("build_cpu", "build_cuda")
# It compiles for GPUs, and needs none; and has a heap for each few threads, as glibc would have it.
OF_WORKERS = ("CUDA_VISIBLE_DEVICES", "MALLOC_ARENA_MAX")


class Compilers:
    """The process, started when something is to be compiled; of any number of threads."""

    def __init__(self, idle_seconds: float = IDLE_SECONDS) -> None:
        self._idle_seconds = idle_seconds
        self._lock, self._numbers = Lock(), count()
        self._connection: Connection[Any, Any] | None = None
        self._asked: dict[int, Future[None]] = {}

    def compile(self, compiler: str, *arguments: Any, **options: Any) -> None:
        """As Warp's function of this name, one of COMPILERS, in the process.

        Raises RuntimeError with what the compiler raised, and where the process ended.
        """
        with self._lock:
            if self._connection is None:
                self._connection = self._start()
            number, future = next(self._numbers), Future[None]()
            self._asked[number] = future
            with suppress(OSError):  # where it has just ended, which `_listen` says
                self._connection.send((number, compiler, arguments, options))
        future.result()

    def _start(self) -> "Connection[Any, Any]":
        ours, theirs = Pipe()
        environment = {name: value for name, value in clean_environment().items() if name not in OF_WORKERS}
        with theirs:
            process = Popen(
                (*module_command("server.worker.compiler_process"), str(theirs.fileno())),
                pass_fds=[theirs.fileno()],
                stdin=DEVNULL,
                stdout=2,
                env=environment | {"CUDA_VISIBLE_DEVICES": ""},
            )
        Thread(target=self._listen, args=(ours, process), name="compilers", daemon=True).start()
        return ours

    def _listen(self, connection: "Connection[Any, Any]", process: "Popen[bytes]") -> None:
        """Pass answers on until there have been none to wait for a while, or the process has ended: it is killed where
        it hangs.
        """
        lost: list[int] = []
        heard = monotonic()
        with connection:
            while True:
                try:
                    if connection.poll(self._idle_seconds):
                        self._answer(*connection.recv())
                        heard = monotonic()
                        continue
                except (EOFError, OSError):
                    with self._lock:
                        lost, self._connection = list(self._asked), None
                    break
                with self._lock:
                    if not self._asked:
                        self._connection = None
                        break
                if monotonic() - heard > HANG_SECONDS:
                    process.kill()
        status = process.wait()
        for number in lost:
            self._answer(number, f"the compilers' process ended with status {status}")

    def _answer(self, number: int, problem: str | None) -> None:
        future = self._asked.pop(number)
        if problem is None:
            future.set_result(None)
        else:
            future.set_exception(RuntimeError(problem))


def compile_apart() -> None:
    """Have Warp compile in a process of its own from now on."""
    compilers = Compilers()
    for name in COMPILERS:
        setattr(wp._src.build, name, partial(compilers.compile, name))
