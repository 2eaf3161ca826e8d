import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import warp as wp

import gpu.core.compilers as compilers
from gpu.core.compilers import Compilers, build_apart
from gpu.core.kernel_loading import compile_for

OPTIONS = {
    "config": "release",
    "optimization_level": 3,
    "verify_fp": False,
    "fast_math": False,
    "fuse_fp": True,
    "lineinfo": False,
    "arch_suffix": "",
    "use_precompiled_headers": True,
}


@pytest.fixture
def source(tmp_path: Path) -> str:
    path = tmp_path / "one.cu"
    path.write_text('extern "C" __global__ void one(float* found) { found[0] = 1.0f; }')
    return str(path)


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[subprocess.Popen[str]]]:
    """The compilers that a test starts; none waits at its beginning, nor after it."""
    processes: list[subprocess.Popen[str]] = []
    own = Compilers()
    start = own.start

    def noted() -> subprocess.Popen[str]:
        processes.append(start())
        return processes[-1]

    monkeypatch.setattr(own, "start", noted)
    monkeypatch.setattr(compilers, "COMPILERS", own)
    yield processes
    own.end()


def build(source: str, out: Path) -> bytes:
    build_apart(source, 90, str(out), pch_dir=None, **OPTIONS)
    return out.read_bytes()


def test_a_process_compiles_one_kernel_after_another_as_warp_does(
    source: str, tmp_path: Path, started: list[subprocess.Popen[str]]
) -> None:
    built = [build(source, tmp_path / f"{number}.cubin") for number in range(2)]
    compilers._build_cuda(source, 90, str(tmp_path / "own.cubin"), pch_dir=None, **OPTIONS)
    assert built == [(tmp_path / "own.cubin").read_bytes()] * 2
    assert len(started) == 1


def test_another_is_started_where_one_has_ended(
    source: str, tmp_path: Path, started: list[subprocess.Popen[str]]
) -> None:
    build(source, tmp_path / "first.cubin")
    started[0].kill()
    assert build(source, tmp_path / "second.cubin")
    assert len(started) == 2


def test_compilers_end_once_there_is_no_work(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[subprocess.Popen[str]]
) -> None:
    monkeypatch.setattr(compilers, "IDLE_SECONDS", 0.01)
    build(source, tmp_path / "first.cubin")
    assert started[0].wait(30) == 0


def test_what_does_not_compile_is_named(source: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Path(source).write_text("no kernel")
    with pytest.raises(RuntimeError, match=r"one\.cu: the compiler failed"):
        build(source, tmp_path / "out.cubin")
    assert "one.cu" in capfd.readouterr().err


def test_a_compiler_that_ends_at_once_is_told(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[subprocess.Popen[str]]
) -> None:
    monkeypatch.setattr(compilers.sys, "executable", "/bin/false")
    with pytest.raises(RuntimeError, match="ended with status 1"):
        build(source, tmp_path / "out.cubin")
    assert len(started) == 1


def test_kernels_are_compiled_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, started: list[subprocess.Popen[str]]
) -> None:
    @wp.kernel(module="unique")
    def halved_kernel(found: wp.array[float]) -> None:
        found[0] = found[0] * 0.5

    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    compile_for([halved_kernel], 90, 128)
    assert len(started) == 1
    assert list(tmp_path.rglob("*.cubin"))
