"""Two rooms side by side with a slit between them; the lamp is in the one and the camera in the other."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_paths import Vpls
from gpu.scene.camera import look_at
from gpu.scene.edits import LightEdit, SceneEdits, edited
from gpu.scene.types import Camera, Doubles, Light, LightKind
from gpu.vpl.light_set import LightSet, LightSetChoice
from gpu.vpl.light_sets import LightSets
from gpu.vpl.seen_paths import (
    LEAST_MORE,
    SEEN_PARAMETERS,
    PathPlan,
    SeenPathEnds,
    SeenPilot,
    paths_worth_tracing,
    walked,
    worth_kept,
)

LAMP = Light("lamp", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.4, 0.2, -0.2))
DARK, BRIGHT = (look_at((x, 0.0, 0.3), (x, 0.0, -0.3)) for x in (-0.1, 0.3))
PATHS, BOUNCES = 4000, 4


def rooms(*cameras: Camera, slit: float = 0.02) -> DeviceScene:
    """The wall between the rooms is at x = 0.1."""
    wall = quad((0.1, -0.5, -0.5), (0.0, 0.0, 1.0 - slit), (0.0, 1.0, 0.0))
    return DeviceScene(replace(scene_of([*box(), wall], [grey(0.7)], [LAMP]), cameras=cameras), "cpu")


def ends_of(device_scene: DeviceScene, plan: PathPlan | None, seed: int = 0) -> SeenPathEnds:
    """What PATHS paths leave, of which a plan keeps a part."""
    ends = SeenPathEnds(PATHS, BOUNCES, walked(device_scene), whole=False)
    if plan is not None:
        ends.follow(plan)
    features = device_scene.generalised().features(lambertian=False)
    ends.trace(device_scene.data, build_light_table(device_scene), wp.array([seed], dtype=int, device="cpu"), features)
    return ends


def traced(device_scene: DeviceScene, plan: PathPlan | None, seed: int = 0) -> tuple[Doubles, Doubles]:
    """Positions (vpl, 3) and flux (vpl,) of `ends_of`."""
    ends = ends_of(device_scene, plan, seed)
    raw: Vpls = ends.raw
    kept = ends.order.numpy()[: ends.count()]
    return raw.position.numpy()[kept].astype(np.float64), raw.flux.numpy()[kept].mean(axis=1).astype(np.float64)


def by_worth(device_scene: DeviceScene) -> PathPlan:
    """That of as many VPLs as a fifth of what is traced, half of them by their worth."""
    ends = ends_of(device_scene, None)
    carried, worth = (each.numpy()[: ends.count()].astype(np.float64) for each in (ends.carried, ends.worth))
    return PathPlan(PATHS, 0.1, worth_kept(carried, worth, 0.1, 0.2 * len(worth)))


def test_of_what_lights_nothing_that_is_seen_little_is_left_and_carries_as_much() -> None:
    device_scene = rooms(DARK)
    whole, brought = traced(device_scene, None)
    left, carried = traced(device_scene, by_worth(device_scene))
    assert len(left) == pytest.approx(0.2 * len(whole), rel=0.05)
    assert carried.sum() == pytest.approx(brought.sum(), rel=0.05)
    in_dark, still = whole[:, 0] < 0.08, left[:, 0] < 0.08
    assert still.sum() > 0.7 * in_dark.sum() > 0  # where the camera is, most are
    assert carried[still].sum() == pytest.approx(brought[in_dark].sum(), rel=0.1)


def test_what_carries_more_is_kept_rather() -> None:
    worth = np.repeat([1.0, 10.0, 1000.0], [900, 90, 10])
    kept = worth_kept(worth, worth, 0.05, 150.0)
    chances = np.minimum(0.05 + np.unique(worth) / kept, 1.0)
    assert chances @ (900, 90, 10) == pytest.approx(150.0, rel=1e-3)
    assert 0.05 < chances[0] < chances[1] < chances[2] == 1.0


@pytest.mark.parametrize(
    ("carried", "worth", "more"),
    [
        (np.ones(100), np.ones(100), 1.0),
        (np.ones(100), 0.4 * np.ones(100), 2.5),
        (np.ones(100), np.full(100, 0.01), SEEN_PARAMETERS.most),
        (np.repeat([1.0, 1000.0], [99, 1]), np.repeat([1.0, 1000.0], [99, 1]), SEEN_PARAMETERS.most),
        (np.zeros(0), np.zeros(0), 1.0),
    ],
)
def test_the_less_counts_the_more_paths_are_traced(carried: Doubles, worth: Doubles, more: float) -> None:
    assert paths_worth_tracing(carried, worth) == pytest.approx(more)


def test_each_seed_leaves_others() -> None:
    device_scene = rooms(DARK)
    plan = by_worth(device_scene)
    one, other = (traced(device_scene, plan, seed)[0] for seed in (1, 2))
    assert len(one) != len(other) or not np.array_equal(one, other)


def planned(*cameras: Camera) -> PathPlan:
    return plan_of(rooms(*cameras))


def plan_of(device_scene: DeviceScene) -> PathPlan:
    """For a thousand VPLs."""
    features = device_scene.generalised().features(lambertian=False)
    pilot = SeenPilot(BOUNCES, walked(device_scene))
    pilot.trace(device_scene.data, build_light_table(device_scene), features)
    return pilot.plan(1000)


def test_where_all_matters_or_none_can_tell_nothing_is_left_out() -> None:
    bright, without, dark = planned(BRIGHT), planned(), planned(DARK)
    assert bright == without == PathPlan(bright.paths)
    assert bright.keeps_all
    assert not dark.keeps_all
    assert dark.paths >= LEAST_MORE * bright.paths > 0


def test_where_cameras_see_nothing_nothing_is_left_out() -> None:
    assert planned(look_at((0.6, 0.0, 0.0), (1.0, 0.0, 0.0))).keeps_all


def test_where_few_paths_meet_anything_no_more_are_traced_than_there_is_room_for() -> None:
    lit, dark = (quad((-0.05, -0.2, z), (0.0, 0.0, 0.1), (0.1, 0.0, 0.0)) for z in (-0.5, 0.4))
    wall = quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    lamp = replace(LAMP, position=(0.0, 0.2, -0.45), kind=LightKind.SPOT, direction=(0.0, 0.0, -1.0))
    scene = scene_of([lit, dark, wall], [grey(0.7)], [lamp])
    camera = look_at((0.0, 0.0, 0.45), (0.0, -0.2, 0.45))
    plan = plan_of(DeviceScene(replace(scene, cameras=(camera,)), "cpu"))
    assert plan == PathPlan(16_000)


def test_a_light_set_has_as_many_vpls_as_are_wanted_and_more_of_them_where_the_camera_is() -> None:
    inside = []
    for camera in (DARK, BRIGHT):
        light_set = LightSets(rooms(camera)).made(LightSetChoice(4096, 64, BOUNCES, 0, False), lambda *_: None)
        assert light_set.count == pytest.approx(4096, rel=0.15)
        members = light_set.clusters.members
        inside.append(int((members.position.numpy()[: light_set.count, 0] < 0.08).sum()))
    assert inside[0] > 2 * inside[1] > 0


def test_portals_follow_a_lamp_that_is_moved() -> None:
    base, told = rooms(DARK), list[str]()
    sets, choice = LightSets(base), LightSetChoice(2000, 32, BOUNCES, 0, False)

    def run(name: str, part: Callable[[], None]) -> None:
        told.append(name)
        part()

    def made(*position: float) -> bytes:
        if position:
            moved = SceneEdits(lights={"lamp": LightEdit(position=position)})
            assert sets.follow(base.edited(edited(base.scene, moved)))
        told.clear()
        light_set = sets.at(choice)
        sets.renew(light_set, lambda *_: None, run)
        return light_set.clusters.members.flux.numpy()[: light_set.count].tobytes()

    first = made()
    assert told[:3] == ["pilot", "portals", "light"]
    made(-0.3, 0.2, -0.2)
    assert "portals" not in told
    made(0.4, 0.2, -0.2)
    assert "portals" in told
    assert made(*LAMP.position) == first


def test_a_lamp_that_goes_in_and_out_of_view_needs_no_arrays_again_and_has_the_bits_of_one_that_is_there() -> None:
    base, choice = rooms(DARK), LightSetChoice(2000, 32, BOUNCES, 0, False)
    inside = SceneEdits(lights={"lamp": LightEdit(position=(-0.3, 0.2, -0.2))})

    def flux(light_set: LightSet) -> bytes:
        return light_set.clusters.members.flux.numpy()[: light_set.count].tobytes()

    sets, numbers = LightSets(base), set[tuple[int, int]]()
    behind, seen = base.edited(base.scene), base.edited(edited(base.scene, inside))
    anew = flux(LightSets(seen).made(choice, lambda *_: None))
    for state in (seen, behind) * 3:
        assert sets.follow(state)
        light_set = sets.made(choice, lambda *_: None)
        numbers.add(light_set.numbers)
        assert state is behind or flux(light_set) == anew
    assert len(numbers) <= 2
