from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA
from scenes import box, grey, quad, resident_of

from gpu.adaptive.governor import ErrorGovernorParameters, Governor
from gpu.adaptive.levels import FOR_ERROR, FOR_TIME, Level
from gpu.core.kernel_loading import noted_kernels
from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages
from gpu.device_scene.upload import DeviceScene
from gpu.film.accumulation import Accumulation
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.targeted_vpl import KEPT_LIGHTS, TargetedViewState, TargetedVpl
from gpu.methods.view_state import ViewState
from gpu.renderer import Renderer
from gpu.sample_counts import ON_CPU
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Light, LightKind
from gpu.settings import Component, RenderSettings

SIZE = (32, 24)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
INDIRECT = {"component": Component.INDIRECT, "vpls": 800, "skip": {"unchanged_camera": False}}
RATE = 2e-3  # simulated milliseconds a pair of clusters
LEVELS: WeakKeyDictionary[Stages, list[Level]] = WeakKeyDictionary()


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    """A closed box with a lamp below its ceiling."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    return resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])


def set_clock(monkeypatch: pytest.MonkeyPatch, clock: Callable[[], float]) -> None:
    """Have the host take what `clock` says [s]."""
    own = {"own_time": clock, "active": False, "in_flight": 0}
    kept = {name: getattr(DEVICE_SHARING, name) for name in ("keep", "leave_until", "pause")}
    sharing = SimpleNamespace(**kept, **own)
    monkeypatch.setattr("gpu.renderer.DEVICE_SHARING", sharing)
    monkeypatch.setattr("gpu.methods.targeted_vpl.perf_counter", clock)


def steered(renderer: Renderer) -> tuple[TargetedVpl, TargetedViewState]:
    """The method of a renderer with a target, and the renderer's own view."""
    view = renderer._own_view = renderer._own_view or renderer.new_view()
    assert isinstance(renderer._method, TargetedVpl)
    assert isinstance(view, TargetedViewState)
    return renderer._method, view


def governor_of(renderer: Renderer) -> Governor[Any]:
    """What chooses the counts of its own view's frames."""
    method, view = steered(renderer)
    return method._governor(view)


@pytest.fixture(autouse=True)
def levels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stages whose times are simulated know the levels of their last two frames, and nothing else takes time."""
    set_clock(monkeypatch, lambda: 0.0)
    render = TargetedVpl.render

    def rendered(method: TargetedVpl, view: TargetedViewState, stages: Stages, sample: int) -> None:
        render(method, view, stages, sample)
        LEVELS[stages] = [*LEVELS.get(stages, [])[-1:], view.steering.level]

    monkeypatch.setattr(TargetedVpl, "render", rendered)


def parts_of(stages: Stages, rate: float = RATE) -> dict[str, float]:
    """What the stages of the last frame's level take, if it had one; rate: of a pair of clusters [ms]."""
    level = LEVELS[stages][-1] if stages in LEVELS else Level(0, 0)
    pairs = level.sp_clusters * level.vpl_clusters
    return {"fixed": 4.0, "correct": level.passes, "visibility": rate * pairs}


