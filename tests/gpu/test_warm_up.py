from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, quad, resident_of

import gpu.warm_up as module
from gpu.core import device as launches
from gpu.core.radix_sort import iota_kernel
from gpu.correction.bias_compensation import bias_compensation_kernel
from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import direct_light_kernel
from gpu.film.accumulation import Accumulation
from gpu.lights.light_paths import light_path_kernel
from gpu.methods.frame_kind import STILL_VIEW_PARAMETERS
from gpu.renderer import Renderer
from gpu.scene.builtin import BUILTIN
from gpu.scene.types import Environment, Sky
from gpu.settings import RenderSettings
from gpu.warm_up import (
    AVERAGED,
    compile_soon,
    frame_kernels,
    load_kept_kernels,
    warm_up,
    warm_up_for,
    warm_up_soon,
    warm_up_still,
)

SETTINGS = RenderSettings(sp_clusters=16, vpls=256, vpl_clusters=16)


@pytest.mark.parametrize("still", [False, True])
def test_frames_launch_nothing_that_was_not_loaded(cpu: str, monkeypatch: pytest.MonkeyPatch, *, still: bool) -> None:
    device_scene = DeviceScene(BUILTIN["cornell-box"](), cpu)
    loaded: set[wp.Module] = set()

    def load(_: wp.Device, modules: Sequence[wp.Module] | None = None, **__: int) -> None:
        loaded.update(modules or ())

    with monkeypatch.context() as patch:
        patch.setattr(wp, "force_load", load)
        if still:
            warm_up_still(device_scene, SETTINGS, 100)
        else:
            warm_up(device_scene, SETTINGS)
    launched: set[wp.Kernel] = set()
    run = launches._launch_on_cpu

    def note(kernel: wp.Kernel, *rest: Any) -> None:
        launched.add(kernel)
        run(kernel, *rest)

    monkeypatch.setattr(launches, "_launch_on_cpu", note)
    renderer, mean = Renderer(device_scene, (32, 18), SETTINGS), Accumulation(32 * 18, device_scene.device)
    camera = device_scene.scene.cameras[0]
    for _ in range(0 if still else 3):
        renderer.render(camera, walks=True)
    for _ in range(STILL_VIEW_PARAMETERS.smoothed_frames + 3):
        renderer.render(camera, mean)
    made_for_it = {kernel for kernel in launched if "__locals__" in kernel.key}
    assert len(made_for_it) > 5
    assert {kernel.key for kernel in made_for_it if kernel.module not in loaded} == set()


