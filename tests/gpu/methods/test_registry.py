import gc
from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from guards import guarded
from scenes import box, grey, quad, resident_of

from gpu.core.kernel_loading import noted_kernels
from gpu.core.stages import Stages
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.methods import frame_kind, fuzzy_vpl
from gpu.methods.registry import METHODS, method_of
from gpu.renderer import Renderer
from gpu.sample_counts import sample_counts_of
from gpu.scene.camera import look_at
from gpu.scene.types import Floats, Light, LightKind, Material
from gpu.settings import Component, Method, RenderSettings
from gpu.vpl.light_sets import LightSets

CAMERA = look_at((0.0, 0.0, 0.35), (0.0, -0.1, -0.5), yfov_degrees=70.0)
NEXT = look_at((0.01, 0.0, 0.35), (0.0, -0.1, -0.5), yfov_degrees=70.0)
POLISHED = replace(grey(0.5), metallic=1.0, roughness=0.0)
PICTURE_BYTES = 3  # a pixel, of the copy on the host
FUZZY = {"vpls": 1500, "samples": 1}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    return resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])


@pytest.fixture(scope="module")
def room_of_a_bulb() -> DeviceScene:
    """One without soft light."""
    bulb = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.0, 0.3, 0.0))
    return resident_of(box(), [grey(0.7)], lights=[bulb])


def held() -> int:
    """Bytes of all Warp arrays that there are."""
    gc.collect()
    arrays = [thing for thing in gc.get_objects() if isinstance(thing, wp.array) and thing.deleter is not None]
    return sum({array.ptr: array.capacity for array in arrays}.values())


def test_every_method_is_in_the_registry() -> None:
    assert set(METHODS) == set(Method)


@pytest.mark.parametrize("method", list(Method))
def test_stages_have_the_names_that_their_method_tells(room: DeviceScene, method: Method) -> None:
    settings = RenderSettings.model_validate({**FUZZY, "method": method, "sp_clusters": 100, "vpl_clusters": 50})
    with noted_kernels():
        renderer, told = Renderer(room, (48, 36), settings), method_of(settings).stage_names
        for _ in range(2):
            names = list(renderer.render(CAMERA, walks=True).stats.stage_ms)
            assert names == [name for name in [*told, "display"] if name in names]


