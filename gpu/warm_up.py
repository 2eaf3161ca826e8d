"""What frames of a scene launch, compiled and loaded before the first of them is wanted."""

from collections.abc import Collection

import warp as wp

from gpu.core.device import BLOCK
from gpu.core.kernel_loading import (
    compile_for,
    compile_later,
    imported_kernels,
    is_compiled,
    load_kernels,
    noted_kernels,
)
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.specialisation import general_of, replace_by_general, restore
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.settings import RenderSettings

# Some kernels are of small pictures alone, and some of large ones; else which are launched does not depend on how many
# there are of anything.
SIZES = (64, 36), (480, 288)
FEW = {"vpls": 256, "vpl_clusters": 16, "sp_clusters": 16, "samples": 1}
WALKED, AVERAGED = 2, 3  # frames: the first of each has no others before it, and means begin with other stages


def frame_kernels(device_scene: DeviceScene, settings: RenderSettings) -> set[wp.Kernel]:
    """What frames of a scene with these settings launch: a little light is traced, then frames are gone through."""
    few, camera = settings.model_copy(update=FEW), device_scene.scene.cameras[0]
    launched = set[wp.Kernel]()
    for width, height in SIZES:
        renderer = Renderer(device_scene, (width, height), few)
        mean = Accumulation(width * height, device_scene.device)
        with DEVICE_SHARING.keep(), noted_kernels() as kernels:  # else what others launch would be noted, not run
            for _ in range(WALKED):
                renderer.render(camera, walks=True)
            for _ in range(AVERAGED):
                renderer.render(camera, mean)
        launched |= kernels
    return launched


def block_of(device_scene: DeviceScene) -> int:
    """Threads of a block on a scene's device."""
    return BLOCK if device_scene.device.is_cuda else 1


class LateKernels:
    """Kernels that are being compiled, while general ones are launched in their place."""

    def __init__(self, kernels: Collection[wp.Kernel], device: wp.Device, block: int) -> None:
        self._kernels, self._device, self._block = kernels, device, block
        replace_by_general(kernels)
        self._builds = compile_later(kernels, device, block)

    @property
    def compiled(self) -> bool:
        """Whether no compiler is at work any more."""
        return all(build.done() for build in self._builds)

    def settle(self) -> None:
        """Load them, and have them launched by renderers that are made from now on.

        Where a compiler failed, this raises what Warp did, and general ones go on in their place.
        """
        for build in self._builds:
            build.result()
        load_kernels(self._kernels, self._device, self._block)
        restore(self._kernels)


def warm_up(device_scene: DeviceScene, settings: RenderSettings) -> LateKernels | None:
    """Load the kernels of a scene with these settings, side by side; those in Warp's cache are not compiled again.

    Those that the cache lacks, but has general ones for, as `compile_ahead` leaves them there, are compiled meanwhile.
    """
    device, block = device_scene.device, block_of(device_scene)
    load_kernels(imported_kernels(), device, block)
    kernels = frame_kernels(device_scene, settings)
    missing = {kernel: general_of(kernel) for kernel in kernels if not is_compiled(kernel, device, block)}
    stand_ins = {
        kernel: general for kernel, general in missing.items() if general and is_compiled(general, device, block)
    }
    load_kernels((kernels - stand_ins.keys()).union(stand_ins.values()), device, block)
    return LateKernels(stand_ins.keys(), device, block) if stand_ins else None


def compile_ahead(
    device_scene: DeviceScene, settings: RenderSettings, *, general: bool, architecture: int | None = None
) -> None:
    """Compile what frames of a scene launch with these settings into Warp's cache.

    general: with the general kernels of it, which other scenes begin with; architecture: for GPUs of this compute
    capability times ten, wherever the scene is; None: for its device.
    """
    kernels = {*imported_kernels(), *frame_kernels(device_scene, settings)}
    if general:
        kernels |= {stand_in for kernel in kernels if (stand_in := general_of(kernel)) is not None}
    if architecture is not None:
        compile_for(kernels, architecture, BLOCK)
    else:
        load_kernels(kernels, device_scene.device, block_of(device_scene))
