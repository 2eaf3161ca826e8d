import pytest
import warp as wp

from gpu.core import kernel_loading
from gpu.core.device import launch, launch_together
from gpu.core.kernel_loading import imported_kernels, load_kernels, noted_kernels
from gpu.core.radix_sort import iota_kernel


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


def test_imported_kernels_are_the_packages_own() -> None:
    kernels = imported_kernels()
    assert iota_kernel in kernels
    assert all(kernel.func.__module__.startswith("gpu.") for kernel in kernels)
    assert imported_kernels("server") == []
