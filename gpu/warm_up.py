"""What frames of a scene launch, compiled and loaded before the first of them is wanted."""

import warp as wp

from gpu.core.device import BLOCK, block_of
from gpu.core.kernel_loading import (
    LateKernels,
    compile_for,
    imported_kernels,
    is_compiled,
    load_kernels,
    noted_kernels,
)
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.upload import DeviceScene, load_scene_kernels
from gpu.film.accumulation import Accumulation
from gpu.methods.frame_kind import STILL_VIEW_PARAMETERS
from gpu.renderer import Renderer
from gpu.settings import RenderSettings

# Some kernels are of small pictures alone, and some of large ones; else which are launched does not depend on how many
# there are of anything.
SIZES = (64, 36), (480, 288)
FEW = {"vpls": 256, "vpl_clusters": 16, "sp_clusters": 16, "samples": 1}
# Frames: the first of each has no others before it, and what refines a mean begins after those that are smoothed.
WALKED, AVERAGED = 2, STILL_VIEW_PARAMETERS.smoothed_frames + 2


def frame_kernels(
    device_scene: DeviceScene, settings: RenderSettings, *, walked: int = WALKED, averaged: int = AVERAGED
) -> set[wp.Kernel]:
    """What frames of a scene with these settings launch, and the making of its light: both are gone through.

    walked, averaged: frames of a camera that moves, and of one that does not.
    """
    few, camera = settings.model_copy(update=FEW), device_scene.scene.cameras[0]
    launched = set[wp.Kernel]()
    for width, height in SIZES:
        mean = Accumulation(width * height, device_scene.device)
        with DEVICE_SHARING.keep(), noted_kernels() as kernels:  # else what others launch would be noted, not run
            renderer = Renderer(device_scene, (width, height), few)
            for _ in range(walked):
                renderer.render(camera, walks=True)
            for _ in range(averaged):
                renderer.render(camera, mean)
        launched |= kernels
    return launched


def load_kept_kernels(device: wp.Device) -> None:
    """Load what scenes take, then what Warp's cache has of all else that was imported: before there is a scene."""
    load_scene_kernels(str(device))
    block = block_of(device)
    load_kernels([kernel for kernel in imported_kernels() if is_compiled(kernel, device, block)], device, block)


def warm_up(device_scene: DeviceScene, settings: RenderSettings) -> None:
    """Load the kernels of a scene with these settings, side by side; those in Warp's cache are not compiled again."""
    device = device_scene.device
    load_kernels([*frame_kernels(device_scene, settings), *imported_kernels()], device, block_of(device))


def warm_up_still(device_scene: DeviceScene, settings: RenderSettings, frames: int) -> None:
    """As `warm_up`, for pictures of cameras that stay where they are, means of so many `frames`: what no frame of these
    launches is left out.
    """
    device = device_scene.device
    kernels = frame_kernels(device_scene, settings, walked=0, averaged=min(frames, AVERAGED))
    load_kernels(kernels, device, block_of(device))


def warm_up_for(architecture: int, device_scene: DeviceScene, settings: RenderSettings) -> None:
    """Compile what `warm_up` would load on GPUs of this compute capability times ten, wherever the scene is."""
    compile_for([*imported_kernels(), *frame_kernels(device_scene.as_on_gpus(), settings)], architecture, BLOCK)


def compiles_beside(device: wp.Device) -> bool:
    """Whether frames go on while kernels are compiled: on a CPU compilers would have the cores that frames need."""
    return bool(device.is_cuda)


def _are_kept(kernels: set[wp.Kernel], device: wp.Device) -> bool:
    """Whether Warp's cache has them all."""
    return all(is_compiled(kernel, device, block_of(device)) for kernel in kernels)


def compile_soon(device_scene: DeviceScene, settings: RenderSettings) -> LateKernels | None:
    """What is compiled from now on for the first frames of a scene, which `warm_up_soon` would wait for; None where
    Warp's cache has it, or general kernels that stand in.
    """
    device = device_scene.device
    own = frame_kernels(device_scene, settings, averaged=STILL_VIEW_PARAMETERS.smoothed_frames)
    if _are_kept(own, device):
        return None
    if compiles_beside(device):
        general = frame_kernels(device_scene.generalised(), settings)
        if _are_kept(general, device):
            return None
    return LateKernels(own, device, block_of(device), after=0.0)


def warm_up_soon(device_scene: DeviceScene, settings: RenderSettings) -> LateKernels | None:
    """As `warm_up`, but where Warp's cache lacks some of the scene's own kernels, and has all general ones of it, load
    those, and return what is compiled meanwhile: until that is there, `device_scene.generalised()` is to be rendered.
    Where it lacks both, load what cameras that move and the first frames at rest launch; what refines a mean, of which
    two kernels take longest of all, is compiled beside, and loaded by the first frame that launches it.
    """
    device, block = device_scene.device, block_of(device_scene.device)
    own = first = frame_kernels(device_scene, settings)
    if compiles_beside(device) and not _are_kept(own, device):
        general = frame_kernels(device_scene.generalised(), settings)
        if _are_kept(general, device):
            load_kernels([*general, *imported_kernels()], device, block)
            return LateKernels(own - general, device, block)
        first = frame_kernels(device_scene, settings, averaged=STILL_VIEW_PARAMETERS.smoothed_frames)
        LateKernels(own - first, device, block)
    load_kernels([*first, *imported_kernels()], device, block)
    return None
