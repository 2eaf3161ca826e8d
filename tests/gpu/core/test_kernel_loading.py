import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from secrets import randbits
from threading import Event, current_thread
from time import monotonic, sleep
from types import ModuleType
from typing import Any

import pytest
import warp as wp

from gpu.core import kernel_loading
from gpu.core.device import launch, launch_together
from gpu.core.kernel_loading import (
    LateKernels,
    compile_for,
    imported_kernels,
    is_compiled,
    load_kernels,
    noted_kernels,
)
from gpu.core.radix_sort import iota_kernel
from gpu.core.sharing import DEVICE_SHARING


def test_what_is_noted_is_not_run(cpu: str) -> None:
    device, out = wp.get_device(cpu), wp.zeros(4, dtype=int, device=cpu)
    with noted_kernels() as kernels:
        launch(iota_kernel, 4, [out], device)
        launch_together(iota_kernel, 4, [out], device)
    assert kernels == {iota_kernel}
    assert out.numpy().tolist() == [0, 0, 0, 0]
    launch(iota_kernel, 4, [out], device)
    assert out.numpy().tolist() == [0, 1, 2, 3]


def test_nothing_is_noted_after_an_error() -> None:
    with pytest.raises(RuntimeError), noted_kernels():
        raise RuntimeError
    assert not kernel_loading.is_noted(iota_kernel)


def test_modules_are_loaded_once_each_side_by_side(monkeypatch: pytest.MonkeyPatch, cpu: str) -> None:
    asked: list[tuple[object, int, int]] = []

    def load(_: wp.Device, modules: object = None, *, block_dim: int, max_workers: int) -> None:
        asked.append((modules, block_dim, max_workers))

    monkeypatch.setattr(wp, "force_load", load)
    device = wp.get_device(cpu)
    load_kernels([iota_kernel, iota_kernel], device, 1)
    load_kernels([], device, 1)
    load_kernels([iota_kernel], device, 128)
    assert asked == [([iota_kernel.module], block, kernel_loading.WORKERS) for block in (1, 128)]


def test_two_threads_load_one_after_the_other(monkeypatch: pytest.MonkeyPatch, cpu: str) -> None:
    loading, at_once = list[int](), list[int]()

    def load(*_: object, **__: object) -> None:
        loading.append(1)
        sleep(0.05)
        at_once.append(len(loading))
        loading.pop()

    monkeypatch.setattr(wp, "force_load", load)
    with ThreadPoolExecutor(2) as threads:
        list(threads.map(lambda _: load_kernels([iota_kernel], wp.get_device(cpu), 1), range(2)))
    assert at_once == [1, 1]


def test_what_has_most_code_with_all_it_calls_is_compiled_first(monkeypatch: pytest.MonkeyPatch, cpu: str) -> None:
    @wp.func
    def long(x: int) -> int:
        return x * 7919 + x * 7907 + x * 7901 + x * 7883 + x * 7879 + x * 7877 + x * 7873 + x * 7867 + x * 7853

    @wp.func
    def caller(x: int) -> int:
        return long(x)

    @wp.kernel(module="unique")
    def caller_kernel(out: wp.array(dtype=int)) -> None:
        out[0] = caller(1)

    @wp.kernel(module="unique")
    def itself_kernel(out: wp.array(dtype=int)) -> None:
        out[0] = 1
        out[1] = 2
        out[2] = 3

    asked: list[wp.Module] = []
    monkeypatch.setattr(wp, "force_load", lambda _, modules, **__: asked.extend(modules))
    load_kernels([itself_kernel, caller_kernel], wp.get_device(cpu), 1)
    assert asked == [caller_kernel.module, itself_kernel.module]
    with ThreadPoolExecutor(1) as one:
        monkeypatch.setattr(kernel_loading, "_compile", lambda module, *_: asked.append(module))
        monkeypatch.setattr(kernel_loading, "_builders", one)
        LateKernels([itself_kernel, caller_kernel], wp.get_device(cpu), 1, after=0.0)
    assert asked[2:] == asked[:2]


