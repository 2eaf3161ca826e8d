"""Pictures of a walk's frames that look through other places in the pixels each, averaged."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import box, column, grey, quad, resident_of, results
from walking import SIZE
from walls import CPU, HEIGHT, LEFT, WIDTH, grey_values, wall

from gpu.core.image_size import ImageSize, image_size
from gpu.core.parameters import parameters
from gpu.denoise.antialiasing import (
    ANTIALIASING_PARAMETERS,
    AntialiasingParameters,
    Neighbourhood,
    PictureHistory,
    catmull_rom,
    frames_across,
    frames_before,
    neighbourhood,
    variance_clipped,
)
from gpu.denoise.reprojection import PreviousFrame, PreviousFrameData
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles

PIXELS = SIZE[0] * SIZE[1]


def pose(step: float) -> Camera:
    """A camera that steps aside: a pixel of what is far and four of the post a step."""
    return look_at((0.012 * step, 0.0, 0.45), (0.012 * step, -0.1, -0.5), yfov_degrees=75.0)


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    """A closed box with a thin post, which leans, before its far wall."""
    return resident_of([*box(), quad((-0.02, -0.5, 0.2), (0.06, 0.0, 0.0), (0.1, 1.0, 0.0), 1)], [grey(0.7), grey(0.3)])


class Seen:
    """Frames of a walk, whose pictures show the post as 1 and all else as `behind`."""

    def __init__(self, device_scene: DeviceScene, behind: float = 0.0, **changes: float) -> None:
        self.behind = behind
        self.view = FrameView(device_scene, SIZE, lambertian=True)
        self.view.antialiases = True
        self.history = PictureHistory(SIZE, self.view.device, parameters(AntialiasingParameters, **changes))
        self.last = PreviousFrame(SIZE, self.view.device)
        self.post = np.empty(0)

    def look(self, camera: Camera, sample: int = 0) -> Doubles:
        """Whether each pixel's ray meets the post."""
        self.view.set_camera(camera, sample, walks=sample == 0)
        self.view.find_shading_points()
        return (self.view.gbuffer.albedo.numpy()[:, 0] < 0.5).astype(np.float64)

    def frame(self, camera: Camera, picture: Doubles | None = None) -> Doubles:
        self.post = self.look(camera)
        grey_picture = np.repeat(
            (np.maximum(self.post, self.behind) if picture is None else picture)[:, None], 3, axis=1
        )
        radiance = column(grey_picture.astype(np.float32), wp.vec3)
        reads = self.view.history_length > 0
        self.history.take(self.view.gbuffer, self.view.camera, self.last, radiance, read_history=reads)
        self.last.keep(self.view.gbuffer, self.view.camera)
        self.view.wrote_history = True
        return np.asarray(radiance.numpy()[:, 0], np.float64)

    def frames(self) -> np.ndarray:
        return np.asarray(self.history._known.frames.numpy())


def around(mask: Doubles, reach: int) -> np.ndarray:
    """Whether any pixel so near is marked."""
    padded = np.pad(mask.reshape(SIZE[1], SIZE[0]) > 0.0, reach)
    moved = [np.roll(padded, (dy, dx), (0, 1)) for dy in range(-reach, reach + 1) for dx in range(-reach, reach + 1)]
    return np.any(moved, axis=0)[reach:-reach, reach:-reach].ravel()


def test_edges_of_a_walk_are_smooth_and_nothing_is_left_behind(room: DeviceScene) -> None:
    seen = Seen(room, soft_contrast=1e6, stark_contrast=1e7)
    truth = np.mean([Seen(room).look(pose(11), sample) for sample in range(1, 65)], axis=0)
    for number in range(12):
        picture = seen.frame(pose(number))
        assert picture[~around(seen.post, 1)] == pytest.approx(0.0, abs=1e-6)
    assert np.square(picture - truth).sum() < 0.5 * np.square(seen.look(pose(11), 32) - truth).sum()


