from collections.abc import Sequence
from typing import Any

import pytest
import warp as wp
from scenes import box, grey, resident_of

from gpu.core import device as launches
from gpu.device_scene.features import scene_features
from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import direct_light_kernel
from gpu.film.accumulation import Accumulation
from gpu.methods.passes import STILL_VIEW_PARAMETERS
from gpu.renderer import Renderer
from gpu.scene.builtin import BUILTIN
from gpu.settings import RenderSettings
from gpu.warm_up import frame_kernels, warm_up

SETTINGS = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)


def test_frames_launch_nothing_that_was_not_loaded(cpu: str, monkeypatch: pytest.MonkeyPatch) -> None:
    device_scene = DeviceScene(BUILTIN["cornell-box"](), cpu)
    loaded: set[wp.Module] = set()

    def load(_: wp.Device, modules: Sequence[wp.Module] | None = None, **__: int) -> None:
        loaded.update(modules or ())

    with monkeypatch.context() as patch:
        patch.setattr(wp, "force_load", load)
        warm_up(device_scene, SETTINGS)
    launched: set[wp.Kernel] = set()
    run = launches._launch_on_cpu

    def note(kernel: wp.Kernel, *rest: Any) -> None:
        launched.add(kernel)
        run(kernel, *rest)

    monkeypatch.setattr(launches, "_launch_on_cpu", note)
    renderer, mean = Renderer(device_scene, (32, 18), SETTINGS), Accumulation(32 * 18, device_scene.device)
    camera = device_scene.scene.cameras[0]
    for _ in range(3):
        renderer.render(camera, walks=True)
    for _ in range(STILL_VIEW_PARAMETERS.smoothed_frames + 3):
        renderer.render(camera, mean)
    made_for_it = {kernel for kernel in launched if "__locals__" in kernel.key}
    assert len(made_for_it) > 5
    assert {kernel.key for kernel in made_for_it if kernel.module not in loaded} == set()


def test_kernels_of_small_and_of_large_pictures_are_known() -> None:
    device_scene = resident_of(box(), [grey(0.5, emission=1.0)])  # many lamps, of which large pictures learn
    features = scene_features(device_scene.scene, lambertian=False)
    kernels = frame_kernels(device_scene, SETTINGS)
    assert {direct_light_kernel(features, learnt) for learnt in (False, True)} <= kernels
