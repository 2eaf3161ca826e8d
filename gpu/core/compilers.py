"""Compilers for GPUs in processes of their own, so that they work side by side.

Threads of one process that compile wait for each other: 108 kernels, 103 s of a core, take 16 threads 24 s and 16
processes 13.
"""

import json
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from threading import Lock, Timer
from typing import Any

import warp as wp

# Without work for so long they end: each has some hundred megabytes.
IDLE_SECONDS = 5.0

_build_cuda = wp._src.build.build_cuda


class Compilers:
    """Processes that compile, as many as there are jobs at once."""

    def __init__(self) -> None:
        self._lock, self._busy = Lock(), 0
        self._idle: list[subprocess.Popen[str]] = []

    def outcome(self, job: str) -> int:
        """Warp's error number of a job, by a process that has none or a new one.

        Raises RuntimeError where that ends without a word.
        """
        with self._lock:
            self._busy += 1
        try:
            while waiting := self._take():
                if answer := _answer(waiting, job):
                    return self._keep(waiting, answer)
            process = self.start()
            if answer := _answer(process, job):
                return self._keep(process, answer)
            raise RuntimeError(f"the compiler ended with status {process.returncode}")
        finally:
            with self._lock:
                self._busy -= 1
                if self._busy == 0:
                    timer = Timer(IDLE_SECONDS, self.end)
                    timer.daemon = True
                    timer.start()

    def start(self) -> subprocess.Popen[str]:
        """Another process."""
        library, headers = wp._src.context.runtime.core._name, Path(wp.__file__).parent / "native"
        script = Path(__file__).with_name("compiler_process.py")
        command = (sys.executable, "-I", "-S", str(script), library, str(headers))
        return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def end(self) -> None:
        """End those that have nothing to do, unless there is work."""
        while not self._busy and (process := self._take()):
            with process:  # which closes its pipe, and waits
                pass

    def _take(self) -> subprocess.Popen[str] | None:
        with self._lock:
            return self._idle.pop() if self._idle else None

    def _keep(self, process: subprocess.Popen[str], answer: str) -> int:
        with self._lock:
            self._idle.append(process)
        return int(answer)


COMPILERS = Compilers()


def _answer(process: subprocess.Popen[str], job: str) -> str:
    """What a process says of a job; nothing where it has ended, or is ended by who interrupts this."""
    assert process.stdin is not None
    assert process.stdout is not None
    answer = ""
    try:
        process.stdin.write(job)
        process.stdin.flush()
        answer = process.stdout.readline()
    except BrokenPipeError:
        pass
    finally:
        if not answer:
            process.kill()
            process.wait()
            process.stdout.close()
            with suppress(BrokenPipeError):
                process.stdin.close()
    return answer


def build_apart(cu_path: str, arch: int, output_path: str, *, pch_dir: str | None, **options: Any) -> None:
    """As Warp's `build_cuda`, by a process. Raises RuntimeError where the compiler fails, which says why on stderr."""
    linked = options.get("ltoirs") or options.get("fatbins") or options.get("extra_include_dirs")
    if linked or options.get("llvm_cuda") or options.get("compile_time_trace") or pch_dir:
        _build_cuda(cu_path, arch, output_path, pch_dir=pch_dir, **options)
        return
    job = {
        "source": cu_path,
        "architecture": arch,
        "suffix": options["arch_suffix"],
        "debug": options["config"] == "debug",
        "level": options["optimization_level"],
        "verify_fp": options["verify_fp"],
        "fast_math": options["fast_math"],
        "fuse_fp": options["fuse_fp"],
        "lineinfo": options["lineinfo"],
        "precompiled_headers": options["use_precompiled_headers"],
        "out": output_path,
    }
    if error := COMPILERS.outcome(json.dumps(job) + "\n"):
        raise RuntimeError(f"{Path(cu_path).name}: the compiler failed with error {error}")


def compile_apart() -> None:
    """Have Warp compile for GPUs so, from now on."""
    wp._src.build.build_cuda = build_apart
