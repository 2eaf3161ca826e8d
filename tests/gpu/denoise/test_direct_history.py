"""Direct light of area lights that earlier frames of a walk found."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import box, column, grey, quad, resident_of
from walking import SIZE
from walking import slow_pose as pose

from gpu.denoise.direct_history import DirectHistory
from gpu.denoise.reprojection import REPROJECTION_PARAMETERS, PreviousFrame
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.renderer import Renderer
from gpu.scene.types import Camera, Doubles, Material
from gpu.settings import Component, Method, RenderSettings, Skips

PIXELS = SIZE[0] * SIZE[1]


def room_of(material: Material) -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block, which throws a soft shadow, on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 0)
    return resident_of([*box(), lamp, block], [material, grey(0.0, 5.0)])


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return room_of(grey(0.7))


class Seen:
    """Frames of a view that find the light of a lamp they are told to, and what their history makes of it."""

    def __init__(self, device_scene: DeviceScene, **choice: Any) -> None:
        self.view = FrameView(device_scene, SIZE, lambertian=choice.get("lambertian", True))
        self.history = DirectHistory(SIZE, self.view.device)
        self.last = PreviousFrame(SIZE, self.view.device)

    def frame(self, camera: Camera, light: Doubles, *, begins: bool = False) -> Doubles:
        view = self.view
        view.set_camera(camera)
        view.find_shading_points()
        soft = column(light.astype(np.float32), wp.vec3)
        self.history.take(view.gbuffer, self.last, soft, read_history=not begins)
        self.last.keep(view.gbuffer, view.camera)
        return np.asarray(soft.numpy(), np.float64)

    def frames(self) -> np.ndarray:
        return np.asarray(self.history.frames.numpy())


def test_light_of_a_place_is_found_where_it_is_seen_next(room: DeviceScene) -> None:
    seen = Seen(room)
    seen.view.set_camera(pose(0))
    seen.view.find_shading_points()
    places = seen.view.gbuffer.position.numpy()
    seen.frame(pose(0), 1.0 + places, begins=True)
    light = seen.frame(pose(1), np.zeros((PIXELS, 3)))  # the second frame finds none
    known = seen.frames() == 2
    assert known.mean() > 0.9
    there = 1.0 + seen.view.gbuffer.position.numpy()[known]
    off = np.abs(light[known] - 0.5 * there).max(axis=1) / seen.view.gbuffer.spacing.numpy()[known]
    assert off.max() < 0.5
    assert np.median(off) < 0.01
    fresh = seen.frames() == 1
    assert (known | fresh).all()
    assert light[fresh] == pytest.approx(0.0, abs=1e-6)


def test_the_mean_of_noisy_frames_has_less_noise_and_no_bias(room: DeviceScene) -> None:
    seen, random = Seen(room), np.random.default_rng(1)
    for number in range(24):
        light = seen.frame(pose(0.5 * number), random.exponential(size=(PIXELS, 3)), begins=number == 0)
    old = seen.frames() >= 7
    assert seen.frames().max() == REPROJECTION_PARAMETERS.max_frames
    assert old.mean() > 0.7
    assert light[old].mean() == pytest.approx(1.0, abs=0.02)
    assert light[old].std() < 0.4


def test_frames_of_known_light_are_told_before_it_is_taken(room: DeviceScene) -> None:
    seen = Seen(room)
    for number in range(6):
        seen.frame(pose(number), np.ones((PIXELS, 3)), begins=number == 0)
    before = seen.view.gbuffer.position.numpy().copy()
    seen.view.set_camera(pose(60))
    seen.view.find_shading_points()
    frames = seen.history.find(seen.view.gbuffer, seen.last).numpy().copy()
    nearest = np.array([np.linalg.norm(before - place, axis=1).min() for place in seen.view.gbuffer.position.numpy()])
    unseen = nearest > 3.0 * seen.view.gbuffer.spacing.numpy()
    assert unseen.sum() > 20
    assert (frames[unseen] == 0).all()
    assert np.median(frames[~unseen]) == 6
    seen.frame(pose(60), np.ones((PIXELS, 3)))
    assert (seen.frames()[frames == 6] >= 4).mean() > 0.95


@pytest.mark.parametrize(("roughness", "most"), [(0.05, 1), (0.2, 3), (0.6, 8)])
def test_what_narrow_lobes_reflect_is_forgotten_sooner(roughness: float, most: int) -> None:
    glossy = Material("", base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0, roughness=roughness)
    seen = Seen(room_of(glossy), lambertian=False)
    for number in range(10):
        light = seen.frame(pose(0), np.full((PIXELS, 3), float(number == 0)), begins=number == 0)
        if number > 0:
            assert seen.frames().max() == min(number + 1, most)
    assert light.max() == pytest.approx(0.0 if most == 1 else np.prod([1 - 1 / min(n + 1, most) for n in range(1, 10)]))


def test_what_was_hidden_has_no_history(room: DeviceScene) -> None:
    """A thin post hides other walls as the camera moves aside."""
    post = quad((-0.02, -0.5, 0.2), (0.04, 0.0, 0.0), (0.0, 1.0, 0.0), 0)
    seen = Seen(resident_of([*box(), post], [grey(0.7)]))
    seen.frame(pose(0), np.ones((PIXELS, 3)), begins=True)
    before = seen.view.gbuffer.position.numpy().copy()
    moved = replace(pose(0), to_world=pose(0).to_world.copy())
    moved.to_world[0, 3] += 0.06
    light = seen.frame(moved, np.zeros((PIXELS, 3)))
    nearest = np.array([np.linalg.norm(before - place, axis=1).min() for place in seen.view.gbuffer.position.numpy()])
    unseen = nearest > 2.0 * seen.view.gbuffer.spacing.numpy()
    assert unseen.sum() > 20
    assert light[unseen] == pytest.approx(0.0, abs=1e-6)
    assert (seen.frames() > 1).mean() > 0.8


@pytest.mark.parametrize(("outside", "known"), [(0.2, True), (0.4, False)])
def test_what_was_less_than_half_in_the_last_image_has_no_history(
    room: DeviceScene, outside: float, known: bool
) -> None:
    """A pixel in the corner, which a camera lays outside by a part of a pixel both ways as it turns and nods."""
    seen, camera = Seen(room), pose(0)
    for number in range(6):
        seen.frame(camera, np.ones((PIXELS, 3)), begins=number == 0)
    x, y = camera.half_height * SIZE[0] / SIZE[1], camera.half_height
    angle = outside * 2.0 * y / SIZE[1] / (1.0 + x * x + y * y)
    turned = np.eye(4)
    turned[:3, :3] += angle * np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
    seen.frame(replace(camera, to_world=camera.to_world @ turned), np.ones((PIXELS, 3)))
    corners = seen.frames().reshape(SIZE[1], SIZE[0])[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert (corners.min() > 1) == known


def test_what_is_not_finite_is_not_handed_on(room: DeviceScene) -> None:
    seen, light = Seen(room), np.ones((PIXELS, 3))
    light[PIXELS // 2 + SIZE[0] // 2] = np.nan
    light[PIXELS // 3] = np.inf
    seen.frame(pose(0), light, begins=True)
    after = seen.frame(pose(0.5), np.zeros((PIXELS, 3)))
    assert np.isfinite(after).all()
    assert np.isin(seen.frames(), [1, 2]).all()


def test_each_viewer_finds_its_own_light(room: DeviceScene) -> None:
    seen = Seen(room)
    own, other = seen.history, seen.history.for_another_viewer()
    for number in range(3):
        for seen.history, scale in ((own, 1.0), (other, 5.0)):
            light = seen.frame(pose(0), np.full((PIXELS, 3), scale), begins=number == 0)
            assert light == pytest.approx(scale, abs=1e-5)
    assert seen.frames().min() == 3


def renderer_of(room: DeviceScene, **changes: Any) -> Renderer:
    settings = {"component": Component.DIRECT, "samples": 1, "antialias": False, **changes}
    return Renderer(room, SIZE, RenderSettings(**settings))


def walk(renderer: Renderer, first: int, last: int) -> list[Doubles]:
    frames = [renderer.render(pose(0.5 * number), walks=True) for number in range(first, last)]
    return [frame.radiance().astype(float) for frame in frames]


def test_a_walk_has_less_noise_and_as_much_light(room: DeviceScene) -> None:
    truth = renderer_of(room, samples=128, smooth=False).render(pose(9.5)).radiance().astype(float)

    def error(**changes: Any) -> float:
        last = walk(renderer_of(room, **changes), 0, 20)[-1]
        assert last.mean() == pytest.approx(truth.mean(), rel=0.01)
        return float(np.mean((last - truth) ** 2))

    assert error() < 0.6 * error(skip=Skips(temporal_reuse=False))


def test_each_frame_of_a_walk_has_samples_of_its_own(room: DeviceScene) -> None:
    renderer = renderer_of(room)
    moments = []
    for number in range(3):
        renderer.render(pose(number), walks=True)
        moments.append(int(renderer._method._frame.frame_index.numpy()[0]))
    assert moments == [0, 1, 2]


@pytest.mark.parametrize(
    "changes", [{"skip": Skips(temporal_reuse=False)}, {"smooth": False}, {"method": Method.EXACT_VPL}]
)
def test_frames_that_keep_nothing_are_those_of_no_walk(room: DeviceScene, changes: dict[str, Any]) -> None:
    alone = renderer_of(room, **changes).render(pose(1)).radiance()
    renderer = renderer_of(room, **changes)
    assert np.array_equal(walk(renderer, 0, 3)[-1], alone)
    histories = getattr(renderer._own_view, "histories", None)
    assert histories is None or not histories.direct.frames.numpy().any()


def test_a_jump_and_a_rest_begin_anew(room: DeviceScene) -> None:
    alone = renderer_of(room).render(pose(0)).radiance()
    renderer = renderer_of(room)
    walk(renderer, 4, 6)
    assert np.array_equal(renderer.render(pose(0)).radiance(), alone)
    walk(renderer, 4, 6)
    accumulation = Accumulation(PIXELS, room.device)
    for _ in range(2):
        renderer.render(pose(3), accumulation, walks=True)
    assert np.array_equal(renderer.render(pose(0), walks=True).radiance(), alone)