def test_what_needs_no_compiler_is_not_measured(monkeypatch: pytest.MonkeyPatch, cpu: str) -> None:
    monkeypatch.setattr(wp, "force_load", lambda *_, **__: None)
    monkeypatch.setattr(kernel_loading, "is_compiled", lambda *_: True)
    monkeypatch.setattr(kernel_loading, "_inlined_size", lambda *_: pytest.fail("its code is gone through"))
    load_kernels([iota_kernel], wp.get_device(cpu), 1)


def test_kernels_are_compiled_for_gpus_that_are_not_here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    kernel = new_kernel()
    compile_for([kernel, kernel], 90, 128)
    name = kernel.module.get_module_identifier(128)  # where Warp looks for it on such a GPU
    assert (tmp_path / name / f"{name}.sm90.cubin").stat().st_size > 0
    assert not list(tmp_path.rglob("*.o"))
    monkeypatch.setattr("gpu.core.kernel_loading._compile", lambda *_: pytest.fail("it is there"))
    compile_for([kernel], 90, 128)


def test_kernels_are_looked_for_while_others_are_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    class Growing(str):
        """A name at whose look another module is imported."""

        __slots__ = ()

        def startswith(self, *arguments: Any) -> bool:
            monkeypatch.setitem(sys.modules, f"growing.{len(sys.modules)}", ModuleType("more"))
            return super().startswith(*arguments)

    monkeypatch.setitem(sys.modules, Growing("growing.one"), ModuleType("one"))
    assert imported_kernels("growing") == []


def test_imported_kernels_are_the_packages_own() -> None:
    kernels = imported_kernels()
    assert iota_kernel in kernels
    assert all(kernel.func.__module__.startswith("gpu.") for kernel in kernels)
    assert imported_kernels("server") == []


def new_kernel() -> wp.Kernel:
    """One that no cache has."""
    number = wp.constant(randbits(30))

    @wp.kernel(module="unique")
    def new_kernel(first: int, out: wp.array[int]) -> None:
        """One thread an item."""
        out[first + wp.tid()] = number

    return new_kernel


def test_headers_are_read_once_for_all_threads_and_processes(cpu: str) -> None:
    load_kernels([new_kernel()], wp.get_device(cpu), 1)
    with ThreadPoolExecutor(1) as another:
        folders = {ask() for ask in (header_folder, another.submit(header_folder).result)}
    (folder,) = folders
    assert folder.parent == Path(wp.config.kernel_cache_dir)
    assert any(folder.glob("*.pch"))


def test_functions_for_adjoints_are_left_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cpu: str) -> None:
    headers = header_folder()
    (tmp_path / headers.name).symlink_to(headers)  # to read them anew takes seconds
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))

    @wp.struct
    class Pair:
        ours: float
        theirs: float

    @wp.kernel(module="unique")
    def pair_kernel(first: int, out: wp.array[Pair]) -> None:
        """One thread a pair."""
        out[first + wp.tid()].ours = 1.0

    load_kernels([pair_kernel], wp.get_device(cpu), 1)
    (source,), (code,) = tmp_path.glob("*pair_kernel*/*.cpp"), tmp_path.glob("*pair_kernel*/*.o")
    assert "void adj_atomic_add(" in source.read_text()
    assert b"adj_atomic_add" not in code.read_bytes()


def header_folder() -> Path:
    return Path(wp._src.context.runtime.get_clang_pch_dir())


class Others:
    """They have the device as often as it is left to them, and do `then`."""

    def __init__(self) -> None:
        self.turns = 0
        self.then: Callable[[], None] = lambda: None

    def due(self, *, idle: bool = False) -> bool:
        return False

    def give(self) -> None:
        raise AssertionError

    def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
        assert idle
        sleep(0.002)
        self.turns += 1
        self.then()


@pytest.fixture
def others() -> Iterator[Others]:
    others = Others()
    DEVICE_SHARING.begin(others)
    yield others
    DEVICE_SHARING.begin(None)