@pytest.mark.parametrize("method", list(Method))
def test_a_stage_launches_no_kernel_that_its_first_run_did_not(
    room: DeviceScene, method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a graph would be captured while a kernel is loaded, which a GPU refuses."""
    launched: dict[Hashable, set[wp.Kernel]] = {}

    def run(_: Stages, work: Callable[[], None]) -> float:
        kernels.clear()
        work()
        return 0.0

    def note(_: Stages, key: Hashable) -> None:
        assert kernels <= launched.setdefault(key, set(kernels))

    def run_untimed(stages: Stages, work: Callable[[], None], *, branch: Hashable = None) -> None:
        run(stages, work)
        note(stages, branch)

    for name, stand_in in (("_duration", run), ("_note", note), ("run_untimed", run_untimed)):
        monkeypatch.setattr(Stages, name, stand_in)
    settings = RenderSettings.model_validate({**FUZZY, "method": method, "sp_clusters": 16, "vpl_clusters": 16})
    with noted_kernels() as kernels:
        renderer, mean = Renderer(room, (48, 36), settings), Accumulation(48 * 36, room.device)
        for walks in (True, True, True, *[False] * 8, True, True):
            renderer.render(CAMERA, None if walks else mean, walks=walks)
    assert len(launched) > 1


@pytest.mark.parametrize(
    "choice",
    [
        {"method": "path"},
        {"method": "exact-vpl", "vpls": 60, "vpl_clusters": 50},
        {"method": "photon-gather", "photons": 20_000, "sp_clusters": 400, "gather_rays": 64},
        {"sp_clusters": 400, "vpl_clusters": 64},
        {"sp_clusters": 4000, "vpl_clusters": 64},
        {"sp_clusters": 400, "vpl_clusters": 512},
        {"method": "photon-gather", "sp_clusters": 400, "gather_rays": 16, "photons": 64_000},
        {"method": "photon-gather", "sp_clusters": 400, "gather_rays": 16, "photons": 64_000, "cut_nodes": 8192},
    ],
)
def test_memory_is_told_before_it_is_taken(room: DeviceScene, choice: dict[str, Any]) -> None:
    check_memory(room, choice)


def frames(room: DeviceScene, settings: RenderSettings) -> list[Floats]:
    """A walk's frames, and then means of a still view's, the last of which refine."""
    size = (24, 18)
    renderer, mean = Renderer(room, size, settings), Accumulation(size[0] * size[1], room.device)
    pictures = [renderer.render(camera, walks=True).radiance() for camera in (CAMERA, NEXT)]
    return pictures + [renderer.render(NEXT, mean).radiance() for _ in range(3)]


@pytest.mark.parametrize(
    "choice",
    [
        *({"method": method} for method in Method),
        {"component": Component.DIRECT},
        {"component": Component.INDIRECT},
        {"lambertian": True},
    ],
)
def test_general_kernels_show_what_a_scenes_own_show(
    room: DeviceScene, choice: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {"sp_clusters": 40, "vpls": 300, "vpl_clusters": 30, "samples": 1, "photons": 2000, "gather_rays": 16}
    settings = RenderSettings.model_validate({**few, "caustic_photons": 200, **choice})
    soon = replace(frame_kind.STILL_VIEW_PARAMETERS, smoothed_frames=2)
    for module in (frame_kind, fuzzy_vpl):
        monkeypatch.setattr(module, "STILL_VIEW_PARAMETERS", soon)
    # Where surfaces may be glossy, photon-gather reads directions of what it gathers.
    tolerance = 0.05 if settings.method is Method.PHOTON_GATHER else 1e-4
    with guarded(str(room.device)) as arrays:
        pictures = frames(room.generalised(), settings)
    assert arrays.broken == []
    for own, general in zip(frames(room, settings), pictures, strict=True):
        assert own.mean() > 0.0
        assert np.sqrt(np.mean((general - own) ** 2)) < tolerance * own.mean()


def test_a_viewer_takes_less_where_there_is_no_soft_light(room_of_a_bulb: DeviceScene) -> None:
    check_memory(room_of_a_bulb, {"sp_clusters": 400, "vpl_clusters": 64})


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL])
def test_mirrors_and_gloss_take_as_much_more_as_is_told(method: Method) -> None:
    """Of two rooms whose floors differ, before any frame."""
    settings = RenderSettings.model_validate({**FUZZY, "method": method, "sp_clusters": 50})
    plain, polished = (bytes_of_room(floor, settings) for floor in (grey(0.5), POLISHED))
    assert polished[0] - plain[0] == pytest.approx(polished[1] - plain[1], rel=0.05, abs=5000)


def bytes_of_room(floor: Material, settings: RenderSettings) -> tuple[int, int]:
    """What a renderer and a view of a room take, and what is told of them by pixels."""
    size, lamp = (160, 120), quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    room = resident_of([*box(0), lamp], [floor, grey(0.0, 5.0), replace(floor, roughness=0.2)])
    lights = LightSets(room)
    Renderer(room, size, settings, None, lights)  # makes the light sets
    before = held()
    renderer = Renderer(room, size, settings, None, lights)
    view = renderer.new_view()
    method, has = method_of(settings), room.features(lambertian=False)
    caustics = method.caustic_bytes(has, sample_counts_of(settings, room.device))
    return held() - before, sum(method.bytes_a_pixel(has)) * view.pixels + caustics


def check_memory(room: DeviceScene, choice: dict[str, Any]) -> None:
    """A renderer and a view, and then another view, take about as much memory as is told."""
    settings, size = RenderSettings.model_validate({**FUZZY, **choice}), (160, 120)
    light_sets, pixels = LightSets(room), size[0] * size[1]
    Renderer(room, size, settings, None, light_sets)  # makes the light sets
    before = held()
    renderer = Renderer(room, size, settings, None, light_sets)
    first = renderer.new_view()
    with noted_kernels():
        renderer.render(CAMERA, view=first)
    both = held()
    second = renderer.new_view()
    with noted_kernels():
        renderer.render(CAMERA, view=second)
    method, counts = method_of(settings), sample_counts_of(settings, room.device)
    shared, view = method.cluster_bytes(counts)
    a_pixel, a_view_pixel = method.bytes_a_pixel(room.features(lambertian=settings.lambertian))
    view += a_view_pixel * pixels
    assert held() - both == pytest.approx(view, rel=0.1)
    told = a_pixel * pixels + PICTURE_BYTES * pixels + shared + view
    assert both - before == pytest.approx(told, rel=0.15, abs=300_000)  # what the display sums up has one size
    assert first is not second
