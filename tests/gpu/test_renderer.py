from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

import numpy as np
import pytest
from greenlet import getcurrent, greenlet
from pictures import CAMERA, QUALITY, SIZE, lamp_room, picture
from scenes import box, grey, quad, resident_of

from gpu.core.lane import Lane
from gpu.core.sharing import DEVICE_SHARING
from gpu.device_scene.upload import DeviceScene
from gpu.errors import UserError
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera, Light, LightKind, Sky
from gpu.settings import Component, Method, RenderSettings, Skips
from gpu.vpl.light_sets import LightSets


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def test_the_whole_is_the_sum_of_direct_and_indirect(room: DeviceScene) -> None:
    full, direct, indirect = (picture(room, component=component) for component in Component)
    assert np.allclose(full, direct + indirect, rtol=1e-5, atol=1e-6)
    assert direct.mean() > 0.0
    assert indirect.mean() > 0.0


@pytest.mark.parametrize("method", list(Method))
def test_the_same_seed_gives_the_same_bits_and_another_does_not(room: DeviceScene, method: Method) -> None:
    settings = {"method": method, "samples": 2, "component": Component.INDIRECT}
    renderer = Renderer(room, SIZE, RenderSettings(**QUALITY, **settings, skip=Skips(unchanged_camera=False)))
    first, second = renderer.render(CAMERA).radiance(), renderer.render(CAMERA).radiance()
    assert first.tobytes() == second.tobytes() == picture(room, **settings).tobytes()
    assert first.tobytes() != picture(room, **settings, seed=1).tobytes()


def test_a_frame_tells_what_it_did_and_what_it_skipped(room: DeviceScene) -> None:
    stats = Renderer(room, SIZE, RenderSettings(**QUALITY)).render(CAMERA).stats
    assert [name for name in stats.stage_ms if name in ("gbuffer", "shade", "direct", "near")] == [
        *("gbuffer", "shade", "direct", "near")
    ]
    assert stats.counts["pixels"] == SIZE[0] * SIZE[1]
    assert stats.counts["nonfinite"] == stats.counts["unassigned"] == 0
    assert stats.counts["rays"] > 0
    assert stats.skips["facing_away"] > 0
    assert stats.skips["shared_weak_rays"] > 0
    pairs = stats.counts["sp_clusters"] * stats.counts["vpl_clusters"]
    # What is left are pairs of SP clusters without members.
    assert 0.7 * pairs < stats.counts["rays"] + stats.skips["facing_away"] + stats.skips["shared_weak_rays"] <= pairs


def test_pixels_come_with_a_frame_where_they_are_wanted(room: DeviceScene) -> None:
    settings = RenderSettings(method=Method.PATH, samples=1)
    wanted = Renderer(room, SIZE, settings).render(CAMERA).pixels()
    frame = Renderer(room, SIZE, settings, downloads=True).render(CAMERA)
    frame.device_pixels.zero_()
    assert wanted.any()
    assert np.array_equal(frame.pixels(), wanted)


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL, Method.PATH])
def test_a_light_that_reaches_nothing_leaves_the_picture_black(method: Method) -> None:
    away = Light("away", LightKind.SPOT, (5.0, 5.0, 5.0), (0.0, 0.0, 2.0), (0.0, 0.0, 1.0), 0.99, 0.9)
    device_scene = resident_of(box(), [grey(0.5)], lights=[away])
    frame = Renderer(device_scene, SIZE, RenderSettings(method=method, samples=2, **QUALITY)).render(CAMERA)
    assert (frame.radiance() == 0.0).all()
    assert frame.stats.counts["nonfinite"] == 0


