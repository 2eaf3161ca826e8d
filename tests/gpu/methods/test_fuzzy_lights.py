"""Pictures of a walk, whose frames keep clusters of those before."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import slats
from walking import SIZE, furnished, pose

from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.methods.frame_kind import StillViewParameters
from gpu.methods.fuzzy_lights import frames_a_set
from gpu.renderer import Renderer
from gpu.sample_counts import ON_CUDA
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles
from gpu.settings import Clustering, Component, Method, RenderSettings, Skips

QUALITY = {"sp_clusters": 300, "vpls": 2000, "vpl_clusters": 100, "component": Component.INDIRECT}


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return furnished()


def settings(**changes: object) -> RenderSettings:
    return RenderSettings(**{**QUALITY, **changes})


def alone(room: DeviceScene, camera: Camera, **changes: object) -> bytes:
    return Renderer(room, SIZE, settings(**changes)).render(camera).radiance().tobytes()


def test_a_walk_counts_what_it_keeps(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, settings())
    first, second = (renderer.render(pose(number), walks=True).stats for number in range(2))
    assert first.skips["kept_clusters"] == 0
    assert second.skips["kept_clusters"] > 0.45 * 300 * 100
    assert 0 < second.counts["rays"] < 0.3 * first.counts["rays"]
    pairs = second.counts["rays"] + sum(
        second.skips[name] for name in ("kept_clusters", "facing_away", "shared_weak_rays")
    )
    assert pairs % 100 == 0
    assert 0.5 * 300 * 100 < pairs <= 300 * 100
    assert second.counts["unassigned"] == 0


def test_the_same_walk_gives_the_same_bits_and_without_the_skip_those_of_single_pictures(room: DeviceScene) -> None:
    def walk(**changes: object) -> list[bytes]:
        renderer = Renderer(room, SIZE, settings(**changes))
        return [renderer.render(pose(number), walks=True).radiance().tobytes() for number in range(3)]

    singles = [alone(room, pose(number)) for number in range(3)]
    kept = walk()
    assert kept == walk()
    assert [bits == single for bits, single in zip(kept, singles, strict=True)] == [True, False, False]
    assert walk(skip=Skips(kept_clusters=False, temporal_reuse=False)) == singles
    # Other lights might be other bits.
    assert walk(skip=Skips(unchanged_lights=False, temporal_reuse=False)) == singles


def test_a_picture_that_is_of_no_walk_depends_on_nothing_before(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, settings())
    for number in range(3):
        renderer.render(pose(number), walks=True)
    frame = renderer.render(pose(2))  # the view that is shown
    assert frame.stats.skips["unchanged_camera"] == frame.stats.skips["kept_clusters"] == 0
    assert frame.radiance().tobytes() == alone(room, pose(2))
    assert renderer.render(pose(2)).stats.skips["unchanged_camera"] > 0
    assert renderer.render(pose(3), walks=True).stats.skips["kept_clusters"] > 0
    assert renderer.render(pose(4)).radiance().tobytes() == alone(room, pose(4))


def test_a_jump_begins_anew(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, settings())
    renderer.render(pose(0), walks=True)
    back = look_at((0.0, 0.0, -0.4), (0.0, 0.0, 0.5))
    frame = renderer.render(back, walks=True)
    assert frame.stats.skips["kept_clusters"] == 0
    assert frame.radiance().tobytes() == alone(room, back)


def test_a_walk_begins_anew_after_frames_of_other_lights(room: DeviceScene) -> None:
    renderer = Renderer(room, SIZE, settings())
    accumulation = Accumulation(SIZE[0] * SIZE[1], room.device)
    for _ in range(2):
        renderer.render(pose(0), accumulation)
    assert renderer.render(pose(1), walks=True).radiance().tobytes() == alone(room, pose(1))
    assert renderer.render(pose(2), walks=True).stats.skips["kept_clusters"] > 0


def test_light_sets_as_large_as_a_gpus_serve_four_frames_and_half_as_large_ones_one() -> None:
    assert (frames_a_set(ON_CUDA.vpls), frames_a_set(ON_CUDA.vpls // 2)) == (4, 1)


@pytest.mark.parametrize("clustering", [Clustering.BOTH, Clustering.SPS])
def test_frames_of_a_still_view_keep_the_clusters_of_their_light_set(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch, clustering: Clustering
) -> None:
    """The first four are smoothed, and a light set serves four; without VPL clusters there is one for all."""
    monkeypatch.setattr("gpu.methods.fuzzy_lights.STILL_VIEW_PARAMETERS", StillViewParameters(many_vpls=0))

    few, size = settings(clustering=clustering, sp_clusters=100, vpls=400), (32, 24)

    def kept(choice: RenderSettings, *, interrupted: bool = False) -> list[bool]:
        renderer, accumulation = Renderer(room, size, choice), Accumulation(size[0] * size[1], room.device)
        found = []
        for number in range(10):
            if interrupted and number == 6:
                renderer.render(pose(1))
            found.append(renderer.render(pose(0), accumulation).stats.skips["kept_clusters"] > 0)
        return found

    assert [number for number, goes_on in enumerate(kept(few)) if goes_on] == [5, 6, 7, 9]
    interrupted = kept(few, interrupted=True)
    assert [number for number, goes_on in enumerate(interrupted) if goes_on] == [5, 7, 9]
    assert not any(kept(few.model_copy(update={"skip": Skips(kept_clusters=False)})))


def test_a_walk_that_failed_begins_anew(room: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("no memory")

    renderer = Renderer(room, SIZE, settings())
    renderer.render(pose(0), walks=True)
    with monkeypatch.context() as patched:
        patched.setattr("gpu.indirect.visibility.Visibility.trace", fail)
        with pytest.raises(RuntimeError, match="no memory"):
            renderer.render(pose(1), walks=True)
    assert renderer.render(pose(2), walks=True).radiance().tobytes() == alone(room, pose(2))


def error(frame: Frame, reference: Doubles) -> float:
    picture = frame.radiance()
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2)))


@pytest.mark.parametrize(("of", "bound"), [("room", 1.1), ("slats", 1.6)])
def test_after_a_long_walk_the_picture_is_about_as_good_as_that_of_a_new_renderer(of: str, bound: float) -> None:
    """Slats as thin as a pixel come and go with every step, so their clusters do."""
    device_scene, camera, size = slats() if of == "slats" else (furnished(), pose(0), SIZE)
    choice = settings(sp_clusters=150, vpls=1000, vpl_clusters=300, near_field=False, skip=Skips(temporal_reuse=False))

    def at(number: int) -> Camera:
        to_world = camera.to_world.copy()
        to_world[:3, 3] += to_world[:3, 0] * 0.004 * (18 - abs(number - 18))
        return replace(camera, to_world=to_world)

    walking, new = Renderer(device_scene, size, choice), Renderer(device_scene, size, choice)
    exact = Renderer(device_scene, size, choice.model_copy(update={"method": Method.EXACT_VPL}))
    errors = []
    for number in range(36):
        frame = walking.render(at(number), walks=True)
        if number >= 24 and number % 3 == 0:
            assert frame.stats.skips["kept_clusters"] > 0
            reference = exact.render(at(number)).radiance()
            errors.append((error(frame, reference), error(new.render(at(number)), reference)))
    kept, usual = np.mean(errors, axis=0)
    assert kept < bound * usual
