from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from secrets import randbits
from time import sleep
from typing import Any

import pytest
import warp as wp
from scenes import box, grey, resident_of

import gpu.warm_up as module
from gpu.core import device as launches
from gpu.core.device import BLOCK
from gpu.core.kernel_loading import is_compiled, load_kernels
from gpu.device_scene.features import EVERYTHING, SceneFeatures, scene_features
from gpu.device_scene.specialisation import made_for
from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import direct_light_kernel
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.builtin import BUILTIN
from gpu.settings import RenderSettings
from gpu.warm_up import compile_ahead, frame_kernels, warm_up

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
    for _ in range(4):
        renderer.render(camera, mean)
    made_for_it = {kernel for kernel in launched if "__locals__" in kernel.key}
    assert len(made_for_it) > 5
    assert {kernel.key for kernel in made_for_it if kernel.module not in loaded} == set()


def test_kernels_of_small_and_of_large_pictures_are_known() -> None:
    device_scene = resident_of(box(), [grey(0.5, emission=1.0)])  # many lamps, of which large pictures learn
    features = scene_features(device_scene.scene, lambertian=False)
    kernels = frame_kernels(device_scene, SETTINGS)
    assert {direct_light_kernel(features, learnt) for learnt in (False, True)} <= kernels


def kernels_of_two_numbers() -> tuple[wp.Kernel, wp.Kernel, Callable[[], wp.Kernel]]:
    """Kernels that no cache has, for scenes without masks and for all, and what is launched for those without."""
    number = wp.constant(randbits(30))

    @made_for("masks")
    def number_kernel(features: SceneFeatures) -> wp.Kernel:
        @wp.kernel(module="unique")
        def number_kernel(first: int, out: wp.array[int]) -> None:
            out[0] = number + wp.where(wp.static(features.masks), 1, 0)

        return number_kernel

    plain = replace(EVERYTHING, masks=False)
    return number_kernel(plain), number_kernel(EVERYTHING), lambda: number_kernel(plain)


@pytest.fixture
def cached(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """An empty folder of kernels."""
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    monkeypatch.setattr(module, "imported_kernels", list)
    return tmp_path


def test_general_kernels_stand_in_for_those_that_are_compiled_meanwhile(
    cached: Path, cpu: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, general, launched = kernels_of_two_numbers()
    alone, _, launched_alone = kernels_of_two_numbers()
    monkeypatch.setattr(module, "frame_kernels", lambda *_: {own, alone})
    device_scene = DeviceScene(BUILTIN["cornell-box"](), cpu)
    load_kernels([general], device_scene.device, 1)  # as `compile_ahead` leaves it
    late = warm_up(device_scene, SETTINGS)
    assert late is not None
    assert launched() is general
    assert launched_alone() is alone  # which nothing can stand in for
    assert is_compiled(alone, device_scene.device, 1)
    while not late.compiled:
        sleep(0.01)
    late.settle()
    assert launched() is own
    assert warm_up(device_scene, SETTINGS) is None


def test_without_a_general_kernel_the_own_one_is_waited_for(
    cached: Path, cpu: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, _, launched = kernels_of_two_numbers()
    monkeypatch.setattr(module, "frame_kernels", lambda *_: {own})
    device_scene = DeviceScene(BUILTIN["cornell-box"](), cpu)
    assert warm_up(device_scene, SETTINGS) is None
    assert launched() is own
    assert is_compiled(own, device_scene.device, 1)


@pytest.mark.parametrize(("architecture", "ending"), [(None, ".o"), (90, ".sm90.cubin")])
def test_general_kernels_are_compiled_ahead_where_that_is_asked_for(
    cached: Path, cpu: str, monkeypatch: pytest.MonkeyPatch, architecture: int | None, ending: str
) -> None:
    own, general, _ = kernels_of_two_numbers()
    monkeypatch.setattr(module, "frame_kernels", lambda *_: {own})
    device_scene = DeviceScene(BUILTIN["cornell-box"](), cpu)

    def names() -> set[str]:
        return {file.parent.name for file in cached.rglob(f"*{ending}")}

    compile_ahead(device_scene, SETTINGS, general=False, architecture=architecture)
    block = 1 if architecture is None else BLOCK
    assert names() == {own.module.get_module_identifier(block)}
    compile_ahead(device_scene, SETTINGS, general=True, architecture=architecture)
    assert names() == {kernel.module.get_module_identifier(block) for kernel in (own, general)}
