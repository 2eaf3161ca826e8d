"""Light that earlier frames of a walk found."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import box, grey, quad, resident_of
from walking import SIZE, furnished
from walking import slow_pose as pose

from gpu.denoise.indirect_history import IndirectHistory
from gpu.denoise.reprojection import REPROJECTION_PARAMETERS, PreviousFrame
from gpu.device_scene.data import NO_HIT
from gpu.device_scene.upload import DeviceScene
from gpu.renderer import Renderer
from gpu.scene.camera import rotated
from gpu.scene.types import Camera, Doubles
from gpu.settings import Component, Method, RenderSettings, Skips

CHOSEN = REPROJECTION_PARAMETERS
# The truth is of pixels' centres.
QUALITY = {
    "sp_clusters": 100,
    "vpls": 2000,
    "vpl_clusters": 200,
    "component": Component.INDIRECT,
    "lambertian": True,
    "antialias": False,
}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return furnished()


class Seen:
    """Frames of a view that find the light they are told to, and what their history makes of it."""

    def __init__(self, device_scene: DeviceScene, size: tuple[int, int] = SIZE, stride: int = 1) -> None:
        self.view = FrameView(device_scene, size, lambertian=True, stride=stride)
        self.history = IndirectHistory(size, self.view.device)
        self.last = PreviousFrame(size, self.view.device)

    def look(self, camera: Camera) -> None:
        self.view.set_camera(camera)
        self.view.find_shading_points()

    @property
    def positions(self) -> Doubles:
        return np.asarray(self.view.gbuffer.position.numpy(), np.float64)

    @property
    def listed(self) -> np.ndarray:
        return np.asarray(self.view.shading_points.listed.numpy() == 1)

    def array(self, values: Doubles) -> wp.array:
        return wp.array(values.astype(np.float32), dtype=wp.vec3, device=self.view.device)

    def frame(self, camera: Camera, light: Doubles, *, begins: bool = False) -> tuple[Doubles, Doubles]:
        """Look, take in `light` (pixel, 3) as what is found; the light and the near-field light that are known then."""
        self.look(camera)
        view, history = self.view, self.history
        if begins:
            history.forget()
        else:
            history.find(view.gbuffer, view.shading_points, self.last, view.seed)
        irradiance = self.array(np.full_like(light, 0.25))
        lacking = history.take_light(view.shading_points, irradiance, self.array(light - 0.25))
        near = self.array(2.0 * light)
        history.take_near(view.shading_points, near)
        history.keep(view.shading_points)
        self.last.keep(view.gbuffer, view.camera)
        return np.asarray(lacking.numpy(), np.float64) + 0.25, np.asarray(near.numpy(), np.float64)

    def settled(self) -> np.ndarray:
        return np.asarray(self.history.settled.numpy() == 1)

    def frames(self) -> np.ndarray:
        return np.asarray(self.history.frames.numpy())


@pytest.mark.parametrize("stride", [1, 2])
def test_light_of_a_place_is_found_where_it_is_seen_next(room: DeviceScene, stride: int) -> None:
    """Light is linear over the place, so interpolation between pixels of a plane is right."""
    seen = Seen(room, stride=stride)
    seen.look(pose(0))
    seen.frame(pose(0), 1.0 + seen.positions, begins=True)
    light, near = seen.frame(pose(1), np.zeros((len(seen.positions), 3)))  # the second frame finds none
    known = seen.listed & (seen.frames() == 1)
    assert known.sum() > 0.9 * seen.listed.sum()
    there = 1.0 + seen.positions[known]
    # Half of what was known: the mean of two frames. At edges a part of a pixel's surroundings has to do.
    off = np.abs(light[known] - 0.5 * there).max(axis=1) / seen.view.gbuffer.spacing.numpy()[known]
    assert off.max() < 0.5 * stride
    assert np.median(off) < 0.01 * stride
    assert near[known] == pytest.approx(2.0 * light[known], abs=1e-5)
    fresh = seen.listed & (seen.frames() == 0)
    assert light[fresh] == pytest.approx(0.0, abs=1e-6)


def test_a_mean_forgets_what_is_older_than_the_most_frames(room: DeviceScene) -> None:
    seen = Seen(room)
    ones = np.ones((SIZE[0] * SIZE[1], 3))
    seen.frame(pose(0), ones, begins=True)
    expected = 1.0
    for number in range(1, 40):
        light, _ = seen.frame(pose(0), 0.0 * ones)
        expected -= expected / min(number + 1, CHOSEN.max_frames)
        assert light[seen.listed] == pytest.approx(expected, abs=1e-5)
    assert seen.frames().max() == CHOSEN.max_frames
    assert expected < 0.02


def test_the_mean_of_noisy_frames_has_less_noise_and_no_bias(room: DeviceScene) -> None:
    seen, random = Seen(room), np.random.default_rng(1)
    for number in range(24):
        noisy = random.exponential(size=(SIZE[0] * SIZE[1], 3))
        light, near = seen.frame(pose(0.5 * number), noisy, begins=number == 0)
    old = seen.listed & (seen.frames() >= 6)
    assert old.sum() > 0.7 * seen.listed.sum()
    assert light[old].mean() == pytest.approx(1.0, abs=0.02)
    assert near[old].mean() == pytest.approx(2.0, abs=0.04)
    assert light[old].std() < 0.4


def test_light_that_is_well_known_on_even_surfaces_stays_as_it_is_in_two_frames_of_three(room: DeviceScene) -> None:
    seen, ones = Seen(room, stride=2), np.ones((SIZE[0] * SIZE[1], 3))
    for number in range(CHOSEN.settled_frames + 1):
        assert not seen.settled().any()
        seen.frame(pose(0), ones, begins=number == 0)
    listed = seen.listed.reshape(SIZE[1], SIZE[0])
    padded = np.pad(listed, 1)
    around = sum(padded[dy : dy + SIZE[1], dx : dx + SIZE[0]].astype(int) for dy in range(3) for dx in range(3))
    even = (listed & (around == 1)).ravel()
    often = np.zeros(len(even), int)
    for frame in range(3):
        seen.view.seed.fill_(frame)
        light, near = seen.frame(pose(0), (2.0 + frame) * ones)
        settled = seen.settled() & seen.listed
        often += settled
        assert even[settled].all()
        assert settled.sum() > 0.5 * even.sum()
        assert near[settled].min() > 2.0
    assert (often[even] == 2).all()
    seen.view.seed.fill_(0)
    before = light.copy()
    light, _ = seen.frame(pose(0), 100.0 * ones)
    settled = seen.settled() & seen.listed
    assert light[settled] == pytest.approx(before[settled], rel=2e-5)
    assert light[even & ~settled].min() > 10.0
    seen.history.forget()
    assert not seen.settled().any()


@pytest.mark.parametrize(("dark", "settles"), [(0.2, False), (0.6, False), (0.75, True)])
def test_what_lies_between_light_and_dark_is_not_settled(room: DeviceScene, dark: float, settles: bool) -> None:
    """Beside a contact what is handed on is too bright, and only rays find the dark."""
    seen = Seen(room, stride=2)
    column = np.arange(SIZE[0] * SIZE[1]) % SIZE[0]
    light = np.repeat(np.where(column < 30, 1.0, dark)[:, None], 3, axis=1)
    settled = np.zeros(len(column), bool)
    for seed in range(3):
        seen.view.seed.fill_(seed)
        for number in range(CHOSEN.max_frames):
            seen.frame(pose(0), light, begins=number == 0)
        seen.frame(rotated(pose(0), 1.83), light)  # a pixel
        settled |= seen.settled() & seen.listed
    often = [int(settled[column == at].sum()) for at in range(20, 40, 2)]
    assert np.median(often) > 8
    assert (min(often[4:6]) > 8) == settles  # of 28 and 30, one was between them


def test_what_was_hidden_or_outside_has_no_history(room: DeviceScene) -> None:
    """A thin post hides other walls as the camera moves aside."""
    post = quad((-0.02, -0.5, 0.2), (0.04, 0.0, 0.0), (0.0, 1.0, 0.0), 0)
    seen = Seen(resident_of([*box(), post], [grey(0.7)]))
    seen.frame(pose(0), np.ones((SIZE[0] * SIZE[1], 3)), begins=True)
    before, faces = seen.positions.copy(), seen.view.gbuffer.face.numpy().copy()
    moved = replace(pose(0), to_world=pose(0).to_world.copy())
    moved.to_world[0, 3] += 0.06
    light, _ = seen.frame(moved, np.zeros((len(before), 3)))
    fresh = seen.listed & (seen.frames() == 0)
    assert light[fresh] == pytest.approx(0.0, abs=1e-6)
    nearest = np.array([np.linalg.norm(before[faces != NO_HIT] - place, axis=1).min() for place in seen.positions])
    spacing = seen.view.gbuffer.spacing.numpy()
    unseen = seen.listed & (nearest > 2.0 * spacing)
    assert unseen.sum() > 20
    assert fresh[unseen].all()
    assert (~fresh & seen.listed).sum() > 0.8 * seen.listed.sum()


def test_what_is_not_finite_is_not_handed_on(room: DeviceScene) -> None:
    seen, light = Seen(room), np.ones((SIZE[0] * SIZE[1], 3))
    light[SIZE[0] * SIZE[1] // 2 + SIZE[0] // 2] = np.nan
    light[SIZE[0] * SIZE[1] // 3] = np.inf
    seen.frame(pose(0), light, begins=True)
    for found in seen.frame(pose(0.5), np.zeros_like(light)):
        assert np.isfinite(found[seen.listed]).all()


def walk(room: DeviceScene, frames: int, **changes: object) -> tuple[list[Doubles], Renderer]:
    renderer = Renderer(room, SIZE, RenderSettings(**{**QUALITY, **changes}))
    return [renderer.render(pose(number), walks=True).radiance().astype(float) for number in range(frames)], renderer


def test_a_walk_flickers_less_and_is_no_farther_from_the_truth(room: DeviceScene) -> None:
    """Pixels are as small as where light is interpolated: a frame hands on light with less blur than it has noise."""
    size, last, quality = (96, 72), 10, {**QUALITY, "sp_clusters": 50, "near_field": False}

    def at(number: int) -> Camera:
        """Of the middle quarter of the view."""
        camera = pose(number / 3)
        return replace(camera, half_height=0.5 * camera.half_height)

    def pictures(**changes: object) -> Doubles:
        renderer = Renderer(room, size, RenderSettings(**{**quality, **changes}))
        return np.array([renderer.render(at(number), walks=True).radiance() for number in range(last + 1)], float)

    exact = Renderer(room, size, RenderSettings(**{**quality, "method": Method.EXACT_VPL}))
    truth = np.array([exact.render(at(number)).radiance() for number in (last - 1, last)], float)

    def errors(**changes: object) -> tuple[float, float]:
        """Mean change of the error from one frame to the next, and the mean square of the last one's."""
        error = pictures(**changes)[-2:] - truth
        return float(np.abs(error[1] - error[0]).mean()), float(np.mean(error[1] ** 2))

    (flicker, mse), (usual_flicker, usual_mse) = errors(), errors(skip=Skips(temporal_reuse=False))
    assert flicker < 0.9 * usual_flicker
    assert flicker < 0.0028 * float(truth.mean())
    assert mse < 1.2 * usual_mse


