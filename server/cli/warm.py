"""Kernels compiled ahead: the command `lumenwalk warm`."""

from time import perf_counter

import warp as wp

from gpu.core.device import choose_device
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import ImportOptions
from gpu.settings import RenderSettings
from gpu.warm_up import compile_ahead
from server.cli.reading import read_scene
from server.worker.kernel_cache import check_kernel_cache, needs_kernel_cache


def warm_scenes(sources: tuple[str, ...], reading: ImportOptions, settings: RenderSettings, device: str | None,
                architectures: tuple[int, ...] = (), *, general: bool = False) -> None:  # fmt: skip
    """Compile what scenes need (all built-in ones where none is named) into the folder of kernels; a line for each.

    device: None takes the best there is; architectures: of GPUs that need not be here, ten times their compute
    capabilities, instead; general: kernels too that other scenes begin with. Raises UserError for a scene, device or
    compute capability that there is not, and where kernels cannot be kept.
    """
    with needs_kernel_cache():
        known = wp.get_cuda_supported_archs()
        chosen = choose_device("cpu" if architectures else device)
    if unknown := sorted(set(architectures) - set(known)):
        there_are = ", ".join(map(str, known))
        raise UserError(f"--architecture {unknown[0]}: no such compute capability; there are {there_are}")
    check_kernel_cache(wp.config.kernel_cache_dir)
    for source in sources or tuple(BUILTIN):
        scene = read_scene(source, reading)
        begun = perf_counter()
        device_scene = DeviceScene(scene, str(chosen))
        for architecture in architectures or (None,):
            compile_ahead(device_scene, settings, general=general, architecture=architecture)
        print(f"{source}: {perf_counter() - begun:.1f} s", flush=True)
