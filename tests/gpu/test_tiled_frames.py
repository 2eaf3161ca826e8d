from dataclasses import replace

import numpy as np
import pytest
from pictures import CAMERA, QUALITY, SIZE, lamp_room, relative_error
from scenes import box, grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.film.frame import Frame
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.scene.camera import look_at, rotated
from gpu.scene.types import Camera
from gpu.settings import Component, Method, RenderSettings, Skips
from gpu.tiled_frames import TiledFrames
from gpu.vpl.light_sets import LightSets

TILES = 3


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


@pytest.fixture(scope="module")
def light_sets(room: DeviceScene) -> LightSets:
    return LightSets(room)


def camera(viewer: int, number: int) -> Camera:
    """That of a viewer's frame: all look elsewhere, and turn."""
    return rotated(CAMERA, 60.0 * viewer + 3.0 * number)


class Alone:
    """Viewers by themselves, each of the same settings as in a frame with others."""

    def __init__(self, renderer: Renderer) -> None:
        self._renderer = renderer
        self._views: dict[int, ViewState] = {}

    def render(self, viewer: int, camera: Camera) -> Frame:
        view = self._views.get(viewer) or self._views.setdefault(viewer, self._renderer.new_view())
        return self._renderer.render(camera, view=view, walks=True)


def both(room: DeviceScene, light_sets: LightSets, **settings: object) -> tuple[TiledFrames, Alone]:
    """Frames of tiles, and of one viewer each."""
    of = room, SIZE, RenderSettings(**QUALITY, **settings), None, light_sets
    return TiledFrames(Renderer(*of, tiles=TILES)), Alone(Renderer(*of))


def alike(frame: Frame, other: Frame) -> bool:
    """Whether two frames show the same bits."""
    light = frame.radiance().tobytes() == other.radiance().tobytes()
    return light and frame.pixels().tobytes() == other.pixels().tobytes()


def picture_error(frame: Frame, other: Frame) -> float:
    return relative_error(frame.radiance(), other.radiance())


def test_direct_light_is_that_of_each_viewer_alone(room: DeviceScene, light_sets: LightSets) -> None:
    """Who comes, goes, sits where another sat before, jumps, or looks on while others walk, too."""
    settings = {"component": Component.DIRECT, "skip": Skips(unchanged_camera=False)}
    together, alone = both(room, light_sets, **settings)
    walks = [{1: 0}, {1: 1, 2: 0}, {1: 2, 2: 1, 3: 5}, {1: 3, 3: 40}, {1: 4, 2: 2, 3: 41}, {1: 5, 4: 0}, {4: 1, 3: 42}]
    places: dict[int, int] = {}
    for number, step in enumerate(walks):
        if 4 in step and 2 in places:
            assert together.free == 0
            together.leave(2)
            del places[2]
        places |= step
        frames = together.render({viewer: camera(viewer, place) for viewer, place in step.items()})
        assert frames.keys() == step.keys()
        for viewer, place in places.items():
            expected = alone.render(viewer, camera(viewer, place))
            assert viewer not in frames or alike(frames[viewer], expected), (number, viewer)


def test_one_viewer_among_empty_tiles_has_the_bits_of_one_alone(room: DeviceScene, light_sets: LightSets) -> None:
    together, alone = both(room, light_sets)
    for number in range(3):
        frame = together.render({1: camera(0, number)})[1]
        assert alike(frame, alone.render(1, camera(0, number)))
    assert frame.stats.skips["kept_clusters"] > 0
    assert together.free == TILES - 1


def test_light_differs_from_that_of_each_alone_as_clusters_do(room: DeviceScene, light_sets: LightSets) -> None:
    """Less than by half of what another seed makes of it; as bright; and as many clusters are kept for a walk."""
    together, alone = both(room, light_sets)
    other = Renderer(room, SIZE, RenderSettings(**QUALITY, seed=5))
    errors, kept, viewers = [], 0, range(1, TILES + 1)
    others = [picture_error(other.render(camera(it, 0)), alone.render(it, camera(it, 0))) for it in viewers]
    for number in range(1, 4):
        frames = together.render({viewer: camera(viewer, number) for viewer in viewers})
        for viewer, frame in frames.items():
            expected = alone.render(viewer, camera(viewer, number))
            errors.append(picture_error(frame, expected))
            assert frame.radiance().mean() == pytest.approx(expected.radiance().mean(), rel=0.02)
            kept += expected.stats.skips["kept_clusters"] if number == 3 else 0
    assert np.mean(errors) < 0.5 * np.mean(others)
    assert frame.stats.counts["sp_clusters"] == TILES * QUALITY["sp_clusters"]
    assert frame.stats.skips["kept_clusters"] > 0.6 * kept  # those who see the same share them
    assert frame.stats.skips["temporal_reuse"] > 0.5 * frame.stats.counts["shaded"]


def test_a_dark_room_stays_black_beside_a_bright_one() -> None:
    """The rooms of a house, in tiles above each other, whose pixels are neighbours in the image."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    dark = [replace(part, positions=part.positions + np.array([3.0, 2.0, 1.0])) for part in box()]
    house = resident_of([*box(), lamp, *dark], [grey(0.9), grey(0.0, 50.0)])
    together = TiledFrames(Renderer(house, SIZE, RenderSettings(**QUALITY), tiles=2))
    for number in range(3):
        across = 0.01 * number
        bright = look_at((across, 0.0, 0.45), (0.0, 0.0, -0.5), yfov_degrees=75.0)
        unlit = look_at((3.0 + across, 2.0, 1.45), (3.0, 2.0, 0.5), yfov_degrees=75.0)
        frames = together.render({1: bright, 2: unlit})
        assert frames[1].radiance().min() > 0.0
        assert not frames[2].radiance().any()


def test_methods_that_render_no_tiles_say_so(room: DeviceScene, light_sets: LightSets) -> None:
    with pytest.raises(ValueError, match="path: renders no tiles"):
        Renderer(room, SIZE, RenderSettings(method=Method.PATH), None, light_sets, tiles=2)
