"""The compute device: its choice, launches that use all of it, and arrays on it."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from typing import Any

import warp as wp

from gpu.errors import DeviceError

# Warp reports its start on stdout, which belongs to `--json`; adjoints are never used and double the compile time.
wp.config.log_level = wp.LOG_WARNING
wp.config.enable_backward = False
# Longer loops in a row are more code than a GPU's caches hold, and more registers.
wp.config.max_unroll = 4
# Warp's own limits of inlining take a third longer to compile for a CPU and make frames no faster.
wp.config.cpu_compiler_flags = "-march=native"

CORES = cpu_count() or 1
MIN_SLICE = 1024
# Threads of a block, which end together: small, so that few wait for the longest where times differ, as with rays.
BLOCK = 128
# Blocks of a launch; with more items, each thread takes several. So a launch sized for the most items there may be
# costs little when there are few. Multiples of a warp, so that lanes of an item (gpu.core.intrinsics) stay in one warp.
MOST_BLOCKS = (1 << 20) // BLOCK
# Blocks of a launch that mostly has nothing to do: about as many as run at once; starting more takes time for nothing.
FEW_BLOCKS = (1 << 18) // BLOCK

_prioritised: set[str] = set()
_pool = ThreadPoolExecutor(CORES, thread_name_prefix="warp-cpu")


def choose_device(name: str | None) -> wp.Device:
    """The device called `name` ("cpu", "cuda:0", …), or the first CUDA device, or the CPU when there is none.

    On a CUDA device the current stream becomes one of high priority. Raises DeviceError, which lists the devices there
    are, when `name` is not one of them.
    """
    if name is None:
        name = "cuda:0" if wp.is_cuda_available() else "cpu"
    available = {device.alias: device for device in wp.get_devices()}
    if name == "cuda" and "cuda:0" in available:
        name = "cuda:0"
    if name not in available:
        raise DeviceError(f"no device {name!r} here; available: {', '.join(available)}")
    device = available[name]
    if device.is_cuda and device.alias not in _prioritised:
        # What is forked (gpu.core.stages.Stages.fork) runs on streams of usual priority, on what the stages leave free.
        wp.set_stream(wp.Stream(device, priority=-1), device)
        _prioritised.add(device.alias)
    return device


def launch(kernel: wp.Kernel, count: int, inputs: Sequence[Any], device: wp.Device, blocks: int = MOST_BLOCKS) -> None:
    """Run `kernel` over `count` items; its first parameter receives the first item of a launch.

    CUDA gets one launch, of at most so many `blocks` of threads. The CPU gets slices on all cores: a CPU launch runs on
    one thread but releases the GIL. No two items may write the same element: atomics are not atomic between slices
    (launch_together).
    """
    if count == 0:
        return
    if device.is_cuda:
        wp.launch(kernel, dim=count, inputs=[0, *inputs], device=device, block_dim=BLOCK, max_blocks=blocks)
        return
    size = max(MIN_SLICE, -(-count // (4 * CORES)))
    if size >= count:
        wp.launch(kernel, dim=count, inputs=[0, *inputs], device=device)
        return
    kernel.module.load(device, block_dim=1)  # as CPU launches do: compiled once, before the threads race for it
    slices = [
        _pool.submit(wp.launch, kernel, min(size, count - first), [first, *inputs], device=device)
        for first in range(0, count, size)
    ]
    for slice_ in slices:
        slice_.result()


def launch_together(
    kernel: wp.Kernel, count: int, inputs: Sequence[Any], device: wp.Device, blocks: int = MOST_BLOCKS
) -> None:
    """As `launch`, for a kernel whose items add to the same elements: the CPU runs it on one core."""
    if count > 0:
        wp.launch(kernel, dim=count, inputs=[0, *inputs], device=device, block_dim=BLOCK, max_blocks=blocks)


def allocate(struct: Any, count: int, device: wp.Device, rows: int = 0) -> Any:
    """An instance of the Warp struct `struct` of zeros: arrays of `count` elements, 2D ones of `rows` by `count`."""
    instance = struct()
    for name, variable in struct.vars.items():
        if hasattr(variable.type, "dtype"):
            shape = (rows, count) if variable.type.ndim == 2 else count
            setattr(instance, name, wp.zeros(shape, dtype=variable.type.dtype, device=device))
    return instance


def overwrite(struct: Any, target: Any, source: Any) -> None:
    """Copy the arrays of an instance of the Warp struct type `struct` into those of another, which are as long."""
    for name, variable in struct.vars.items():
        if hasattr(variable.type, "dtype"):
            wp.copy(getattr(target, name), getattr(source, name))


def duplicate(struct: Any, instance: Any) -> Any:
    """A copy of an instance of the Warp struct type `struct` that shares its arrays."""
    result = struct()
    for name in struct.vars:
        setattr(result, name, getattr(instance, name))
    return result
