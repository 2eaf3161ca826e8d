import gc
from collections.abc import Callable
from dataclasses import replace
from typing import Any
from weakref import ref

import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA, wait_kernel
from scenes import box, grey, quad, resident_of

from gpu.core.device import launch
from gpu.core.lane import Lane
from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import LightEdit, ObjectEdit, SceneEdits, edited
from gpu.scene.types import Light, LightKind, Material, Scene, Sky
from gpu.vpl.light_set import LightSetChoice
from gpu.vpl.light_sets import LightSets
from gpu.vpl.seen_paths import PathPlan, SeenPilot

CHOICE = LightSetChoice(vpls=300, vpl_clusters=10, bounces=2, seed=0, lambertian=True)


def moved_inwards(by: float) -> SceneEdits:
    return SceneEdits(objects={"corner": ObjectEdit(offset=(-by, -by, -by)), "mesh": ObjectEdit(offset=(by, by, by))})


def silent(what: str, fraction: float) -> None:
    pass


@pytest.fixture
def device_scene() -> DeviceScene:
    return resident_of(box(), [grey(0.5, emission=1.0)])


def test_a_light_set_is_made_once_and_its_making_is_told(device_scene: DeviceScene) -> None:
    light_sets = LightSets(device_scene)
    told: list[tuple[str, float]] = []
    made = light_sets.clusters(CHOICE, lambda what, fraction: told.append((what, fraction)))
    assert 0 < made.count <= CHOICE.vpl_clusters
    assert told[0][1] == 0.0
    assert told[-1][1] == 1.0
    told.clear()
    assert light_sets.clusters(replace(CHOICE), lambda what, fraction: told.append((what, fraction))) is made
    assert told == []


