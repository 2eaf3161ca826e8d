"""Each switch of gpu.settings.Skips: what the picture is without it, and that the statistics count it."""

from typing import Any

import numpy as np
import pytest
from devices import DEVICES
from scenes import box, grey, quad, resident_of

from gpu.core.kernel_loading import noted_kernels
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.gbuffer import sparse_shading as interpolate
from gpu.methods.frame_kind import StillViewParameters
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import Sky
from gpu.settings import EVERY_SKIP, Clustering, Component, Method, RenderSettings, Skips
from gpu.vpl.light_sets import LightSets

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
OTHER_CAMERA = look_at((0.1, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
QUALITY = {"sp_clusters": 200, "vpls": 2000, "vpl_clusters": 200}
ABSENT = ("absent_alpha", "absent_textures", "absent_gloss")


def without(*names: str) -> Skips:
    return Skips(**dict.fromkeys(names, False))


def frame(device_scene: DeviceScene, skip: Skips = EVERY_SKIP, **settings: object) -> Frame:
    return Renderer(device_scene, SIZE, RenderSettings(**{**QUALITY, "skip": skip, **settings})).render(CAMERA)


def relative_error(x: Frame, r: Frame) -> float:
    picture, reference = x.radiance(), r.radiance()
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2)))


def assert_same(x: Frame, r: Frame, device_scene: DeviceScene) -> None:
    """The same bits; CUDA's compiler fuses multiplications and additions otherwise in other kernels."""
    if device_scene.device.is_cuda:
        assert relative_error(x, r) < 1e-6
    else:
        assert x.radiance().tobytes() == r.radiance().tobytes()


@pytest.fixture(scope="module", params=DEVICES)
def room(request: pytest.FixtureRequest) -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor, on each device in turn."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)], device=request.param)


@pytest.fixture(scope="module")
def usual(room: DeviceScene) -> Frame:
    return frame(room)