@pytest.fixture
def simulated_times(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames take what their pairs of clusters say, whatever this machine does meanwhile."""

    def milliseconds(stages: Stages) -> dict[str, float]:
        return parts_of(stages)

    monkeypatch.setattr(Stages, "milliseconds", milliseconds)


@pytest.fixture
def nothing_launched() -> Iterator[None]:
    """Times and counts are as they would be, and no picture is made."""
    with noted_kernels():
        yield


@pytest.mark.parametrize("target", [10.0, 40.0])
def test_the_first_picture_has_the_counts_that_meet_the_time(
    room: DeviceScene, nothing_launched: None, simulated_times: None, target: float
) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=target))
    for _ in range(2):
        stats = renderer.render(CAMERA).stats
        assert sum(stats.stage_ms.values()) == pytest.approx(target, rel=0.1)
        assert stats.counts["sp_clusters"] > 0
        assert stats.estimates["target_ms"] == target
        assert stats.estimates["expected_ms"] == pytest.approx(target, rel=0.1)


@pytest.mark.parametrize("walks", [False, True])
def test_walks_aim_at_a_little_less_time_and_all_frames_at_a_little_more_error(
    room: DeviceScene, nothing_launched: None, simulated_times: None, walks: bool
) -> None:
    for target, least, most in (
        ({"target_ms": 20.0}, *[19.6 if walks else 20.0] * 2),
        ({"target_error": 1e-3}, *[ErrorGovernorParameters().aim * 1e-3] * 2),
    ):
        renderer = Renderer(room, SIZE, RenderSettings.model_validate({**INDIRECT, **target}))
        for _ in range(2):
            renderer.render(CAMERA, walks=walks)
        assert least - 1e-9 < governor_of(renderer)._target < most + 1e-9


def test_what_the_host_takes_is_of_a_wanted_time(
    room: DeviceScene, nothing_launched: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    now, host = [0.0], 6.0

    def milliseconds(stages: Stages) -> dict[str, float]:
        times = parts_of(stages)
        # Loading kernels takes long, which is nothing that frames take.
        now[0] += 1e-3 * (sum(times.values()) + (host if stages.steady else 1000.0))
        return times

    monkeypatch.setattr(Stages, "milliseconds", milliseconds)
    set_clock(monkeypatch, lambda: now[0])
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0))
    for _ in range(3):
        stats = renderer.render(CAMERA).stats
    assert sum(stats.stage_ms.values()) == pytest.approx(20.0 - host, rel=0.1)
    assert stats.estimates["expected_ms"] == pytest.approx(20.0, rel=0.1)


def test_vpls_follow_a_time_but_stay_for_an_error(room: DeviceScene, simulated_times: None) -> None:
    def counts(**choice: float) -> dict[str, int]:
        settings = RenderSettings.model_validate({**INDIRECT, "vpls": None, **choice})
        return Renderer(room, SIZE, settings).render(CAMERA).stats.counts

    usual = ON_CPU.vpls / ON_CPU.vpl_clusters
    for target in (8.0, 60.0):
        timed = counts(target_ms=target)
        assert timed["vpls"] / timed["vpl_clusters"] == pytest.approx(usual, rel=0.1)
    for target in (1e-1, 1e-2):
        assert counts(target_error=target)["vpls"] == pytest.approx(ON_CPU.vpls, rel=0.1)


def test_a_time_has_no_levels_of_so_few_sp_clusters_that_they_save_nothing(room: DeviceScene) -> None:
    def share(**target: float) -> float:
        settings = RenderSettings.model_validate({**INDIRECT, "vpls": 2000, **target})
        targeted = steered(Renderer(room, (640, 480), settings))[0]
        number = targeted._levels.vpl_clusters[-1]
        return targeted._levels.usual(number).sp_clusters / targeted._levels.of(number)[0].sp_clusters

    assert share(target_ms=10.0) == pytest.approx(FOR_TIME.below, rel=0.06)
    assert share(target_error=1e-3) == pytest.approx(FOR_ERROR.below, rel=0.06)


def test_wanted_vpls_bound_the_clusters_of_them(
    room: DeviceScene, nothing_launched: None, simulated_times: None
) -> None:
    """Few of many members would be shaded member by member, and many of few members are VPLs."""
    for target in (5.0, 1e4):
        renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=target))
        members = [INDIRECT["vpls"] / renderer.render(CAMERA).stats.counts["vpl_clusters"] for _ in range(2)][-1]
        assert FOR_TIME.least_members <= members <= FOR_TIME.most_members


def test_levels_come_and_go_without_a_trace_in_the_picture(room: DeviceScene, simulated_times: None) -> None:
    """Counts shared among levels, graphs and arrays: a level met again gives the same bits, also when made anew."""
    targets = [6.0, 40.0]
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=40.0))
    pictures: dict[Level, list[bytes]] = {}
    governor = governor_of(renderer)
    for number in range(36):
        governor._target = targets[number // 9 % 2]
        frame = renderer.render(CAMERA)
        pictures.setdefault(steered(renderer)[1].steering.level, []).append(frame.radiance().tobytes())
        assert len(steered(renderer)[0]._kept) <= KEPT_LIGHTS
    assert len(pictures) > 2
    assert any(len(same) > 5 for same in pictures.values())
    assert all(len(set(same)) == 1 for same in pictures.values())
    plain = [level for level in pictures if level.passes == 1.0]
    assert 0 < len(plain) < len(pictures)
    for level in plain[:3]:
        choice = {**INDIRECT, "sp_clusters": level.sp_clusters, "vpl_clusters": level.vpl_clusters}
        alone = Renderer(room, SIZE, RenderSettings(**choice)).render(CAMERA).radiance()
        assert alone.tobytes() == pictures[level][0]


def test_what_is_launched_on_a_condition_comes_after_what_was_forked(
    room: DeviceScene, nothing_launched: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """CUDA refuses a graph with such a branch while something else is under way in it."""
    ran = list[str]()
    monkeypatch.setattr(Stages, "join", lambda _: ran.append("join"))
    monkeypatch.setattr(wp, "capture_if", lambda *_: ran.append("condition"))
    for targets in ({}, {"target_ms": 40.0}):
        Renderer(room, SIZE, RenderSettings(**INDIRECT, **targets)).render(CAMERA)
    assert ran[:2] == ["join", "condition"]


@NEEDS_CUDA
def test_captured_cuda_graphs_have_the_passes_of_each_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    room = resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)], device="cuda:0")
    monkeypatch.setattr(TargetedVpl, "_learn", lambda *_, **__: True)

    def pictures(passes: list[float]) -> list[bytes]:
        renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=40.0))
        found: list[bytes] = []
        for number in passes:
            governor_of(renderer).level = replace(steered(renderer)[1].steering.level, passes=number)
            found.append(renderer.render(CAMERA).radiance().tobytes())
        return found

    alone = {passes: pictures([passes])[0] for passes in (1.0, 1.5, 3.8)}
    assert len(set(alone.values())) == 3
    many = [1.0, 1.0, 1.0, 3.8, 1.5, 3.8, 1.0]
    assert pictures(many) == [alone[passes] for passes in many]


def test_what_a_walks_first_frame_of_a_level_takes_is_not_learnt(
    room: DeviceScene, nothing_launched: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes ten times as long; were that believed, the next frames would have far fewer clusters."""
    target, rate = 40.0, [RATE]

    def milliseconds(stages: Stages) -> dict[str, float]:
        times = 1.0 if len(set(LEVELS[stages])) == 1 else 10.0
        return parts_of(stages, times * rate[0])

    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=target))
    monkeypatch.setattr(Stages, "milliseconds", milliseconds)
    renderer.render(CAMERA)
    counts = []
    for number in range(40):
        if number == 10:
            rate[0] *= 2.0  # from here on there is a reason to change the level
        stats = renderer.render(CAMERA, walks=True).stats
        counts.append((stats.counts["sp_clusters"], stats.counts["vpl_clusters"]))
    assert len(set(counts[10:])) > 1
    assert len(set(counts[25:])) == 1
    assert stats.estimates["expected_ms"] == pytest.approx(target, rel=0.1)