def test_near_field_light_of_a_walk_has_fewer_rays_less_noise_and_as_much_energy(room: DeviceScene) -> None:
    def change(*, kept: bool) -> tuple[float, float, int]:
        """How the last frames, half a pixel apart, differ; the mean of the last one, and its rays that found light."""
        pictures, renderer = walk(room, 20, skip=Skips(temporal_reuse=kept))
        found = renderer.render(pose(20), walks=True).stats.counts["near"]
        return float(np.abs(np.diff(pictures[-8:], axis=0)).mean()), float(pictures[-1].mean()), found

    (kept, energy, rays), (usual, mean, all_rays) = change(kept=True), change(kept=False)
    assert 0.25 * all_rays < rays < 0.5 * all_rays
    assert kept < 0.88 * usual
    assert energy == pytest.approx(mean, rel=0.02)


def test_each_viewer_finds_its_own_light(room: DeviceScene) -> None:
    seen, ones = Seen(room), np.ones((SIZE[0] * SIZE[1], 3))
    own, other = seen.history, seen.history.for_another_viewer()
    for number in range(3):
        for seen.history, scale in ((own, 1.0), (other, 5.0)):
            light, near = seen.frame(pose(0), scale * ones, begins=number == 0)
            assert light[seen.listed] == pytest.approx(scale, abs=1e-5)
            assert near[seen.listed] == pytest.approx(2.0 * scale, abs=1e-5)
    assert seen.frames()[seen.listed].min() == 2


def test_statistics_tell_what_earlier_frames_know(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**QUALITY))
    first, second = (renderer.render(pose(number), walks=True).stats for number in range(2))
    assert first.skips["temporal_reuse"] == 0
    assert 0.9 * second.counts["shaded"] < second.skips["temporal_reuse"] <= second.counts["shaded"]
    still = renderer.render(pose(3)).stats
    assert still.skips["temporal_reuse"] == 0
    for changes in ({"skip": Skips(temporal_reuse=False)}, {"smooth": False}):
        other = Renderer(room, SIZE, RenderSettings(**{**QUALITY, **changes}))
        assert [other.render(pose(number), walks=True).stats.skips["temporal_reuse"] for number in range(2)] == [0, 0]


def test_light_is_remembered_where_clusters_are_not_kept(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**QUALITY, skip=Skips(kept_clusters=False)))
    first, second = (renderer.render(pose(number), walks=True).stats.skips for number in range(2))
    assert first["temporal_reuse"] == 0 < second["temporal_reuse"]
    assert second["kept_clusters"] == 0