def test_sets_that_differ_by_their_seed_need_one_pilot(
    device_scene: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[object] = []
    inner = SeenPilot.plan

    def counted(pilot: SeenPilot, wanted: int, *others: Any) -> PathPlan:
        calls.append(pilot)
        return inner(pilot, wanted, *others)

    monkeypatch.setattr(SeenPilot, "plan", counted)
    light_sets = LightSets(device_scene)
    for choice in (CHOICE, replace(CHOICE, seed=1), replace(CHOICE, vpls=500)):
        assert light_sets.clusters(choice, silent).members.count == pytest.approx(choice.vpls, rel=0.1)
    assert len(calls) == 2


def test_of_many_numbers_of_vpls_the_plans_of_the_last_are_kept(
    device_scene: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    planned: list[int] = []
    inner = SeenPilot.plan

    def noted(pilot: SeenPilot, wanted: int) -> PathPlan:
        planned.append(wanted)
        return inner(pilot, wanted)

    monkeypatch.setattr(SeenPilot, "plan", noted)
    monkeypatch.setattr("gpu.vpl.light_sets.KEPT_PLANS", 2)
    light_sets = LightSets(device_scene)
    for seed, vpls in enumerate((100, 101, 102, 102, 101, 100)):
        light_sets.made(replace(CHOICE, vpls=vpls, seed=seed), silent)
    assert planned == [100, 101, 102, 100]


def test_a_set_is_renewed_in_its_own_arrays(device_scene: DeviceScene) -> None:
    light_sets = LightSets(device_scene)
    light_set = light_sets.at(CHOICE)
    assert not light_sets.is_current(light_set)
    light_sets.renew(light_set, silent)
    assert light_sets.is_current(light_set)
    made = light_sets.clusters(CHOICE, silent)
    positions, fluxes = made.disks.numpy(), made.members.flux.numpy()
    made.disks.zero_()
    made.members.flux.zero_()
    light_sets.renew(light_set, silent)
    assert light_sets.clusters(CHOICE, silent) is made
    assert made.disks.numpy().tobytes() == positions.tobytes()
    assert made.members.flux.numpy().tobytes() == fluxes.tobytes()


@NEEDS_CUDA
def test_the_number_of_vpls_is_waited_for_and_no_other_stream(device_scene: DeviceScene) -> None:
    lights = (Light("bulb", LightKind.POINT, (0.05, 0.1, 0.05), (0.2, 0.2, 0.0)),)
    base = DeviceScene(replace(device_scene.scene, lights=lights), "cuda:0")
    light_sets, busy = LightSets(base.edited(base.scene)), wp.zeros(1, dtype=float, device=base.device)
    light_set, lane, late = light_sets.made(CHOICE, silent), Lane(base.device), list[bool]()

    def run(name: str, part: Callable[[], None]) -> None:
        if name == "vpl-clusters":
            late.append(not lane.ahead.is_complete)
        part()

    for step in range(5):
        moved = SceneEdits(lights={"bulb": LightEdit(position=(0.1, 0.05 * step, 0.0))})
        assert light_sets.follow(base.edited(edited(base.scene, moved)))
        wp.synchronize_device(base.device)
        with wp.ScopedStream(lane.ahead):
            launch(wait_kernel, 1, [1 << 23, busy], base.device)
        with lane.entered():
            light_sets.renew(light_set, silent, run)
        wp.synchronize_device(base.device)
    assert late[-1]


def test_a_set_that_was_left_open_and_never_settled_is_made_anew(device_scene: DeviceScene) -> None:
    light_sets = LightSets(device_scene)
    light_set = light_sets.made(CHOICE, silent)
    light_sets.leave_open(light_set)
    light_sets.settle()
    light_sets.wait_for_made()
    assert light_sets.is_current(light_set)
    light_sets.leave_open(light_set)
    light_sets.wait_for_made()
    assert not light_sets.is_current(light_set)


def test_dimming_a_light_traces_no_path_and_moves_no_cluster(device_scene: DeviceScene) -> None:
    bulb = Light("bulb", LightKind.POINT, (0.05, 0.1, 0.05), (0.2, 0.2, 0.0))
    scene = replace(device_scene.scene, lights=(bulb,))
    base = DeviceScene(scene, "cpu")
    light_sets = LightSets(base.edited(scene))
    light_set = light_sets.made(CHOICE, silent)
    light_sets.radiosity(light_set)
    told: list[str] = []

    def run(name: str, part: Callable[[], None]) -> None:
        told.append(name)
        part()

    def kept() -> dict[str, bytes]:
        clusters = light_set.clusters
        arrays = {name: getattr(clusters.members, name) for name in ("position", "normal", "bounce", "light")}
        arrays |= {name: getattr(clusters, name) for name in ("path_flux", "member_area", "starts", "centre", "radius")}
        disks = {name: clusters.disks.numpy()[name] for name in ("position", "normal", "area", "radius", "tilt")}
        values = {name: array.numpy() for name, array in arrays.items()} | disks
        return {name: value.tobytes() for name, value in values.items()}

    before, flux, paths = (
        kept(),
        light_set.clusters.members.flux.numpy().copy(),
        light_set.clusters.members.light.numpy(),
    )
    assert set(paths) == {0, len(scene.materials) + 1}
    dimmed = SceneEdits(lights={"bulb": LightEdit(intensity=0.5)})
    assert light_sets.follow(base.edited(edited(scene, dimmed)))
    assert not light_sets.is_current(light_set)
    light_sets.renew(light_set, silent, run)
    assert told == ["relight"]
    assert kept() == before
    share = np.where(paths == 0, 1.0, 0.5)[:, None]
    assert np.allclose(light_set.clusters.members.flux.numpy(), flux * share, rtol=1e-6)
    assert np.allclose(light_set.clusters.disks.numpy()["flux"].sum(axis=0), (flux * share).sum(axis=0), rtol=1e-4)
    moved = SceneEdits(lights={"bulb": LightEdit(position=(0.1, 0.2, 0.0))})
    assert light_sets.follow(base.edited(edited(scene, moved)))
    light_sets.renew(light_set, silent, run)
    assert told == ["relight", "pilot", "light", "vpl-clusters", "radiosity"]


def test_a_file_that_says_what_edits_say_has_as_much_light_by_other_paths(device_scene: DeviceScene) -> None:
    choice = replace(CHOICE, vpls=5000, vpl_clusters=50)
    scene = replace(device_scene.scene, lights=(Light("bulb", LightKind.POINT, (2.0, 1.0, 2.0), (0.2, 0.2, 0.0)),))
    dimmed = edited(scene, SceneEdits(lights={"bulb": LightEdit(intensity=0.2)}))
    (bulb,) = dimmed.lights
    says_so = replace(scene, lights=(replace(bulb, path_color=None),))
    sets = [LightSets(DeviceScene(one, "cpu")).clusters(choice, silent) for one in (dimmed, says_so)]
    edit, file = (one.members for one in sets)
    numbers = [np.count_nonzero(one.light.numpy()[: one.count]) for one in (edit, file)]
    assert numbers[0] > 2.0 * numbers[1]
    for light in (0, len(scene.materials) + 1):
        sums = [
            one.flux.numpy()[: one.count][one.light.numpy()[: one.count] == light].sum(axis=0) for one in (edit, file)
        ]
        assert sums[0] == pytest.approx(sums[1], rel=0.05)


def test_a_sky_of_another_date_is_followed_and_has_the_bits_of_one_put_there_anew() -> None:
    walls = box()
    del walls[3]
    base = resident_of(walls, [grey(0.5)], sky=Sky((1.0, 1.0, 1.0)))

    def at(hour: int) -> Scene:
        sky = LightEdit.model_validate({"date": f"2026-06-21T{hour}:00:00Z", "place": (48.0, 11.6)})
        return edited(base.scene, SceneEdits(lights={"sky": sky}))

    sets = LightSets(base.edited(at(10)))
    before = sets.made(CHOICE, silent).clusters.members.flux.numpy().tobytes()
    assert sets.follow(base.edited(at(18)))
    after, anew = (one.made(CHOICE, silent).clusters for one in (sets, LightSets(DeviceScene(at(18), "cpu"))))
    assert (
        after.members.flux.numpy()[: after.members.count].tobytes()
        == anew.members.flux.numpy()[: anew.members.count].tobytes()
    )
    assert before != after.members.flux.numpy().tobytes()
    assert not LightSets(base.edited(base.scene)).follow(base.edited(at(10)))


def test_a_scene_that_becomes_wider_keeps_its_arrays() -> None:
    """As animated ones do in most frames."""
    corner = replace(quad((0.1, 0.1, 0.1), (0.0, 0.0, 0.4), (0.4, 0.0, 0.0)), name="corner")
    wall = quad((-0.3, -0.3, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0))
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    base = resident_of([wall, corner], [grey(0.5)], lights=[sun])
    light_sets = LightSets(base.edited(edited(base.scene, moved_inwards(0.2))))
    radius = light_sets.table.radius
    before = float(radius.numpy()[0])
    assert light_sets.follow(base.edited(edited(base.scene, moved_inwards(0.1))))
    assert light_sets.table.radius is radius
    assert radius.numpy()[0] > 1.05 * before


@pytest.mark.parametrize("change", [{"vpls": 500}, {"vpl_clusters": 20}, {"bounces": 3}, {"seed": 1}])
def test_another_choice_is_another_set(device_scene: DeviceScene, change: dict[str, int]) -> None:
    light_sets = LightSets(device_scene)
    one, other = light_sets.clusters(CHOICE, silent), light_sets.clusters(replace(CHOICE, **change), silent)
    assert one is not other
    assert one.disks.numpy().tobytes() != other.disks.numpy().tobytes()


def test_unlit_surfaces_reflect_only_as_lambertian_ones() -> None:
    bulb = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0))
    device_scene = resident_of(box(), [Material(base_color=(0.5, 0.5, 0.5, 1.0), unlit=True)], lights=[bulb])
    light_sets = LightSets(device_scene)
    assert light_sets.clusters(CHOICE, silent).count > 0
    assert light_sets.clusters(replace(CHOICE, lambertian=False), silent).count == 0