def test_what_a_walks_first_picture_takes_is_not_learnt(
    room: DeviceScene, nothing_launched: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its camera comes back from where frames that nobody sees had swayed it, so that much is new."""
    seen = [False]

    def milliseconds(stages: Stages) -> dict[str, float]:
        return parts_of(stages, (1.5 if seen[0] else 1.0) * RATE)

    monkeypatch.setattr(Stages, "milliseconds", milliseconds)
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0))
    look = ViewState.set_camera

    def looked(view: ViewState, camera: Camera, *args: Any, **choices: Any) -> None:
        seen[0] = camera is CAMERA
        look(view, camera, *args, **choices)

    monkeypatch.setattr(ViewState, "set_camera", looked)
    counts = [renderer.render(CAMERA, walks=True).stats.counts["sp_clusters"]]
    counts.append(renderer.render(replace(CAMERA), walks=True).stats.counts["sp_clusters"])
    assert counts[0] == counts[1]


def test_counts_of_a_walk_are_chosen_by_frames_in_motion(
    room: DeviceScene, nothing_launched: None, simulated_times: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen, look = [], ViewState.set_camera

    def looked(view: ViewState, camera: Camera, *args: Any, **choices: Any) -> None:
        seen.append(camera.to_world.tobytes())
        look(view, camera, *args, **choices)

    monkeypatch.setattr(ViewState, "set_camera", looked)
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0))
    renderer.render(CAMERA)
    assert set(seen) == {CAMERA.to_world.tobytes()}
    seen.clear()
    renderer.render(CAMERA, walks=True)
    assert len(seen) > 2
    assert all(before != after for before, after in pairwise(seen))
    assert seen[-1] == CAMERA.to_world.tobytes()


def test_no_picture_waits_for_more_than_32_frames_that_nobody_sees(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    method, view = steered(Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0)))
    monkeypatch.setattr(TargetedVpl, "_learn", lambda *_, **__: False)
    stats = SimpleNamespace(counts={"frames": 1}, skips={"unchanged_camera": 0})
    for seen in (33, 1):
        frames: list[Camera] = []

        def once(camera: Camera, _: Accumulation | None, frames: list[Camera] = frames) -> Any:
            frames.append(camera)
            return SimpleNamespace(stats=stats)

        method.show(once, view, CAMERA, None, walks=False)
        assert len(frames) == seen


def test_a_walk_for_an_error_goes_on_with_what_its_first_picture_learnt(
    room: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its frames are as those of single pictures: none are rendered that nobody sees."""
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_error=4e-4))
    renderer.render(CAMERA)
    seen, look = [], ViewState.set_camera

    def looked(view: ViewState, camera: Camera, *args: Any, **choices: Any) -> None:
        seen.append(camera)
        look(view, camera, *args, **choices)

    monkeypatch.setattr(ViewState, "set_camera", looked)
    stats = renderer.render(CAMERA, walks=True).stats
    assert len(seen) == stats.estimates["tries"]
    assert stats.estimates["expected_error"] > 0.0


