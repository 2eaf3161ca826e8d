"""Kernels compiled and loaded side by side, before the frames that launch them; else each waits for the one before."""

import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from hashlib import sha256
from os import cpu_count
from pathlib import Path
from threading import Lock
from time import monotonic, sleep
from typing import Any

import warp as wp

from gpu.core.compilers import compile_apart
from gpu.core.kept_functions import keep_functions
from gpu.core.sharing import DEVICE_SHARING

WORKERS = cpu_count() or 1
PACKAGE = __name__.partition(".")[0]
# Until kernels that nobody waits for are compiled: code is made of them in Python, one after the other, while a first
# picture would wait for the same lock.
LATE_SECONDS = 3.0

_noted: set[wp.Kernel] | None = None
_host_kernels: set[wp.Kernel] = set()
_loading = Lock()  # two threads may want the same module
# Modules that need no compiler any more, and those that one is at, whoever waits for them; each for a device.
_Build = tuple[wp.Module, str]
_built: set[_Build] = set()
_builds: dict[_Build, Future[None]] = {}
_builders = ThreadPoolExecutor(WORKERS, thread_name_prefix="compile")
# Of kernels that nobody waits for: others have the other cores.
_late_builders = ThreadPoolExecutor(max(WORKERS // 2, 1), thread_name_prefix="compile-late")


def _header_folder(_: Any) -> str:
    """Where Warp's headers are kept as Clang has read them for kernels on CPUs, which takes it four seconds.

    Warp itself makes a folder for each thread of each process. Clang writes a file aside and renames it, reads no file
    of other headers, and writes it anew where it is out of date.
    """
    headers, flags = Path(wp.__file__).parent / "native" / "builtin.h", wp.config.cpu_compiler_flags
    read = wp._src.context._get_cpu_target_hash(flags), headers, headers.stat().st_mtime_ns
    folder = Path(wp.config.kernel_cache_dir) / f"headers_{sha256(repr(read).encode()).hexdigest()[:8]}"
    folder.mkdir(parents=True, exist_ok=True)
    return str(folder)


wp._src.context.Runtime.get_clang_pch_dir = _header_folder
keep_functions()
compile_apart()


@contextmanager
def noted_kernels() -> Iterator[set[wp.Kernel]]:
    """The kernels that are launched within by gpu.core.device, which runs none of them meanwhile.

    Arrays stay as they are, so what is made of them is nothing to be shown. Not for two threads at a time.
    """
    global _noted
    _noted = kernels = set[wp.Kernel]()
    try:
        yield kernels
    finally:
        _noted = None


def is_noted(kernel: wp.Kernel) -> bool:
    """Whether launches are noted, not run, now: then this one was."""
    if _noted is None:
        return False
    _noted.add(kernel)
    return True


def host_kernel(function: Callable[..., None]) -> wp.Kernel:
    """A kernel that runs on the CPU alone, whatever the device (gpu.core.device.launch_on_host)."""
    kernel = wp.kernel(function)
    _host_kernels.add(kernel)
    return kernel


def imported_kernels(package: str = PACKAGE) -> list[wp.Kernel]:
    """Those at the top of the modules of a package that have been imported, but those of the host.

    Another thread may import more meanwhile.
    """
    modules = [module for name, module in sys.modules.copy().items() if name.startswith(f"{package}.")]
    values = [value for module in modules for value in vars(module).copy().values()]
    return [value for value in values if isinstance(value, wp.Kernel) and value not in _host_kernels]


def host_kernels() -> list[wp.Kernel]:
    """Those of the host that have been imported."""
    return list(_host_kernels)


def load_kernels(kernels: Iterable[wp.Kernel], device: wp.Device, block: int) -> None:
    """Take these kernels from Warp's cache, or compile them, for blocks of so many threads: first those of most code,
    at which a compiler is longest. Others may have the device until they are compiled.
    """
    ordered = _by_work(kernels, device, block)
    modules = list(dict.fromkeys(kernel.module for kernel in ordered))
    if DEVICE_SHARING.active:
        missing = dict.fromkeys(kernel.module for kernel in ordered if not is_compiled(kernel, device, block))
        builds = [_building(module, device, block) for module in missing]
        DEVICE_SHARING.wait_for(lambda: all(build.done() for build in builds))
        for module in missing:
            _builds.pop((module, device.alias), None)
    if modules:
        with _loading:
            wp.force_load(device, modules, block_dim=block, max_workers=WORKERS)


def _by_work(kernels: Iterable[wp.Kernel], device: wp.Device, block: int) -> list[wp.Kernel]:
    """Those first that a compiler is at longest."""
    sizes: dict[Any, int] = {}

    def work(kernel: wp.Kernel) -> int:
        """A measure of what a compiler has to do; to find it takes longer than to load what needs none."""
        return 0 if is_compiled(kernel, device, block) else _inlined_size(kernel, sizes)

    return sorted(kernels, key=work, reverse=True)


def _inlined_size(code: wp.Kernel | wp.Function, sizes: dict[Any, int]) -> int:
    """Characters of the source of a kernel or function with all that it calls, which are counted anew for each function
    that calls them, as compilers inline them. sizes: of all that were asked for before.
    """
    if code not in sizes:
        called = [other for other in code.adj.get_references()[2] if not other.is_builtin()]
        sizes[code] = len(code.adj.source) + sum(_inlined_size(other, sizes) for other in called)
    return sizes[code]


def compile_for(kernels: Iterable[wp.Kernel], architecture: int, block: int) -> None:
    """Compile what Warp's cache has not of these kernels, for GPUs of this compute capability times ten.

    No GPU need be here. block: threads of a block; architecture: one of `wp.get_cuda_supported_archs()`.
    """

    def is_there(module: wp.Module) -> bool:
        return (_folder(module, block) / module._get_compile_output_name(None, architecture, block_dim=block)).exists()

    modules = [module for module in dict.fromkeys(kernel.module for kernel in kernels) if not is_there(module)]
    with ThreadPoolExecutor(WORKERS) as pool:
        for built in [pool.submit(_compile, module, None, block, architecture) for module in modules]:
            built.result()


def is_compiled(kernel: wp.Kernel, device: wp.Device, block: int) -> bool:
    """Whether Warp's cache has a kernel for blocks of so many threads."""
    return (_folder(kernel.module, block) / kernel.module._get_compile_output_name(device, block_dim=block)).exists()


class LateKernels:
    """Kernels that are compiled for blocks of so many threads, into Warp's cache, while others have the device."""

    def __init__(
        self, kernels: Iterable[wp.Kernel], device: wp.Device, block: int, after: float = LATE_SECONDS
    ) -> None:
        """after: seconds that others are left for a first picture, and half of the cores from then on."""
        self._modules = list(dict.fromkeys(kernel.module for kernel in _by_work(kernels, device, block)))
        self._device, self._block = device, block
        begins, builders = monotonic() + after, _late_builders if after > 0.0 else _builders
        for module in self._modules:
            build = module, device.alias
            if build not in _builds:
                _builds[build] = builders.submit(partial(_compile_from, begins, module, device, block))
        self._futures = [_builds[module, device.alias] for module in self._modules]

    @property
    def compiled(self) -> bool:
        """Whether no compiler is at work any more."""
        return all(future.done() for future in self._futures)

    def load(self) -> None:
        """Load them one after the other, once they are compiled; others may have the device in between.

        Raises what Warp did where a compiler failed.
        """
        for module, future in zip(self._modules, self._futures, strict=True):
            _builds.pop((module, self._device.alias), None)
            future.result()
            module.load(self._device, block_dim=self._block)
            DEVICE_SHARING.pause()


def compile_beside(kernel: wp.Kernel, device: wp.Device, block: int) -> None:
    """Compile a kernel for blocks of so many threads, if Warp's cache has it not, while others have the device.

    Where it is not shared, or not to be given away now, nothing is done: the launch does it. Loading is left to that in
    any case, since it must not meet the capture of a graph. One who is interrupted leaves the compiler to go on.
    """
    build = kernel.module, device.alias
    if build in _built or not DEVICE_SHARING.active:
        return
    if (device.context, block) not in kernel.module.execs:
        DEVICE_SHARING.wait_for(_building(kernel.module, device, block).done)
        _builds.pop(build, None)
    _built.add(build)  # what a compiler had to say against it, the launch says


def _building(module: wp.Module, device: wp.Device, block: int) -> Future[None]:
    """A compiler at work on a module, whoever has asked for it first."""
    build = module, device.alias
    if build not in _builds:
        _builds[build] = _builders.submit(partial(_compile, module, device, block))
    return _builds[build]


def _compile(module: wp.Module, device: wp.Device | None, block: int, architecture: int | None = None) -> None:
    """As the first part of `wp.Module.load`; architecture: of which GPUs, where they are not here."""
    folder = _folder(module, block)
    name = module._get_compile_output_name(device, architecture, block_dim=block)
    architecture = architecture or module._get_compile_arch(device)
    module._compile(device, folder, name, architecture, options=module.resolved_options[block])


def _compile_from(begins: float, module: wp.Module, device: wp.Device, block: int) -> None:
    """As `_compile`, from a time of `monotonic` on."""
    sleep(max(begins - monotonic(), 0.0))
    _compile(module, device, block)


def _folder(module: wp.Module, block: int) -> Path:
    """Where Warp's cache has what was compiled of a module for blocks of so many threads."""
    return Path(wp.config.kernel_cache_dir) / module.get_module_identifier(block)
