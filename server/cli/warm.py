"""Kernels compiled ahead: the command `lumenwalk warm`."""

from collections.abc import Callable
from time import perf_counter

import warp as wp

from gpu.core.device import choose_device
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import ImportOptions
from gpu.settings import RenderSettings
from gpu.warm_up import warm_up, warm_up_for
from server.cli.reading import read_scene
from server.worker.kernel_cache import check_kernel_cache, needs_kernel_cache


def warm_scenes(sources: tuple[str, ...], reading: ImportOptions, settings: RenderSettings, device: str | None, *,
                general: bool = False) -> None:  # fmt: skip
    """Compile what scenes need (all built-in ones where none is named) into the folder of kernels; a line for each.

    device: None takes the best there is; general: general kernels, too, by which other scenes are shown while their own
    are compiled. Raises UserError for a scene or device that is not there, and where kernels cannot be kept.
    """
    with needs_kernel_cache():
        chosen = choose_device(device)
    _warm_each(sources, reading, str(chosen), lambda scene: warm_up(scene, settings), general=general)


def warm_scenes_for(sources: tuple[str, ...], reading: ImportOptions, settings: RenderSettings,
                    architectures: tuple[int, ...], *, general: bool = False) -> None:  # fmt: skip
    """As `warm_scenes`, for GPUs of these compute capabilities times ten, none of which need be here.

    Raises UserError for a scene that is not there, for a compute capability that the compiler does not know, and where
    kernels cannot be kept.
    """
    with needs_kernel_cache():
        known = wp.get_cuda_supported_archs()
    if unknown := sorted(set(architectures) - set(known)):
        there_are = ", ".join(map(str, known))
        raise UserError(f"--architecture {unknown[0]}: no such compute capability; there are {there_are}")

    def warm(scene: DeviceScene) -> None:
        for architecture in architectures:
            warm_up_for(architecture, scene, settings)

    _warm_each(sources, reading, "cpu", warm, general=general)


def _warm_each(sources: tuple[str, ...], reading: ImportOptions, device: str, warm: Callable[[DeviceScene], None], *,
               general: bool) -> None:  # fmt: skip
    check_kernel_cache(wp.config.kernel_cache_dir)
    for source in sources or tuple(BUILTIN):
        scene = read_scene(source, reading)
        begun = perf_counter()
        device_scene = DeviceScene(scene, device)
        warm(device_scene)
        if general:
            warm(device_scene.generalised())
        print(f"{source}: {perf_counter() - begun:.1f} s", flush=True)