@pytest.mark.parametrize(("changes", "kept"), [({}, True), ({"slip": 0.0}, False), ({"gloss": True}, False)])
def test_thin_bright_things_that_a_frame_misses_are_kept_where_all_moves_alike(
    room: DeviceScene, changes: dict[str, Any], kept: bool
) -> None:
    glossy = changes.pop("gloss", False)
    seen, line, even = Seen(room, **changes), np.ones(PIXELS), 1.0 + 0.01 * (np.arange(PIXELS) % 2)
    middle = (SIZE[1] // 2) * SIZE[0] + SIZE[0] // 4
    line[middle - 2 : middle + 3] = 3.0
    if glossy:
        seen.view.gbuffer.gloss = True
        find = seen.view.find_shading_points

        def find_glossy() -> None:
            find()
            seen.view.gbuffer.roughness.fill_(0.1)
            seen.view.gbuffer.f90.fill_(1.0)

        seen.view.find_shading_points = find_glossy  # type: ignore[method-assign]
    seen.frame(pose(0), line)
    for _ in range(2):
        picture = seen.frame(pose(0), even)
    assert (picture[middle] > 1.1) == kept


def test_a_still_camera_sees_its_walk_through_other_places_and_a_first_frame_through_the_middle(
    room: DeviceScene,
) -> None:
    seen, places = Seen(room), []
    for _ in range(3):
        seen.frame(pose(0))
        data = seen.view.camera.numpy()[0]
        places.append((float(data["x"]), float(data["y"])))
    assert places[0] == (0.5, 0.5)
    assert len(set(places)) == 3


def test_a_mean_is_of_eight_frames_about(room: DeviceScene) -> None:
    seen, nearly_black = Seen(room, deviations=1e6), 1e-4 * (1 + np.arange(PIXELS) % 2)
    seen.frame(pose(0), np.ones(PIXELS))
    for number in range(1, 10):
        picture = seen.frame(pose(0), nearly_black)
        assert np.median(np.abs(seen.frames())) == min(number + 1, 8)
    assert np.median(picture) == pytest.approx(1 / 8 * (7 / 8) ** 2, rel=0.01)


def test_nothing_comes_over_an_edge_of_stark_contrast_or_is_lost_there(room: DeviceScene) -> None:
    seen = Seen(room, behind=1e-3, dark=0.0)
    for number in range(6):
        picture = seen.frame(pose(number))
        off = np.abs(picture / np.maximum(seen.post, 1e-3) - 1.0)
        assert np.mean(off > 0.03) < 1e-3  # some 5e-5 of the bright side, at a pixel or two
        assert off.max() < 0.06


def test_contrast_is_that_to_a_tenth_of_the_pictures_mean(room: DeviceScene) -> None:
    seen, picture = Seen(room), np.random.default_rng(1).uniform(0.0, 2.0, PIXELS)
    picture[5] = np.nan
    seen.frame(pose(0), picture)
    assert seen.history._now.brightness.numpy()[0] == pytest.approx(1.0, rel=0.05)


@wp.kernel
def frames_across_kernel(first: int, least: wp.array[float], most: float, mean: float, chosen: AntialiasingParameters,
                         out: wp.array[float]) -> None:  # fmt: skip
    index = first + wp.tid()
    around = Neighbourhood()
    around.least = least[index]
    around.most = most
    out[index] = frames_across(around, mean, chosen)


@pytest.mark.parametrize(("mean", "expected"), [(0.0, [8.0, 8.0, 8.0**0.5, 1.0, 1.0]), (2.0, [8.0] * 5)])
def test_the_more_contrast_is_around_the_fewer_frames_count(mean: float, expected: list[float]) -> None:
    least = column(1.0 / np.array([3.0, 5.0, 1000.0**0.5, 200.0, 3e3]), float)
    out = results(frames_across_kernel, 5, [least, 1.0, mean, ANTIALIASING_PARAMETERS], float)
    assert out == pytest.approx(expected, rel=1e-4)


def test_what_is_not_finite_is_not_handed_on(room: DeviceScene) -> None:
    seen, picture = Seen(room), np.ones(PIXELS)
    picture[PIXELS // 2 + SIZE[0] // 2] = np.nan
    assert np.isnan(seen.frame(pose(0), picture)).sum() == 1
    assert np.isfinite(seen.frame(pose(0), np.ones(PIXELS))).all()


def test_each_viewer_has_pictures_of_its_own(room: DeviceScene) -> None:
    seen = Seen(room)
    own, other = seen.history, seen.history.for_another_viewer()
    for _ in range(3):
        for seen.history, scale in ((own, 1.0), (other, 5.0)):
            assert seen.frame(pose(0), np.full(PIXELS, scale)) == pytest.approx(scale, abs=1e-4)


@wp.kernel
def frames_kernel(first: int, previous: PreviousFrameData, frames: wp.array[int], gbuffer: GBuffer,
                  pixels: wp.array[int], places: wp.array[wp.vec2], chosen: AntialiasingParameters,
                  out: wp.array[int]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = frames_before(previous, frames, gbuffer, pixels[index], places[index], chosen)


def frames_at(before: GBuffer, frames: Any, now: GBuffer, pixel: int, place: tuple[float, float]) -> int:
    """Of how many frames a picture is around a place, by what was seen before and now."""
    previous = PreviousFrameData()
    previous.image, previous.position, previous.normal = image_size((WIDTH, HEIGHT)), before.position, before.normal
    known = column(np.broadcast_to(frames, WIDTH * HEIGHT), wp.int32)
    where = wp.array([place], dtype=wp.vec2, device=CPU)
    inputs = [previous, known, now, column([pixel], wp.int32), where, ANTIALIASING_PARAMETERS]
    return int(results(frames_kernel, 1, inputs, int)[0])


@pytest.mark.parametrize(("outside", "known"), [(0.77, 3), (0.78, 0)])
def test_a_twentieth_of_what_is_around_a_point_is_enough(outside: float, known: int) -> None:
    assert frames_at(wall(), 3, wall(), 0, (-outside, -outside)) == known


@pytest.mark.parametrize(("depth", "known"), [(3.4, 3), (3.55, 0)])
def test_what_is_two_spacings_off_the_plane_counts_less_by_e(depth: float, known: int) -> None:
    before = wall(depth=np.full((HEIGHT, WIDTH), depth))
    assert frames_at(before, 3, wall(), 20 * WIDTH + 20, (20.5, 20.5)) == known


def test_the_sky_is_found_where_nothing_else_was() -> None:
    half, frames = wall(seen=LEFT), np.where(LEFT, 3, -5).ravel()
    sky = 20 * WIDTH + WIDTH - 4
    assert frames_at(half, frames, half, sky, (WIDTH - 4.5, 20.0)) == 5
    assert frames_at(half, frames, half, sky, (4.5, 20.0)) == 0


@wp.kernel
def bounded_kernel(first: int, colours: wp.array[wp.vec3], picture: wp.array[wp.vec3], pixel: int, image: ImageSize,
                   deviations: float, out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = variance_clipped(colours[index], neighbourhood(picture, pixel, image), deviations)


def bounded_by(around: Doubles, colours: Sequence[float]) -> Doubles:
    """Greys as far as grey neighbourhoods, (3, 3), let them be."""
    values = np.zeros((HEIGHT, WIDTH))
    values[19:22, 19:22] = around
    inputs = [grey_values(values), 20 * WIDTH + 20, image_size((WIDTH, HEIGHT)), ANTIALIASING_PARAMETERS.deviations]
    greys = column([[grey] * 3 for grey in colours], wp.vec3)
    return results(bounded_kernel, len(colours), [greys, *inputs], wp.vec3)[:, 1]


def test_a_colour_is_cut_off_beyond_a_deviation() -> None:
    around = np.arange(9.0).reshape(3, 3) + 4.0  # mean 8, deviation √(60/9)
    assert bounded_by(around, [30.0, 9.0]) == pytest.approx([8.0 + np.sqrt(60.0 / 9.0), 9.0], rel=1e-4)


def test_beside_a_lamp_nothing_is_darker_than_all_around() -> None:
    lamp = np.full((3, 3), 50.0)
    lamp[:, :2] = 0.5
    assert bounded_by(lamp, [-2.0, 0.1, 0.6]) == pytest.approx([0.5, 0.5, 0.6], rel=1e-3)


@wp.kernel
def interpolated_kernel(first: int, picture: wp.array[wp.vec3], places: wp.array[wp.vec2], image: ImageSize,
                        out: wp.array[wp.vec3]) -> None:  # fmt: skip
    index = first + wp.tid()
    out[index] = catmull_rom(picture, places[index], image)


def test_what_varies_by_a_square_is_exact_between_pixels() -> None:
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    places = [(20.0, 20.0), (20.3, 10.75), (7.5, 30.1)]
    inputs = [grey_values(x * x + x * y), wp.array(places, dtype=wp.vec2, device=CPU), image_size((WIDTH, HEIGHT))]
    expected = [a * a + a * b for a, b in places]
    assert results(interpolated_kernel, 3, inputs, wp.vec3)[:, 2] == pytest.approx(expected, rel=1e-4)