@pytest.fixture(scope="module")
def terrace() -> DeviceScene:
    """A floor, a wall and a screen between below a sky, which many pixels see."""
    floor = quad((-0.5, -0.2, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    wall = quad((-0.5, -0.2, -0.5), (1.0, 0.0, 0.0), (0.0, 0.3, 0.0))
    screen = quad((-0.2, -0.2, -0.3), (0.3, 0.0, 0.1), (0.0, 0.2, 0.0))
    return resident_of([floor, wall, screen], [grey(0.5)], sky=Sky((1.0, 2.0, 3.0)))


def test_every_frame_tells_of_every_skip(room: DeviceScene, usual: Frame) -> None:
    path = frame(room, method=Method.PATH, samples=1)
    assert set(Skips.model_fields) <= set(usual.stats.skips) & set(path.stats.skips)
    assert not any(path.stats.skips.values())


# The bounds are those of gpu.indirect.visibility, here as errors of the whole picture.
@pytest.mark.parametrize(("name", "bound"), [("facing_away", 1e-4), ("shared_weak_rays", 1e-4)])
def test_rays_for_more_pairs_change_little(room: DeviceScene, usual: Frame, name: str, bound: float) -> None:
    other = frame(room, without(name))
    assert usual.stats.skips[name] > 0
    assert other.stats.skips[name] == 0
    assert other.stats.counts["rays"] == usual.stats.counts["rays"] + usual.stats.skips[name]
    assert relative_error(usual, other) < bound


def test_kernels_that_know_of_what_is_absent_give_the_same_bits(room: DeviceScene, usual: Frame) -> None:
    assert_same(frame(room.as_on_gpus()), usual, room)
    other = frame(room, without(*ABSENT))
    assert all(usual.stats.skips[name] == 1 for name in ABSENT)
    assert other.stats.skips == usual.stats.skips | dict.fromkeys(ABSENT, 0)
    assert_same(other, usual, room)


@pytest.mark.parametrize("name", ABSENT)
def test_each_thing_that_is_absent_has_its_switch(room: DeviceScene, name: str) -> None:
    """Told without a launch: which kernels there would be is enough."""
    with noted_kernels():
        skips = frame(room, without(name)).stats.skips
    assert [other for other in ABSENT if not skips[other]] == [name]


def test_what_is_absent_depends_on_the_scene_and_the_light_that_is_wanted(terrace: DeviceScene) -> None:
    skips = frame(terrace).stats.skips
    assert (skips["absent_gloss"], skips["absent_textures"]) == (1, 1)
    skips = frame(terrace, component=Component.INDIRECT).stats.skips
    assert (skips["absent_gloss"], skips["absent_textures"]) == (0, 1)


def test_pixels_that_see_nothing_are_counted(terrace: DeviceScene, usual: Frame) -> None:
    assert usual.stats.counts["empty"] == 0
    outdoors, exact = frame(terrace), frame(terrace, method=Method.EXACT_VPL)
    assert 0.2 < outdoors.stats.counts["empty"] / (SIZE[0] * SIZE[1]) < 0.8
    assert exact.stats.counts["empty"] == outdoors.stats.counts["empty"]
    assert relative_error(outdoors, exact) < 2e-3


@pytest.fixture
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures as small as these are interpolated, too."""
    monkeypatch.setattr(interpolate, "ANCHOR_PARAMETERS", interpolate.AnchorParameters(min_pixels=0))


def test_indirect_light_of_most_pixels_is_interpolated(room: DeviceScene, of_any_size: None) -> None:
    usual, other = frame(room), frame(room, without("interpolated"))
    pixels = SIZE[0] * SIZE[1]
    assert usual.stats.skips["interpolated"] + usual.stats.counts["shaded"] == pixels
    assert usual.stats.skips["interpolated"] > 0.4 * pixels
    assert (other.stats.skips["interpolated"], other.stats.counts["shaded"]) == (0, pixels)
    exact = frame(room, method=Method.EXACT_VPL)
    assert relative_error(usual, other) < 5e-3
    assert relative_error(usual, exact) < 1.5 * relative_error(other, exact) + 1e-3


def test_empty_pixels_are_not_counted_as_interpolated(terrace: DeviceScene, of_any_size: None) -> None:
    for skip in (EVERY_SKIP, without("interpolated")):
        stats = frame(terrace, skip).stats
        done = stats.counts["shaded"] + stats.skips["interpolated"] + stats.counts["empty"]
        assert done == SIZE[0] * SIZE[1]


def test_far_vpl_clusters_are_not_shaded_one_by_one(room: DeviceScene, usual: Frame) -> None:
    other = frame(room, without("far_field_sums"))
    pairs = usual.stats.counts["shaded"] * usual.stats.counts["vpl_clusters"]
    assert 0.5 * pairs < usual.stats.skips["far_field_sums"] < pairs
    assert other.stats.skips["far_field_sums"] == 0
    exact = frame(room, method=Method.EXACT_VPL)
    assert relative_error(usual, other) < 5e-3
    assert relative_error(usual, exact) < 1.5 * relative_error(other, exact) + 1e-3


@pytest.mark.parametrize("method", list(Method))
def test_an_unchanged_view_is_not_rendered_again(room: DeviceScene, method: Method) -> None:
    settings = RenderSettings(sp_clusters=50, vpls=300, vpl_clusters=40, method=method, samples=1)
    renderer = Renderer(room, SIZE, settings)
    first = renderer.render(CAMERA)
    bits, shown = first.radiance().tobytes(), first.pixels().tobytes()
    again = renderer.render(CAMERA)
    assert list(again.stats.stage_ms) == ["display"]
    assert again.stats.skips == dict.fromkeys(Skips.model_fields, 0) | {"unchanged_camera": SIZE[0] * SIZE[1]}
    assert again.stats.counts == first.stats.counts
    assert (again.radiance().tobytes(), again.pixels().tobytes()) == (bits, shown)
    renderer.render(OTHER_CAMERA)
    back = renderer.render(CAMERA)
    assert back.stats.skips == first.stats.skips
    assert back.radiance().tobytes() == bits
    always = Renderer(room, SIZE, settings.model_copy(update={"skip": without("unchanged_camera")}))
    for _ in range(2):
        other = always.render(CAMERA)
        assert list(other.stats.stage_ms) == list(first.stats.stage_ms)
        assert other.stats.skips == first.stats.skips
        assert other.radiance().tobytes() == bits


def test_a_still_view_begins_with_the_frame_that_it_shows_and_goes_on_with_others(room: DeviceScene) -> None:
    def means(skip: Skips) -> list[tuple[int, bytes]]:
        renderer = Renderer(room, SIZE, RenderSettings(**QUALITY, skip=skip))
        renderer.render(CAMERA)
        accumulation = Accumulation(SIZE[0] * SIZE[1], room.device)
        kept = []
        for _ in range(3):
            frame = renderer.render(CAMERA, accumulation)
            kept.append((frame.stats.skips["unchanged_camera"], frame.radiance().tobytes()))
        return kept

    usual, always = means(EVERY_SKIP), means(without("unchanged_camera"))
    assert [count for count, _ in usual] == [SIZE[0] * SIZE[1], 0, 0]
    assert [count for count, _ in always] == [0, 0, 0]
    assert [bits for _, bits in usual] == [bits for _, bits in always]
    assert len({bits for _, bits in usual}) == 3


def test_a_view_that_failed_is_rendered_again(room: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("no memory")

    renderer = Renderer(room, SIZE, RenderSettings(**QUALITY))
    renderer.render(CAMERA)
    with monkeypatch.context() as patched:
        patched.setattr("gpu.methods.clustered_lights.shade", fail)
        with pytest.raises(RuntimeError, match="no memory"):
            renderer.render(OTHER_CAMERA)
    assert renderer.render(CAMERA).stats.skips["unchanged_camera"] == 0


@pytest.mark.parametrize("settings", [{}, {"clustering": Clustering.SPS}, {"method": Method.EXACT_VPL}])
def test_unchanged_lights_are_kept(room: DeviceScene, settings: dict[str, Any]) -> None:
    def frames(skip: Skips) -> list[Frame]:
        return [frame(room, skip, **settings, vpls=500), frame(room, skip, **settings, vpls=500)]

    usual, always = frames(EVERY_SKIP)[-1], frames(without("unchanged_lights"))[-1]
    assert usual.stats.skips["unchanged_lights"] == usual.stats.counts["vpls"] > 0
    assert always.stats.skips["unchanged_lights"] == 0
    assert ("light" in usual.stats.stage_ms, "light" in always.stats.stage_ms) == (False, True)
    assert usual.radiance().tobytes() == always.radiance().tobytes()


def test_a_set_that_a_renderer_holds_is_not_made_again(room: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu.vpl.light_sets.KEPT_VPLS", 1)
    renderer = Renderer(room, SIZE, RenderSettings(**QUALITY, seed=3))
    Renderer(room, (8, 8), RenderSettings(**QUALITY, seed=4))
    stats = renderer.render(CAMERA).stats
    assert "light" not in stats.stage_ms
    assert stats.skips["unchanged_lights"] > 0


@pytest.mark.parametrize("many", [True, False])
def test_light_sets_of_a_still_view_serve_several_frames_where_they_are_large_and_are_kept_for_the_next(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch, many: bool
) -> None:
    chosen = StillViewParameters(many_vpls=QUALITY["vpls"] + (0 if many else 1))
    monkeypatch.setattr("gpu.methods.fuzzy_lights.STILL_VIEW_PARAMETERS", chosen)
    a_set = chosen.frames_a_set

    def lights(skip: Skips, seed: int) -> list[bool]:
        kept, light_sets = [], LightSets(room)
        for _ in range(2):
            renderer = Renderer(room, SIZE, RenderSettings(**QUALITY, skip=skip, seed=seed), None, light_sets)
            accumulation = Accumulation(SIZE[0] * SIZE[1], room.device)
            for _ in range(a_set + 1):
                stats = renderer.render(CAMERA, accumulation).stats
                kept.append(stats.skips["unchanged_lights"] > 0)
        return kept

    first = a_set * [True] + [False] if many else [True] + a_set * [False]
    with noted_kernels():  # the host chooses
        assert lights(EVERY_SKIP, 7 + many) == [*first, *(a_set + 1) * [True]]
        assert not any(lights(without("unchanged_lights"), 9 + many))
