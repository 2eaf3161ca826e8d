"""What a GPU's compiler makes of a frame's kernels: `python -m tests.bench.gpu_code SCENE METHOD`. It needs no GPU.

With `general` behind them, of general kernels, which stand in for the scene's own while those are compiled.

A line for each kernel, as its module is compiled: registers and bytes of stack a thread, bytes of code, and the seconds
that the module took here. Where a change makes a kernel compile for minutes, take more than 128 registers or a stack
that it had not, frames are slower: that is known before anybody has timed them.
"""

import json
import struct
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

import warp as wp

from gpu.device_scene.upload import DeviceScene
from gpu.scene.load import load_scene
from gpu.settings import Method, RenderSettings
from gpu.warm_up import frame_kernels

HOPPER = 90
ENTRY = "_cuda_kernel_forward"
# Of the binaries that hold code for GPUs, which are ELF files: attributes in `.nv.info` with a value for a function.
REGISTERS, STACK = 0x2F, 0x12
VALUE_OF_A_FUNCTION = struct.Struct("<BBHII")


@dataclass(frozen=True)
class KernelCode:
    """registers: of a thread; stack: of a thread; code: of the kernel with all that was made part of it [bytes]."""

    kernel: str
    registers: int
    stack: int
    code: int


class _Section(NamedTuple):
    """As in an ELF file's table of sections."""

    name: int
    kind: int
    flags: int
    address: int
    offset: int
    size: int
    link: int
    info: int
    alignment: int
    entry_size: int


def read_cubin(content: bytes) -> list[KernelCode]:
    """The kernels of a binary for a GPU, by name."""
    (table,) = struct.unpack_from("<Q", content, 0x28)
    count, names_at = struct.unpack_from("<HH", content, 0x3C)
    listed = [_Section(*struct.unpack_from("<IIQQQQIIQQ", content, table + 64 * index)) for index in range(count)]

    def name(strings: _Section, at: int) -> str:
        begin = strings.offset + at
        return content[begin : content.index(b"\0", begin)].decode()

    sections = {name(listed[names_at], section.name): section for section in listed}
    symbols, info = sections[".symtab"], sections[".nv.info"]
    told: dict[tuple[str, int], int] = {}
    for attribute, symbol, value in _values(content[info.offset : info.offset + info.size]):
        (at,) = struct.unpack_from("<I", content, symbols.offset + symbols.entry_size * symbol)
        told[name(listed[symbols.link], at), attribute] = value
    entries = sorted(function for function, attribute in told if attribute == REGISTERS and function.endswith(ENTRY))
    return [
        KernelCode(
            entry.removesuffix(ENTRY),
            told[entry, REGISTERS],
            told.get((entry, STACK), 0),
            sections[f".text.{entry}"].size,
        )
        for entry in entries
    ]


def _values(info: bytes) -> Iterator[tuple[int, int, int]]:
    """Attribute, symbol and value of those that are of a function."""
    at = 0
    while at < len(info):
        form, attribute, size = struct.unpack_from("<BBH", info, at)
        sized = form == 4
        if sized and size == 8:
            _, _, _, symbol, value = VALUE_OF_A_FUNCTION.unpack_from(info, at)
            yield attribute, symbol, value
        at += 4 + (size if sized else 0)


def compiled(module: wp.Module, architecture: int = HOPPER) -> list[KernelCode]:
    """The kernels of a module, as they are for GPUs of this compute capability times ten."""
    with TemporaryDirectory() as folder:
        wp.compile_aot_module(module, device=None, arch=architecture, module_dir=folder, use_ptx=False)
        (binary,) = Path(folder).glob("*.cubin")
        return read_cubin(binary.read_bytes())


def main(arguments: list[str]) -> None:
    scene, method, *which = arguments
    settings = RenderSettings(method=Method(method))
    device_scene = DeviceScene(load_scene(scene), "cpu").as_on_gpus().generalised(general=which == ["general"])
    for module in dict.fromkeys(kernel.module for kernel in frame_kernels(device_scene, settings)):
        began = perf_counter()
        kernels = compiled(module)
        seconds = round(perf_counter() - began, 1)
        for kernel in kernels:
            print(json.dumps(asdict(kernel) | {"seconds": seconds}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