def test_frames_of_a_still_view_keep_the_counts_of_its_first(
    room: DeviceScene, nothing_launched: None, simulated_times: None
) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0))
    accumulation = Accumulation(SIZE[0] * SIZE[1], room.device)
    first = renderer.render(CAMERA, accumulation).stats.counts
    governor = governor_of(renderer)
    governor._target = 6.0
    later = [renderer.render(CAMERA, accumulation).stats.counts["sp_clusters"] for _ in range(3)]
    assert set(later) == {first["sp_clusters"]}
    assert accumulation.samples == 4
    counts = [renderer.render(CAMERA).stats.counts["sp_clusters"] for _ in range(4)]
    assert counts[-1] < counts[0]


def test_an_error_is_met_by_more_clusters_for_less_of_it(room: DeviceScene) -> None:
    def work(target: float) -> float:
        renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_error=target))
        stats = [renderer.render(CAMERA).stats for _ in range(3)][-1]
        assert stats.estimates["target_error"] == target
        assert stats.estimates["expected_error"] > 0.0
        return float(stats.counts["sp_clusters"] * stats.counts["vpl_clusters"])

    assert work(3e-3) < work(1e-4)


def test_a_scene_without_indirect_light_meets_any_error() -> None:
    dark = resident_of(box(), [grey(0.7)], lights=[Light("off", LightKind.POINT, (0.0, 0.0, 0.0))])
    frame = Renderer(dark, SIZE, RenderSettings(**INDIRECT, target_error=1e-3)).render(CAMERA)
    assert np.all(frame.radiance() == 0.0)


@pytest.mark.parametrize("step", [1.2, 1.0 / 1.2])
def test_a_walk_goes_on_where_its_counts_change(room: DeviceScene, simulated_times: None, step: float) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0))
    _, view = steered(renderer)
    for _ in range(4):
        frame = renderer.render(CAMERA, walks=True)
    level = view.steering.level
    changed = governor_of(renderer).level = replace(level, sp_clusters=round(level.sp_clusters * step))
    picture = renderer.render(CAMERA, walks=True)
    assert picture.stats.counts["sp_clusters"] == changed.sp_clusters
    kept = frame.stats.skips["kept_clusters"], picture.stats.skips["kept_clusters"]
    assert kept[1] > 0.8 * kept[0] * min(1.0, step)
    assert np.abs(picture.radiance() - frame.radiance()).mean() < 0.05 * frame.radiance().mean()
    # Other lights see other things.
    governor_of(renderer).level = replace(changed, vpl_clusters=level.vpl_clusters + 32)
    assert renderer.render(CAMERA, walks=True).stats.skips["kept_clusters"] == 0
    governor_of(renderer).level = changed
    assert renderer.render(CAMERA, walks=True).stats.skips["kept_clusters"] == 0


