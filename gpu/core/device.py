"""The compute device: its choice, launches that use all of it, and arrays on it."""

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from math import inf
from os import cpu_count, environ
from time import perf_counter, thread_time
from typing import Any

import numpy as np
import warp as wp

from gpu.core.kernel_loading import compile_beside, is_noted
from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import DeviceError

# Warp reports its start on stdout, which belongs to `--json`; adjoints are never used and double the compile time.
wp.config.log_level = wp.LOG_WARNING
wp.config.enable_backward = False
# Longer loops in a row are more code than a GPU's caches hold, and more registers.
wp.config.max_unroll = 4
# Warp's own limits of inlining take a third longer to compile for a CPU and make frames no faster.
wp.config.cpu_compiler_flags = "-march=native"

# Of queues from the host to a GPU, which it looks at as it begins: streams that share one wait for each other, and each
# lane (gpu.core.lane) has two, and more for what is forked apart and once an edit has changed its light.
environ.setdefault("CUDA_DEVICE_MAX_CONNECTIONS", "32")

CORES = cpu_count() or 1
MIN_SLICE = 1024
# Of a launch on the CPU, which is over before other threads have begun.
SHORT_SECONDS = 0.001
# Of a launch, after which others may have the device: a fraction of what they can wait. Until it is known how long a
# kernel takes, a slice has few items.
CPU_SLICE_SECONDS, CUDA_SLICE_SECONDS = 0.05, 0.01
FIRST_CPU_SLICE, FIRST_CUDA_SLICE = 64, 1 << 20
# Fewer items leave some of a GPU idle, or few, where a kernel is slow and needs many registers: four paths for each of
# 1280×720 pixels took an H100 118 ms. A launch with less to do than LONG_LAUNCH is over before anybody waits.
LEAST_CUDA_SLICE, LONG_LAUNCH = 1 << 17, 1 << 21
# Threads of a block, which end together: small, so that few wait for the longest where times differ, as with rays.
BLOCK = 128
# Of kernels that trace rays and shade what those meet, as far as it was measured: with as many as they would take, too
# few threads wait for memory and rays at once.
RAY_REGISTERS = 64
# Blocks of a launch; with more items, each thread takes several. So a launch sized for the most items there may be
# costs little when there are few. Multiples of a warp, so that lanes of an item (gpu.core.intrinsics) stay in one warp.
MOST_BLOCKS = (1 << 20) // BLOCK
# Blocks of a launch that mostly has nothing to do: about as many as run at once; starting more takes time for nothing.
FEW_BLOCKS = (1 << 18) // BLOCK

_prioritised: set[str] = set()
_pool = ThreadPoolExecutor(CORES, thread_name_prefix="warp-cpu")


def choose_device(name: str | None) -> wp.Device:
    """The device called `name` ("cpu", "cuda:0", …), or the first CUDA device, or the CPU when there is none.

    A CUDA device becomes the current one, and its current stream one of high priority. Raises DeviceError, which lists
    the devices there are, when `name` is not one of them.
    """
    if name is None:
        name = "cuda:0" if wp.is_cuda_available() else "cpu"
    available = {device.alias: device for device in wp.get_devices()}
    if name == "cuda" and "cuda:0" in available:
        name = "cuda:0"
    if name not in available:
        raise DeviceError(f"no device {name!r} here; available: {', '.join(available)}")
    device = available[name]
    if device.is_cuda:
        # Page-locked memory is made by the current device: by another one it would take memory of that, too.
        wp.set_device(device)
    if device.is_cuda and device.alias not in _prioritised:
        # What is forked (gpu.core.stages.Stages.fork) runs on streams of usual priority, on what the stages leave free.
        wp.set_stream(wp.Stream(device, priority=-1), device)
        _prioritised.add(device.alias)
    return device


def block_of(device: wp.Device) -> int:
    """How many threads of a launch on a device are a block, for which kernels are compiled."""
    return BLOCK if device.is_cuda else 1