def test_others_have_the_device_while_a_kernel_is_compiled_once(
    monkeypatch: pytest.MonkeyPatch, cpu: str, others: Others
) -> None:
    compiled, inner = [], wp.Module._compile

    def compiling(module: wp.Module, *arguments: object, **options: object) -> bool:
        made = bool(inner(module, *arguments, **options))
        compiled.append((made, current_thread().name.startswith("compile")))
        return made

    monkeypatch.setattr(wp.Module, "_compile", compiling)
    out, kernel = wp.zeros(1, dtype=int, device=cpu), new_kernel()
    launch(kernel, 1, [out], out.device)
    assert compiled == [(True, True), (False, False)]  # the launch finds it in the cache
    assert others.turns > 0
    assert out.numpy()[0] > 0
    turns = others.turns
    launch(kernel, 1, [out], out.device)
    assert (others.turns, len(compiled)) == (turns, 2)


def test_one_who_is_interrupted_leaves_the_compiler_to_whoever_comes_next(
    monkeypatch: pytest.MonkeyPatch, cpu: str, others: Others
) -> None:
    may_end, begun = Event(), list[wp.Module]()

    def compiling(module: wp.Module, device: wp.Device, block: int) -> None:
        begun.append(module)
        may_end.wait(60.0)

    def interrupt() -> None:
        raise InterruptedError

    monkeypatch.setattr(kernel_loading, "_compile", compiling)
    out, kernel = wp.zeros(1, dtype=int, device=cpu), new_kernel()
    others.then = interrupt
    for _ in range(2):
        with pytest.raises(InterruptedError):
            launch(kernel, 1, [out], out.device)
    others.then = may_end.set
    launch(kernel, 1, [out], out.device)
    assert begun == [kernel.module]
    assert out.numpy()[0] > 0


def test_others_have_the_device_while_kernels_are_compiled_to_be_loaded(cpu: str, others: Others) -> None:
    device, kernels = wp.get_device(cpu), [new_kernel() for _ in range(3)]
    load_kernels(kernels, device, 1)
    assert others.turns > 0
    assert all((device.context, 1) in kernel.module.execs for kernel in kernels)
    turns = others.turns
    load_kernels(kernels, device, 1)
    assert others.turns == turns


def test_a_launch_that_gives_nothing_away_compiles_itself(cpu: str, others: Others) -> None:
    out = wp.zeros(1, dtype=int, device=cpu)
    with DEVICE_SHARING.keep():
        launch(new_kernel(), 1, [out], out.device)
    assert others.turns == 0
    assert out.numpy()[0] > 0


def test_late_kernels_are_compiled_in_threads_and_loaded_once_they_are_there(
    monkeypatch: pytest.MonkeyPatch, cpu: str
) -> None:
    may_end, inner, begun, times = Event(), kernel_loading._compile, monotonic(), list[float]()

    def compiling(module: wp.Module, device: wp.Device, block: int) -> None:
        times.append(monotonic() - begun)
        may_end.wait(60.0)
        inner(module, device, block)

    monkeypatch.setattr(kernel_loading, "_compile", compiling)
    device, kernel = wp.get_device(cpu), new_kernel()
    late, same = (LateKernels([kernel], device, 1, after=0.2) for _ in range(2))
    assert [one.compiled for one in (late, same)] == [False, False]
    may_end.set()
    while not late.compiled:
        sleep(0.01)
    assert times[0] >= 0.2
    assert is_compiled(kernel, device, 1)
    assert not kernel.module.execs
    for one in (late, same):
        one.load()
        assert (device.context, 1) in kernel.module.execs


def test_a_late_kernel_that_cannot_be_compiled_is_said_when_it_is_to_be_loaded(
    monkeypatch: pytest.MonkeyPatch, cpu: str
) -> None:
    def failing(*_: object) -> None:
        raise RuntimeError("of a compiler")

    monkeypatch.setattr(kernel_loading, "_compile", failing)
    late = LateKernels([new_kernel()], wp.get_device(cpu), 1, after=0.0)
    while not late.compiled:
        sleep(0.01)
    with pytest.raises(RuntimeError, match="of a compiler"):
        late.load()