def test_what_is_kept_is_loaded_before_there_is_a_scene_and_nothing_compiled(
    cpu: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = list[object]()
    monkeypatch.setattr(module, "load_scene_kernels", loaded.append)
    monkeypatch.setattr(module, "is_compiled", lambda kernel, *_: kernel is iota_kernel)
    monkeypatch.setattr(module, "load_kernels", lambda kernels, *_: loaded.extend(kernels))
    load_kept_kernels(wp.get_device(cpu))
    assert list(dict.fromkeys(loaded)) == [cpu, iota_kernel]


def test_one_frame_takes_fewer_kernels_than_a_mean_of_many_and_a_walk(
    cpu: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    device_scene, loaded = DeviceScene(BUILTIN["cornell-box"](), cpu), list[set[str]]()
    monkeypatch.setattr(module, "load_kernels", lambda kernels, *_: loaded.append({kernel.key for kernel in kernels}))
    warm_up_still(device_scene, SETTINGS, 1)
    warm_up_still(device_scene, SETTINGS, 100)
    warm_up(device_scene, SETTINGS)
    assert loaded[0] < loaded[1] < loaded[2]


def test_kernels_of_small_and_of_large_pictures_are_known() -> None:
    device_scene = resident_of(box(), [grey(0.5, emission=1.0)])  # many lamps, of which large pictures learn
    features = device_scene.features(lambertian=False)
    kernels = frame_kernels(device_scene, SETTINGS)
    assert {direct_light_kernel(features, learnt) for learnt in (False, True)} <= kernels


def test_kernels_that_make_light_are_known_before_any_is_launched(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else each would be compiled when light is traced, while a viewer waits for the first picture."""
    device_scene, launched = resident_of(box(), [grey(0.5, emission=1.0)]), list[str]()
    features = device_scene.features(lambertian=False)
    monkeypatch.setattr(launches, "_launch_on_cpu", lambda kernel, *_: launched.append(kernel.key))
    kernels = frame_kernels(device_scene, SETTINGS)
    assert light_path_kernel(features, False) in kernels
    assert not launched


def test_kernels_compiled_for_gpus_are_those_of_gpus(cpu: str, monkeypatch: pytest.MonkeyPatch) -> None:
    device_scene, compiled = DeviceScene(BUILTIN["cornell-box"](), cpu), set[wp.Kernel]()
    monkeypatch.setattr(module, "compile_for", lambda kernels, *_: compiled.update(kernels))
    warm_up_for(90, device_scene, SETTINGS)
    there, here = (scene.features(lambertian=False) for scene in (device_scene.as_on_gpus(), device_scene))
    assert direct_light_kernel(there, False) in compiled
    assert direct_light_kernel(here, False) not in compiled


def test_what_takes_longest_to_compile_is_not_launched_by_the_first_frames() -> None:
    device_scene = DeviceScene(BUILTIN["cornell-box"](), "cpu").as_on_gpus()
    all_, first = (
        frame_kernels(device_scene, SETTINGS, averaged=averaged)
        for averaged in (AVERAGED, STILL_VIEW_PARAMETERS.smoothed_frames)
    )
    assert first < all_
    assert bias_compensation_kernel(device_scene.features(lambertian=False)) in all_ - first


def test_a_scene_that_sends_no_light_on_has_kernels() -> None:
    unlit = resident_of(box(), [replace(grey(0.5), unlit=True)], sky=Sky((1.0, 1.0, 1.0)))
    assert len(frame_kernels(unlit, SETTINGS)) > 20


def test_general_kernels_of_one_scene_are_those_of_all() -> None:
    """So those that were compiled for some scenes stand in for the own ones of any other."""
    glass, sky = replace(grey(0.5), transmission=1.0, roughness=0.0), Environment("sky", np.ones((2, 4, 3), np.float32))
    pane = quad((-0.2, 0.0, 0.0), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0), 1)
    rich = resident_of([*box(), pane], [grey(0.5, emission=1.0), glass], sky=sky).generalised()
    plain = resident_of(box(), [grey(0.5, emission=1.0)])
    known, general, own = (frame_kernels(scene, SETTINGS) for scene in (rich, plain.generalised(), plain))
    assert {kernel.key for kernel in general - known if "__locals__" in kernel.key} == set()
    assert {kernel.key for kernel in own - known if "__locals__" in kernel.key} != set()


@pytest.mark.parametrize(
    ("own", "general", "beside", "stands_in"),
    [
        (False, True, True, True),
        (True, True, True, False),
        (False, False, True, False),
        (False, True, False, False),
    ],
)
def test_general_kernels_stand_in_where_they_are_compiled_and_own_ones_are_not(
    cpu: str, monkeypatch: pytest.MonkeyPatch, *, own: bool, general: bool, beside: bool, stands_in: bool
) -> None:
    device_scene = DeviceScene(BUILTIN["cornell-box"](), cpu)
    compiled = {"common", "refining", *(["own"] * own), *(["general"] * general)}
    loaded, late = list[str](), list[str]()

    def kernels(scene: DeviceScene, _: RenderSettings, averaged: int = AVERAGED) -> set[str]:
        kernels = {"common", "general" if scene.general else "own"}
        return kernels if averaged < AVERAGED else {*kernels, "refining"}

    monkeypatch.setattr(module, "compiles_beside", lambda _: beside)
    monkeypatch.setattr(module, "is_compiled", lambda kernel, *_: kernel in compiled)
    monkeypatch.setattr(module, "imported_kernels", list)
    monkeypatch.setattr(module, "frame_kernels", kernels)
    monkeypatch.setattr(module, "load_kernels", lambda kernels, *_: loaded.extend(kernels))
    monkeypatch.setattr(module, "LateKernels", lambda kernels, *_: late.extend(kernels) or "late")
    assert warm_up_soon(device_scene, SETTINGS) == ("late" if stands_in else None)
    waits = beside and not (own or general)
    assert set(loaded) == {"common", "general" if stands_in else "own", *(["refining"] * (not waits))}
    assert late == ["own"] * stands_in + ["refining"] * waits


@pytest.mark.parametrize(
    ("own", "general", "beside", "compiles"),
    [(False, False, True, True), (False, True, True, False), (True, False, True, False), (False, True, False, True)],
)
def test_what_first_frames_lack_is_compiled_from_now_on(
    cpu: str, monkeypatch: pytest.MonkeyPatch, *, own: bool, general: bool, beside: bool, compiles: bool
) -> None:
    compiled = {"common", *(["own"] * own), *(["general"] * general)}
    late = list[str]()

    def kernels(scene: DeviceScene, _: RenderSettings, averaged: int = AVERAGED) -> set[str]:
        return {"common", "general" if scene.general else "own", *(["refining"] * (averaged == AVERAGED))}

    monkeypatch.setattr(module, "compiles_beside", lambda _: beside)
    monkeypatch.setattr(module, "is_compiled", lambda kernel, *_: kernel in compiled | {"refining"})
    monkeypatch.setattr(module, "frame_kernels", kernels)
    monkeypatch.setattr(module, "LateKernels", lambda kernels, *_, after: late.extend(kernels) or f"after {after}")
    found = compile_soon(DeviceScene(BUILTIN["cornell-box"](), cpu), SETTINGS)
    assert found == ("after 0.0" if compiles else None)
    assert set(late) == ({"common", "own"} if compiles else set())