def test_a_sky_lights_an_open_floor_and_is_seen() -> None:
    floor = quad((-0.5, -0.2, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    wall = quad((-0.5, -0.2, -0.5), (1.0, 0.0, 0.0), (0.0, 0.3, 0.0))
    device_scene = resident_of([floor, wall], [grey(0.5)], sky=Sky((1.0, 2.0, 3.0)))
    frame = Renderer(device_scene, SIZE, RenderSettings(**QUALITY)).render(CAMERA)
    radiance = frame.radiance()
    assert np.isfinite(radiance).all()
    assert radiance[0, SIZE[0] // 2] == pytest.approx(np.array([1.0, 2.0, 3.0]) * radiance[0, SIZE[0] // 2, 0])
    assert (radiance[-1] > 0.0).all()
    assert frame.stats.counts["empty"] > 0


@pytest.mark.parametrize(
    "settings",
    [
        {"sp_clusters": 1, "vpl_clusters": 1, "vpls": 1},
        {"sp_clusters": 100_000, "vpl_clusters": 500, "vpls": 300},
        {"fuzziness": 8, "bounces": 16},
        {"bounces": 1},
    ],
)
def test_extreme_counts_render(room: DeviceScene, settings: dict[str, int]) -> None:
    frame = Renderer(room, SIZE, RenderSettings(**{**QUALITY, **settings})).render(CAMERA)
    assert np.isfinite(frame.radiance()).all()
    assert frame.stats.counts["unassigned"] == 0


def test_a_single_pixel_renders(room: DeviceScene) -> None:
    frame = Renderer(room, (1, 1), RenderSettings(**QUALITY)).render(CAMERA)
    assert frame.pixels().shape == (1, 1, 3)
    assert np.isfinite(frame.radiance()).all()


@pytest.mark.parametrize("size", [(0, 10), (10, 100_000)])
def test_an_impossible_size_is_refused(room: DeviceScene, size: tuple[int, int]) -> None:
    with pytest.raises(UserError, match="size"):
        Renderer(room, size, RenderSettings())


def test_renderers_of_a_scene_share_its_light_sets(room: DeviceScene) -> None:
    reports: list[str] = []
    settings, light_sets = RenderSettings(**QUALITY, seed=99), LightSets(room)
    Renderer(room, SIZE, settings, lambda what, fraction: reports.append(what), light_sets)
    first = len(reports)
    Renderer(room, (8, 8), settings, lambda what, fraction: reports.append(what), light_sets)
    assert first > 0
    assert len(reports) == first


class SlowFlight:
    """Over when it has been looked at some times."""

    def __init__(self) -> None:
        self.looks, self.waited = 0, False

    def is_over(self) -> bool:
        self.looks += 1
        return self.looks > 3

    def wait(self) -> None:
        self.waited = True


class SlowLane(Lane):
    """Of a CPU, where frames seem to be on their way for a while."""

    flights: ClassVar[list[SlowFlight]] = []

    def flight(self) -> Any:
        SlowLane.flights.append(SlowFlight())
        return SlowLane.flights[-1]


class Jobs:
    """Frames of several renderers, each in a greenlet: the host leaves one for the next."""

    def __init__(self) -> None:
        self.most, self._left = 0, list[greenlet]()

    def due(self, *, idle: bool = False) -> bool:
        return False

    def give(self) -> None:
        raise AssertionError("nobody asked")

    def leave_until(self, over: Callable[[], bool], *, idle: bool = False) -> None:
        self.most = max(self.most, DEVICE_SHARING.in_flight)
        while not over():
            self._left.append(getcurrent())
            getcurrent().parent.switch()

    def run(self, works: list[Callable[[], None]]) -> None:
        DEVICE_SHARING.begin(self)
        try:
            for work in works:
                greenlet(work).switch()
            while self._left:
                self._left.pop(0).switch()
        finally:
            DEVICE_SHARING.begin(None)


def test_frames_in_several_lanes_are_those_of_each_alone(room: DeviceScene) -> None:
    device, settings, light_sets = room.device, RenderSettings(**QUALITY), LightSets(room)
    walks = [[rotated(CAMERA, 40.0 * walker + 2.0 * step) for step in range(3)] for walker in range(3)]

    def renderer() -> Renderer:
        return Renderer(room, SIZE, settings, None, light_sets, SlowLane(device))

    def walk(own: Renderer, cameras: list[Camera], pictures: list[bytes]) -> None:
        view = own.new_view()
        pictures += [own.render(camera, view=view, walks=True).radiance().tobytes() for camera in cameras]

    alone, together = ([list[bytes]() for _ in walks] for _ in range(2))
    for cameras, pictures in zip(walks, alone, strict=True):
        walk(renderer(), cameras, pictures)
    jobs = Jobs()
    jobs.run([partial(walk, renderer(), *one) for one in zip(walks, together, strict=True)])
    assert jobs.most == len(walks)
    assert together == alone
    assert all(flight.waited for flight in SlowLane.flights)


def test_a_frame_for_a_wanted_time_leaves_the_host_to_nobody(room: DeviceScene) -> None:
    renderer, jobs = Renderer(room, SIZE, RenderSettings(**QUALITY), None, None, SlowLane(room.device)), Jobs()
    jobs.run([partial(renderer.render, CAMERA)])
    assert jobs.most == 1
    renderer._settings = RenderSettings(target_ms=1000.0)  # its method is not asked for it
    jobs.most = 0
    jobs.run([partial(renderer.render, CAMERA)])
    assert jobs.most == 0


def test_a_frame_is_as_long_as_what_it_launched_and_its_share_of_the_device(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not as long as others kept the host from it; a stepwise one waits for each stage itself."""
    renderer = Renderer(room, SIZE, RenderSettings(**QUALITY))
    for number in range(2):
        renderer.render(rotated(CAMERA, number))
    monkeypatch.setattr(renderer, "_wait", lambda: 4)
    monkeypatch.setattr(type(renderer._stages), "milliseconds", lambda stages: {"shade": 4e6})
    renderer.render(rotated(CAMERA, 2.0))
    assert renderer._long_seconds < 1000.0
    launch = renderer._launch

    def quickly(*of: Any) -> Any:
        launched = launch(*of)
        renderer._stages.stepwise = False
        return launched

    monkeypatch.setattr(renderer, "_launch", quickly)
    renderer.render(rotated(CAMERA, 3.0))
    assert 1000.0 <= renderer._long_seconds < 2000.0
