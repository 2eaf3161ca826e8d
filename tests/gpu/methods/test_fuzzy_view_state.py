"""Viewers of one renderer: what a walk leaves behind is each viewer's own."""

import gc
from typing import Any
from weakref import ref

import numpy as np
import pytest
from devices import DEVICES
from scenes import box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.scene.camera import look_at, rotated
from gpu.scene.types import Camera
from gpu.settings import Component, RenderSettings
from gpu.vpl.light_sets import LightSets

SIZE = (32, 24)
CAMERA = look_at((0.0, 0.0, 0.35), (0.0, -0.1, -0.5), yfov_degrees=70.0)
COUNTS = {"sp_clusters": 150, "vpls": 800, "vpl_clusters": 64}
FRAMES = 4
CHOICES: list[dict[str, Any]] = [
    COUNTS,
    {**COUNTS, "component": Component.INDIRECT, "smooth": False},
    {**COUNTS, "method": "exact-vpl", "vpls": 150},
    {"method": "path", "samples": 1},
    {"target_error": 2e-2, "vpls": 400},
]


@pytest.fixture(scope="module", params=DEVICES)
def room(request: pytest.FixtureRequest) -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)], device=request.param)


def path(walker: int, frame: int) -> Camera:
    """Two walkers look 75° apart, and turn; the second rests now and then."""
    return rotated(CAMERA, 75.0 * walker + 1.5 * (frame if walker == 0 else frame // 2))


def bits(frame: Frame) -> bytes:
    return frame.radiance().tobytes() + frame.pixels().tobytes()


def frame_of(renderer: Renderer, view: ViewState | None, walker: int, number: int) -> Frame:
    return renderer.render(path(walker, number), view=view, walks=True)


@pytest.mark.parametrize("choice", CHOICES)
def test_two_walkers_see_what_each_sees_alone(room: DeviceScene, choice: dict[str, Any]) -> None:
    settings, light_sets = RenderSettings.model_validate(choice), LightSets(room)
    alone = [
        [bits(frame_of(renderer, None, walker, number)) for number in range(FRAMES)]
        for walker in range(2)
        for renderer in [Renderer(room, SIZE, settings, None, light_sets)]
    ]
    renderer = Renderer(room, SIZE, settings, None, light_sets)
    views = [renderer.new_view(), renderer.new_view()]
    for number in range(FRAMES):
        for walker in range(2):
            assert bits(frame_of(renderer, views[walker], walker, number)) == alone[walker][number], (walker, number)


def test_a_walker_beside_another_keeps_clusters_and_light(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, RenderSettings.model_validate(COUNTS))
    views = [renderer.new_view(), renderer.new_view()]
    for number in range(FRAMES - 1):
        stats = [frame_of(renderer, views[walker], walker, number).stats for walker in range(2)]
    for walker in stats:
        assert walker.skips["kept_clusters"] > 0.5 * COUNTS["sp_clusters"] * COUNTS["vpl_clusters"]
        assert walker.skips["temporal_reuse"] > 0.5 * walker.counts["shaded"]


def test_a_view_that_rests_beside_a_walker_becomes_what_it_is_alone(room: DeviceScene) -> None:
    settings, pixels = RenderSettings.model_validate(COUNTS), SIZE[0] * SIZE[1]

    def still(renderer: Renderer, disturbed: bool) -> bytes:
        view, walker, mean = renderer.new_view(), renderer.new_view(), Accumulation(pixels, room.device)
        for number in range(7):
            frame = bits(renderer.render(CAMERA, mean, view=view))
            if disturbed:
                frame_of(renderer, walker, 1, number)
        return frame

    light_sets = LightSets(room)
    assert still(Renderer(room, SIZE, settings, None, light_sets), True) == still(
        Renderer(room, SIZE, settings, None, light_sets), False
    )


def test_what_a_viewer_leaves_is_freed_with_it(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, RenderSettings.model_validate(COUNTS))
    view = renderer.new_view()
    for number in range(3):
        frame_of(renderer, view, 0, number)
    number, gone = view.number, ref(view)
    held = ref(next(iter(view.lights.values())))
    del view
    gc.collect()
    assert gone() is None
    assert held() is None
    assert not any(number in key[2] for key in renderer._stages._graphs)
    assert np.isfinite(frame_of(renderer, None, 0, 0).radiance()).all()


@pytest.mark.parametrize(
    ("changes", "antialiases"),
    [
        ({}, True),
        ({"antialias": False}, False),
        ({"smooth": False}, False),
        ({"skip": {"temporal_reuse": False}}, False),
        ({"target_error": 2e-3, "sp_clusters": None, "vpl_clusters": None}, False),
    ],
)
def test_pictures_of_a_walk_are_averaged_where_frames_leave_something_to_the_next(
    room: DeviceScene, changes: dict[str, Any], antialiases: bool
) -> None:
    renderer = Renderer(room, SIZE, RenderSettings.model_validate(COUNTS | changes))
    for number in range(2):
        stages = frame_of(renderer, None, 0, number).stats.stage_ms
        assert ("antialias" in stages) == antialiases
    place = renderer._own_view.camera.numpy()[0]
    assert ((place["x"], place["y"]) == (0.5, 0.5)) != antialiases
