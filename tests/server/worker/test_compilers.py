import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from subprocess import Popen
from threading import Thread
from time import monotonic, sleep
from typing import Any

import pytest
import warp as wp

from server.worker import compilers as module
from server.worker.compilers import COMPILERS, Compilers, compile_apart

SOURCE = 'extern "C" __attribute__((dllexport)) int answer() { return 42; }\n'


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Iterator[list["Popen[bytes]"]]:
    """The processes that are started."""
    processes: list[Popen[bytes]] = []

    def start(*arguments: Any, **options: Any) -> "Popen[bytes]":
        processes.append(Popen(*arguments, **options))
        return processes[-1]

    monkeypatch.setattr(module, "Popen", start)
    yield processes
    for process in processes:
        process.kill()


def compile_into(folder: Path, compilers: Compilers, name: str, source: str = SOURCE) -> Path:
    """Compile a source for the CPU; returns where the result is."""
    code, built = folder / f"{name}.cpp", folder / f"{name}.o"
    code.write_text(source)
    compilers.compile("build_cpu", str(built), str(code), use_precompiled_headers=False)
    return built


def wait_for_the_end(process: "Popen[bytes]") -> None:
    deadline = monotonic() + 60.0
    while process.poll() is None:
        assert monotonic() < deadline
        sleep(0.05)


def test_what_is_compiled_apart_is_there_and_the_process_ends(tmp_path: Path, started: list["Popen[bytes]"]) -> None:
    compilers = Compilers(idle_seconds=0.2)
    assert compile_into(tmp_path, compilers, "one").stat().st_size > 0
    wait_for_the_end(started[0])
    assert compile_into(tmp_path, compilers, "two").exists()
    assert len(started) == 2


def test_what_a_compiler_says_against_it_is_raised(tmp_path: Path, started: list["Popen[bytes]"]) -> None:
    compilers = Compilers()
    with pytest.raises(RuntimeError, match="CPU kernel build failed"):
        compile_into(tmp_path, compilers, "wrong", "no code\n")
    assert compile_into(tmp_path, compilers, "right").exists()
    assert len(started) == 1


def test_an_end_of_the_process_is_an_error_and_the_next_has_another(
    tmp_path: Path, started: list["Popen[bytes]"]
) -> None:
    compilers = Compilers()
    compile_into(tmp_path, compilers, "one")
    os.kill(started[0].pid, signal.SIGSTOP)  # so that it does not answer before it is gone
    ending = Thread(target=lambda: (sleep(0.5), started[0].kill()))
    ending.start()
    with pytest.raises(RuntimeError, match="ended with status -9"):
        compile_into(tmp_path, compilers, "two")
    ending.join()
    assert compile_into(tmp_path, compilers, "three").exists()


def test_a_process_that_answers_no_more_is_not_waited_for(
    tmp_path: Path, started: list["Popen[bytes]"], monkeypatch: pytest.MonkeyPatch
) -> None:
    compilers = Compilers(idle_seconds=2.0)
    compile_into(tmp_path, compilers, "one")
    os.kill(started[0].pid, signal.SIGSTOP)
    monkeypatch.setattr(module, "HANG_SECONDS", 0.0)
    second = ThreadPoolExecutor(1).submit(compile_into, tmp_path, compilers, "two")
    with pytest.raises(RuntimeError, match="ended with status -9"):
        second.result(timeout=30.0)


def test_the_process_has_heaps_for_its_threads_and_no_gpu(
    tmp_path: Path, started: list["Popen[bytes]"], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MALLOC_ARENA_MAX", "1")
    compile_into(tmp_path, Compilers(), "one")
    environment = Path(f"/proc/{started[0].pid}/environ").read_bytes().split(b"\0")
    assert b"CUDA_VISIBLE_DEVICES=" in environment
    assert not [entry for entry in environment if entry.startswith(b"MALLOC_ARENA_MAX")]


def test_warp_compiles_kernels_there(
    tmp_path: Path, started: list["Popen[bytes]"], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in COMPILERS:
        monkeypatch.setattr(wp._src.build, name, getattr(wp._src.build, name))
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    compile_apart()

    @wp.kernel(module="unique")
    def doubled_kernel(values: wp.array[float]) -> None:
        values[wp.tid()] *= 2.0

    values = wp.array([1.0, 2.0], dtype=float, device="cpu")
    wp.launch(doubled_kernel, dim=2, inputs=[values], device="cpu")
    assert values.numpy().tolist() == [2.0, 4.0]
    assert len(started) == 1