def launch(kernel: wp.Kernel, count: int, inputs: Sequence[Any], device: wp.Device, blocks: int = MOST_BLOCKS,
           weight: int = 1) -> None:  # fmt: skip
    """Run `kernel` over `count` items; its first parameter receives the first item of a launch.

    CUDA gets one launch, of at most so many `blocks` of threads; where the device is shared, long ones in slices. The
    CPU gets slices on all cores: a CPU launch runs on one thread but releases the GIL. No two items may write the same
    element: atomics are not atomic between slices (launch_together). weight: how much an item has to do, where that
    differs from launch to launch.
    """
    if is_noted(kernel):
        return
    compile_beside(kernel, device, block_of(device))
    if device.is_cuda:
        _launch_on_cuda(kernel, count, inputs, device, blocks, weight)
    elif count > 0:
        most = max(MIN_SLICE, -(-count // (4 * CORES)))
        _launch_on_cpu(kernel, count, inputs, device, most, weight, CORES)


def launch_together(
    kernel: wp.Kernel, count: int, inputs: Sequence[Any], device: wp.Device, blocks: int = MOST_BLOCKS
) -> None:
    """As `launch`, for a kernel whose items add to the same elements: the CPU runs it on one core."""
    if is_noted(kernel):
        return
    compile_beside(kernel, device, block_of(device))
    if device.is_cuda:
        _launch_on_cuda(kernel, count, inputs, device, blocks, 1)
    elif count > 0:
        _launch_on_cpu(kernel, count, inputs, device, count, 1, 1)


def launch_on_host(kernel: wp.Kernel, inputs: Sequence[Any]) -> None:
    """Run a `host_kernel` once, on one core, whatever the device: for what has to be done step by step."""
    wp.launch(kernel, dim=1, inputs=list(inputs), device="cpu")


# What an item of weight 1 of a kernel took last, on one core or a whole GPU [s].
_costs: dict[wp.Kernel, float] = {}


def _launch_on_cuda(kernel: wp.Kernel, count: int, inputs: Sequence[Any], device: wp.Device, blocks: int,
                    weight: int) -> None:  # fmt: skip
    if not DEVICE_SHARING.active or count * weight < LONG_LAUNCH:
        if count > 0:
            wp.launch(kernel, dim=count, inputs=[0, *inputs], device=device, block_dim=BLOCK, max_blocks=blocks)
        return
    kernel.module.load(device, block_dim=BLOCK)  # which is no time of the kernel's
    wp.synchronize_device(device)
    first = 0
    while first < count:
        cost = _costs.get(kernel)
        wanted = FIRST_CUDA_SLICE // weight if cost is None else int(CUDA_SLICE_SECONDS / (cost * weight))
        size = min(max(wanted // BLOCK * BLOCK, LEAST_CUDA_SLICE), count - first)
        begun = perf_counter()
        wp.launch(kernel, dim=size, inputs=[first, *inputs], device=device, block_dim=BLOCK, max_blocks=blocks)
        wp.synchronize_device(device)
        _costs[kernel] = (perf_counter() - begun) / (size * weight)
        first += size
        DEVICE_SHARING.pause()


def _launch_on_cpu(kernel: wp.Kernel, count: int, inputs: Sequence[Any], device: wp.Device, most: int, weight: int,
                   cores: int) -> None:  # fmt: skip
    """Launch in slices of up to `most` items on so many cores."""
    kernel.module.load(device, block_dim=1)  # as CPU launches do: compiled once, before the threads race for it
    if _costs.get(kernel, inf) * weight * count < SHORT_SECONDS:
        most = count

    def run(first: int, size: int) -> float:
        begun = thread_time()  # on a busy machine it waits long, but does not work longer
        wp.launch(kernel, dim=size, inputs=[first, *inputs], device=device)
        return (thread_time() - begun) / (size * weight)

    def slice_at(first: int) -> int:
        cost = _costs.get(kernel)
        size = FIRST_CPU_SLICE if cost is None else max(int(CPU_SLICE_SECONDS / max(cost * weight, 1e-9)), 1)
        return min(size, most, count - first)

    first, running = 0, deque[Future[float]]()
    while first < count or running:
        if not running and (cores == 1 or slice_at(first) == count - first):
            size = slice_at(first)
            _costs[kernel] = run(first, size)
            first += size
        else:
            while first < count and len(running) < 2 * cores and not (running and DEVICE_SHARING.due):
                size = slice_at(first)
                running.append(_pool.submit(run, first, size))
                first += size
            _costs[kernel] = running.popleft().result()
        if not running:
            DEVICE_SHARING.pause()


def allocate(struct: Any, count: int, device: wp.Device, rows: int = 0, *, pauses: bool = False) -> Any:
    """An instance of the Warp struct `struct` of zeros: arrays of `count` elements, 2D ones of `rows` by `count`.

    pauses: others may have the device between arrays, each of which may take a GPU's driver some milliseconds to find.
    """
    instance = struct()
    for name, variable in struct.vars.items():
        if hasattr(variable.type, "dtype"):
            if pauses:
                DEVICE_SHARING.pause()
            shape = (rows, count) if variable.type.ndim == 2 else count
            setattr(instance, name, wp.zeros(shape, dtype=variable.type.dtype, device=device))
    return instance


def layout_of(struct: Any) -> np.dtype:
    """How NumPy lays out rows of the Warp struct type `struct`. To find out takes Warp a fraction of a millisecond."""
    return np.dtype(struct.numpy_dtype())


def struct_array(struct: Any, rows: np.ndarray, device: wp.Device) -> wp.array:
    """An array of the Warp struct type `struct` of `rows` (row,), which are laid out as it is. Warp's own way takes the
    host a millisecond.
    """
    array = wp.empty(len(rows), dtype=struct, device=device)
    wp.array(ptr=array.ptr, dtype=wp.uint8, shape=rows.nbytes, device=device).assign(np.frombuffer(rows, np.uint8))
    return array


def write_changes(array: wp.array, before: np.ndarray, now: np.ndarray) -> tuple[int, int]:
    """Have an `array` that holds what is in `before` hold what is in `now`: 32-bit numbers in rows that are as many.
    From the first row that differs, which is returned, to before the last one, they come from the host.
    """
    rows = np.zeros(0, np.intp) if now is before else np.flatnonzero(now.view(np.int32) != before.view(np.int32))
    if len(rows) == 0:
        return 0, 0
    begin, end = int(rows[0]) // now.shape[1], int(rows[-1]) // now.shape[1] + 1
    array[begin:end].assign(now[begin:end])
    return begin, end


def identical(one: Any, other: Any) -> bool:
    """Whether two instances of a Warp struct type have the same arrays, not merely equal ones, and the same numbers."""
    return bytes(one.__ctype__()) == bytes(other.__ctype__())


def alike(struct: Any, one: Any, other: Any) -> bool:
    """Whether two instances of the Warp struct type `struct` differ in nothing but what their arrays hold."""
    if identical(one, other):
        return True

    def same(kind: Any, a: Any, b: Any) -> bool:
        if a is None or b is None:
            return a is b
        if isinstance(a, wp.array):
            return bool(a.shape == b.shape)
        # Warp's own numbers, which fields have at first, do not compare by value.
        return alike(kind, a, b) if hasattr(kind, "vars") else bool(getattr(a, "value", a) == getattr(b, "value", b))

    # Arrays of nested structs that were never set cannot be asked for.
    fields = ((it.type, getattr(one, name, None), getattr(other, name, None)) for name, it in struct.vars.items())
    return all(same(*values) for values in fields)


def overwrite(struct: Any, target: Any, source: Any) -> None:
    """Copy the arrays of an instance of the Warp struct type `struct` into those of another that is `alike`."""
    if identical(target, source):
        return
    for name, variable in struct.vars.items():
        into, values = getattr(target, name, None), getattr(source, name, None)
        if isinstance(into, wp.array):
            if into is not values:
                wp.copy(into, values)
        elif into is not None and hasattr(variable.type, "vars"):
            overwrite(variable.type, into, values)


def duplicate(struct: Any, instance: Any) -> Any:
    """A copy of an instance of the Warp struct type `struct` that shares its arrays."""
    result = struct()
    for name in struct.vars:
        setattr(result, name, getattr(instance, name))
    return result
