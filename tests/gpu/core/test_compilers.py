import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Semaphore

import pytest
import warp as wp

import gpu.core.compilers as compilers
from gpu.core.compilers import Compilers, Process
from gpu.core.kernel_loading import compile_for

SOURCE = 'extern "C" __attribute__((dllexport)) int answer() { return 42; }\n'


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Process]]:
    """The processes that a test starts; none waits at its beginning, nor after it."""
    processes: list[Process] = []
    own = Compilers()
    start = own.start

    def noted() -> Process:
        processes.append(start())
        return processes[-1]

    monkeypatch.setattr(own, "start", noted)
    monkeypatch.setattr(compilers, "COMPILERS", own)
    yield processes
    own.end()


def build(folder: Path, name: str, source: str = SOURCE) -> bytes:
    """Compile a source for the CPU; returns what comes out."""
    code, built = folder / f"{name}.cpp", folder / f"{name}.o"
    code.write_text(source)
    wp.init()
    wp._src.build.build_cpu(str(built), str(code), use_precompiled_headers=False)
    return built.read_bytes()


def halved_kernel() -> wp.Kernel:
    @wp.kernel(module="unique")
    def halved_kernel(found: wp.array[float]) -> None:
        found[0] = found[0] * 0.5

    return halved_kernel


def test_a_process_compiles_one_after_another(tmp_path: Path, started: list[Process]) -> None:
    assert build(tmp_path, "one")
    assert build(tmp_path, "two")
    assert len(started) == 1


def test_as_many_compile_as_there_are_calls_at_once(tmp_path: Path, started: list[Process]) -> None:
    build(tmp_path, "one")
    os.kill(started[0].pid, signal.SIGSTOP)
    with ThreadPoolExecutor(1) as pool:
        waits = pool.submit(build, tmp_path, "two")
        while compilers.COMPILERS._idle:
            pass
        assert build(tmp_path, "three")
        assert not waits.done()
        os.kill(started[0].pid, signal.SIGCONT)
        assert waits.result(30.0)
    assert len(started) == 2


def test_no_more_compile_than_there_may(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[Process]
) -> None:
    build(tmp_path, "one")
    monkeypatch.setattr(compilers.COMPILERS, "_room", Semaphore(1))
    with ThreadPoolExecutor(3) as pool:
        built = list(pool.map(lambda name: build(tmp_path, name), ("two", "three", "four")))
    assert all(built)
    assert len(started) == 1


def test_another_is_started_where_one_has_ended(tmp_path: Path, started: list[Process]) -> None:
    build(tmp_path, "one")
    started[0].kill()
    assert build(tmp_path, "two")
    assert len(started) == 2


def test_a_process_that_does_not_answer_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[Process]
) -> None:
    build(tmp_path, "one")
    os.kill(started[0].pid, signal.SIGSTOP)
    monkeypatch.setattr(compilers, "HANG_SECONDS", 0.0)
    more_than_a_pipe_holds = SOURCE + "// " + "x" * (1 << 20)
    with pytest.raises(RuntimeError, match="ended with status -9"):
        build(tmp_path, "two", more_than_a_pipe_holds)
    assert [process.returncode for process in started] == [-9, -9]


def test_processes_end_once_there_is_no_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[Process]
) -> None:
    monkeypatch.setattr(compilers, "IDLE_SECONDS", 0.01)
    build(tmp_path, "one")
    assert started[0].wait(30) == 0


def test_what_does_not_compile_is_told(
    tmp_path: Path, started: list[Process], capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(Exception, match="CPU kernel build failed"):
        build(tmp_path, "wrong", "no code\n")
    assert "wrong.cpp" in capfd.readouterr().err
    assert build(tmp_path, "right")
    assert len(started) == 1


def test_a_process_that_ends_at_once_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[Process]
) -> None:
    monkeypatch.setattr(compilers.sys, "executable", "/bin/false")
    with pytest.raises(RuntimeError, match="ended with status 1"):
        build(tmp_path, "one")
    assert len(started) == 1


def test_a_process_has_no_secrets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[Process]) -> None:
    monkeypatch.setenv("LUMENWALK_TOKEN", "secret")
    build(tmp_path, "one")
    assert b"secret" not in Path(f"/proc/{started[0].pid}/environ").read_bytes()


def test_kernels_are_compiled_so_for_cpus_and_gpus(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[Process]
) -> None:
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    kernel, values = halved_kernel(), wp.array([3.0], dtype=float, device="cpu")
    wp.launch(kernel, dim=1, inputs=[values], device="cpu")
    assert values.numpy().tolist() == [1.5]
    compile_for([kernel], 90, 128)
    assert list(tmp_path.rglob("*.cubin"))
    assert len(started) == 1