def test_lights_that_cannot_be_made_leave_those_that_there_are(
    room: DeviceScene, nothing_launched: None, simulated_times: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_ms=20.0))
    _, view = steered(renderer)
    renderer.render(CAMERA)
    level = view.steering.level
    other = governor_of(renderer).level = replace(level, vpl_clusters=level.vpl_clusters + 64)

    def fails(*_: Any) -> None:
        raise MemoryError

    with monkeypatch.context() as patch:
        patch.setattr(FuzzyVpl, "make_lights", fails)
        with pytest.raises(MemoryError):
            renderer.render(CAMERA)
    assert view.steering.level == level
    counts = renderer.render(CAMERA).stats.counts
    assert (counts["sp_clusters"], view.steering.level) == (other.sp_clusters, other)
    assert counts["vpl_clusters"] != level.vpl_clusters


def test_more_sp_clusters_than_there_is_room_for_are_refused(room: DeviceScene, nothing_launched: None) -> None:
    renderer = Renderer(room, SIZE, RenderSettings.model_validate({**INDIRECT, "target_ms": 20.0}))
    lights = steered(renderer)[0]._method.lights
    lights.check_room(lights.room[0])
    lights.room = 10, lights.room[1]
    with pytest.raises(ValueError, match="SP clusters where there is room for 10"):
        renderer.render(CAMERA)


def test_frames_that_are_not_rendered_tell_nothing_of_the_host(
    room: DeviceScene, nothing_launched: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor do later frames of a still view: neither is of a wanted time."""
    now = [0.0]

    def milliseconds(stages: Stages) -> dict[str, float]:
        now[0] += 1e-3 * (10.0 + 6.0 * (len(stages._order) > 1))
        return {"fixed": 10.0}

    monkeypatch.setattr(Stages, "milliseconds", milliseconds)
    set_clock(monkeypatch, lambda: now[0])
    renderer = Renderer(room, SIZE, RenderSettings(component=Component.INDIRECT, vpls=2000, target_ms=20.0))
    accumulation = Accumulation(SIZE[0] * SIZE[1], room.device)
    for _ in range(4):
        renderer.render(CAMERA, accumulation)
    renderer.render(CAMERA)
    known = list(steered(renderer)[1].steering.host_ms[False])
    for _ in range(3):
        assert renderer.render(CAMERA).stats.skips["unchanged_camera"] > 0
    for _ in range(3):
        assert renderer.render(CAMERA, accumulation).stats.counts["frames"] > 4
    assert list(steered(renderer)[1].steering.host_ms[False]) == known
    assert max(known) == pytest.approx(6.0)


def test_walks_for_an_error_keep_clusters_but_no_light(room: DeviceScene) -> None:
    for target, remembers in ({"target_error": 1e-3}, False), ({"target_ms": 1e4}, True):
        settings = RenderSettings.model_validate({**INDIRECT, **target})
        renderer = Renderer(room, SIZE, settings)
        skips = [renderer.render(CAMERA, walks=True).stats for _ in range(4)][-1].skips
        assert skips["kept_clusters"] > 0
        assert skips["unchanged_lights"] > 0
        assert (skips["temporal_reuse"] > 0) == remembers


def test_counts_of_a_walk_follow_its_error(room: DeviceScene) -> None:
    """What none meets ends at the most and at the fewest counts, and is told."""
    last = []
    for target in (2e-4, 2e-3):
        renderer = Renderer(room, SIZE, RenderSettings(**INDIRECT, target_error=target))
        last.append([renderer.render(CAMERA, walks=True).stats for _ in range(12)][-1])
        assert last[-1].estimates["target_error"] == target
        assert last[-1].stage_ms["probe"] > 0.0
    many, few = last
    assert many.counts["vpl_clusters"] > few.counts["vpl_clusters"]
    assert many.counts["sp_clusters"] > 10 * few.counts["sp_clusters"]
    assert 2e-4 < many.estimates["expected_error"] < few.estimates["expected_error"] < 1.2 * 2e-3
