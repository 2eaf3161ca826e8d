"""Kernels compiled ahead: the command `lumenwalk warm`."""

from time import perf_counter

import warp as wp

from gpu.core.device import choose_device
from gpu.device_scene.upload import DeviceScene
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import ImportOptions
from gpu.settings import RenderSettings
from gpu.warm_up import warm_up
from server.cli.reading import read_scene
from server.worker.kernel_cache import check_kernel_cache, needs_kernel_cache


def warm_scenes(sources: tuple[str, ...], reading: ImportOptions, device: str | None, settings: RenderSettings) -> None:
    """Compile what scenes need (all built-in ones where none is named) into the folder of kernels; a line for each.

    device: None takes the best there is. Raises UserError for a scene or device that is not there, and where kernels
    cannot be kept.
    """
    with needs_kernel_cache():
        chosen = choose_device(device)
    check_kernel_cache(wp.config.kernel_cache_dir)
    for source in sources or tuple(BUILTIN):
        scene = read_scene(source, reading)
        begun = perf_counter()
        warm_up(DeviceScene(scene, str(chosen)), settings)
        print(f"{source}: {perf_counter() - begun:.1f} s", flush=True)