def test_few_sets_are_kept_and_the_longest_unused_goes_first(
    device_scene: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gpu.vpl.light_sets.KEPT_VPLS", 4 * CHOICE.vpls)
    light_sets = LightSets(device_scene)
    sets = [light_sets.clusters(replace(CHOICE, seed=seed), silent) for seed in range(4)]
    assert light_sets.clusters(CHOICE, silent) is sets[0]
    light_sets.clusters(replace(CHOICE, seed=4), silent)
    assert light_sets.clusters(CHOICE, silent) is sets[0]
    assert light_sets.clusters(replace(CHOICE, seed=1), silent) is not sets[1]
    assert light_sets.clusters(replace(CHOICE, seed=3), silent) is sets[3]


def test_what_has_made_a_set_goes_with_it(device_scene: DeviceScene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Viewers may ask for any number of VPLs, one after the other."""
    monkeypatch.setattr("gpu.vpl.light_sets.KEPT_VPLS", 2 * CHOICE.vpls)
    light_sets = LightSets(device_scene)
    for number in range(5):
        light_sets.clusters(replace(CHOICE, vpls=CHOICE.vpls - number), silent)
    assert len(light_sets._makers) == 2


def test_a_set_larger_than_what_is_kept_is_still_made(
    device_scene: DeviceScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gpu.vpl.light_sets.KEPT_VPLS", 1)
    assert LightSets(device_scene).clusters(CHOICE, silent).count > 0


def test_a_scene_that_nobody_holds_is_freed_at_once_with_its_lighting() -> None:
    device_scene = resident_of(box(), [grey(0.5, emission=1.0)])
    LightSets(device_scene).clusters(CHOICE, silent)
    gone = ref(device_scene)
    gc.disable()
    try:
        del device_scene
        assert gone() is None
    finally:
        gc.enable()
