"""Rooms that the sun reaches through a window alone."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of, trace_light_paths

from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table, probabilities
from gpu.lights.light_paths import Vpls
from gpu.scene.camera import look_at
from gpu.scene.edits import ObjectEdit, SceneEdits, edited
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Camera, Light, LightKind
from gpu.vpl.light_sets import LightSets
from gpu.vpl.sun_importance import WalkParameters, sun_maps_of

SUN = Light("sun", LightKind.DIRECTIONAL, (2.0, 2.0, 2.0), direction=(0.0, -1.0, 0.0))
LAMP = Light("lamp", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.0, 0.0, 0.0))
WINDOW, ALBEDO, PATHS = 0.2, 0.5, 1 << 14


def room(lights: Sequence[Light] = (SUN,), cameras: Sequence[Camera] | None = None,
         more: Sequence[MeshPart] = ()) -> DeviceScene:  # fmt: skip
    """A cube on a wide ground, with a window of WINDOW² in its roof; all seen from inside."""
    walls = [part for part in box(half=0.5) if not (part.positions[:, 1] == 0.5).all()]
    inner, outer = WINDOW / 2.0, 0.5
    roof = [
        quad((x, 0.5, z), (width, 0.0, 0.0), (0.0, 0.0, depth))
        for x, z, width, depth in (
            (-outer, -outer, 2.0 * outer, outer - inner),
            (-outer, inner, 2.0 * outer, outer - inner),
            (-outer, -inner, outer - inner, WINDOW),
            (inner, -inner, outer - inner, WINDOW),
        )
    ]
    ground = quad((-4.0, -0.6, 4.0), (8.0, 0.0, 0.0), (0.0, 0.0, -8.0))
    inside = [look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0))] if cameras is None else cameras
    scene = scene_of([*walls, *roof, ground, *more], [grey(ALBEDO)], lights)
    return DeviceScene(replace(scene, cameras=tuple(inside)), "cpu")


def first_hits(device_scene: DeviceScene, *, aimed: bool, **chosen: float) -> Vpls:
    table = build_light_table(device_scene)
    if aimed:
        table.suns = sun_maps_of(device_scene, table, parameters(WalkParameters, **chosen))
    return trace_light_paths(device_scene, device_scene.data, table, PATHS, 1, 0)


def in_patch(device_scene: DeviceScene, vpls: Vpls) -> np.ndarray:
    """Which lie on the floor below the window."""
    placement = device_scene.scene.placement
    position = vpls.position.numpy() / placement.scale + np.asarray(placement.centre)
    return np.asarray((np.abs(position[:, [0, 2]]) <= WINDOW / 2.0).all(axis=1) & (np.abs(position[:, 1] + 0.5) < 0.01))


def test_most_light_paths_go_through_the_window_and_carry_as_much_light_as_before() -> None:
    device_scene = room()
    plain, aimed = (first_hits(device_scene, aimed=each) for each in (False, True))
    patches = [in_patch(device_scene, vpls) for vpls in (plain, aimed)]
    assert patches[0].mean() < 0.01
    assert patches[1].mean() > 0.5
    # What the sun sends through the window, reflected once, in units of the scene.
    flux = 2.0 * ALBEDO * (WINDOW * device_scene.scene.placement.scale) ** 2
    assert aimed.flux.numpy()[patches[1]].sum(axis=0) == pytest.approx([flux] * 3, rel=0.01)
    everything = [vpls.flux.numpy().sum(axis=0, dtype=np.float64) for vpls in (plain, aimed)]
    assert everything[1] == pytest.approx(everything[0], rel=0.03)


def test_a_scenes_light_sets_aim_its_sun() -> None:
    assert LightSets(room()).table.suns.cumulative.shape == (1, 256 * 256)


@pytest.mark.parametrize("device_scene", [partial(room, lights=(LAMP,)), partial(room, cameras=())])
def test_without_a_sun_or_a_camera_paths_begin_anywhere(device_scene: partial[DeviceScene]) -> None:
    assert LightSets(device_scene()).table.suns.cumulative.shape[0] == 0


def test_the_first_four_lights_have_maps() -> None:
    device_scene = room(lights=[LAMP] * 3 + [SUN] * 3)
    cumulative = sun_maps_of(device_scene, build_light_table(device_scene)).cumulative.numpy()
    assert cumulative[:, -1] == pytest.approx([0.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize(("length", "reaches"), [(1, False), (6, True)])
def test_what_is_lit_round_a_corner_matters_too(length: int, reaches: bool) -> None:
    """The camera looks at the ceiling, from where walks come to the lit floor."""
    device_scene = room(cameras=[look_at((0.3, -0.1, 0.4), (0.4, 0.5, 0.4))])
    vpls = first_hits(device_scene, aimed=True, length=length)
    assert (in_patch(device_scene, vpls).mean() > 0.2) == reaches


def map_of(device_scene: DeviceScene) -> np.ndarray:
    """The sun's map, of the usual walks: how probable each cell is, (row, column)."""
    suns = sun_maps_of(device_scene, build_light_table(device_scene))
    side = suns.chosen.side
    return np.diff(suns.cumulative.numpy()[0].astype(float), prepend=0.0).reshape(side, side)


def test_what_a_view_shows_evenly_is_even_in_the_map() -> None:
    """To a tenth from cell to cell: half the walks would leave twice as much noise, twice the walks half."""
    ground = quad((-1.0, 0.0, 1.0), (2.0, 0.0, 0.0), (0.0, 0.0, -2.0))
    above = look_at((0.0, 1.0, 0.001), (0.0, 0.0, 0.0), yfov_degrees=90.0)
    scene = replace(scene_of([ground], [grey(ALBEDO)], [SUN]), cameras=(above,))
    seen = map_of(DeviceScene(scene, "cpu"))[98:158, 98:158]
    assert 0.08 < seen.std() / seen.mean() < 0.15


def test_a_room_next_door_matters_but_far_less_than_the_one_that_is_seen() -> None:
    """Two rooms with a window each in their roofs, and a door between them."""
    walls = [quad((x, 0.0, -0.5), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)) for x in (-1.0, 1.0)]
    walls += [quad((-1.0, 0.0, z), (2.0, 0.0, 0.0), (0.0, 1.0, 0.0)) for z in (-0.5, 0.5)]
    walls += [quad((0.0, 0.0, z), (0.0, 0.0, 0.35), (0.0, 1.0, 0.0)) for z in (-0.5, 0.15)]
    walls.append(quad((0.0, 0.6, -0.15), (0.0, 0.0, 0.3), (0.0, 0.4, 0.0)))
    flat = [(0.0, -1.0, 1.0, -0.5, 0.5)]
    for middle in (-0.5, 0.5):
        left, right, near, far = middle - 0.1, middle + 0.1, -0.1, 0.1
        flat += [(1.0, middle - 0.5, left, -0.5, 0.5), (1.0, right, middle + 0.5, -0.5, 0.5)]
        flat += [(1.0, left, right, -0.5, near), (1.0, left, right, far, 0.5)]
    floors = [quad((x, y, front), (end - x, 0.0, 0.0), (0.0, 0.0, z - front)) for y, x, end, z, front in flat]
    seen = look_at((-0.5, 0.5, 0.4), (-0.6, 0.4, -0.5))
    scene = replace(scene_of([*walls, *floors], [grey(ALBEDO)], [SUN]), cameras=(seen,))
    next_door = map_of(DeviceScene(scene, "cpu"))[:, 128:].sum()
    assert 0.07 < next_door < 0.11


def test_a_sun_that_is_let_in_and_kept_out_again_has_its_light_paths_by_what_is_seen() -> None:
    strong, lamp = replace(SUN, intensity=(1e5, 1e5, 1e5)), replace(LAMP, intensity=(1.0, 2.0, 3.0))
    lid = replace(quad((-0.2, 0.5, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4)), name="lid")
    base = room([strong, lamp], more=[lid])
    off = edited(base.scene, SceneEdits(objects={"lid": ObjectEdit(offset=(1.0, 0.0, 0.0))}))
    sets = LightSets(base.edited(off))
    for scene, sun in ((base.scene, 0.2), (off, 1.0), (base.scene, 0.2), (off, 1.0)):
        assert sets.follow(base.edited(scene))
        for table in (sets.table, sets._path_light.table):
            assert probabilities(table.all_emitters)[0] == pytest.approx(sun, abs=1e-4)
        assert probabilities(sets.by_power)[0] == pytest.approx(1.0, abs=1e-4)


def test_a_sun_that_lights_nothing_seen_has_few_of_the_light_paths() -> None:
    """By its power it would have all but one in thousands, and a closed room would be dark."""
    strong, lamp = replace(SUN, intensity=(1e5, 1e5, 1e5)), replace(LAMP, intensity=(1.0, 2.0, 3.0))
    ground = quad((-4.0, -0.6, 4.0), (8.0, 0.0, 0.0), (0.0, 0.0, -8.0))
    inside = look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0))
    closed = replace(scene_of([*box(half=0.5), ground], [grey(ALBEDO)], [strong, lamp]), cameras=(inside,))
    open_room, sets = room([strong, lamp]), LightSets(DeviceScene(closed, "cpu"))
    assert probabilities(sets._path_light.table.all_emitters) == pytest.approx([0.2, 0.8], abs=1e-6)
    assert probabilities(sets.table.all_emitters) == pytest.approx([0.2, 0.8], abs=1e-6)
    assert probabilities(sets.by_power)[0] > 0.999
    assert probabilities(LightSets(open_room)._path_light.table.all_emitters)[0] > 0.999
    alone = LightSets(DeviceScene(replace(closed, lights=(closed.lights[0],)), "cpu"))
    assert probabilities(alone._path_light.table.all_emitters) == pytest.approx([1.0])
    device_scene = sets._device_scene
    vpls = trace_light_paths(device_scene, device_scene.data, sets._path_light.table, PATHS, 1, 0)
    position = vpls.position.numpy() / closed.placement.scale + np.asarray(closed.placement.centre)
    within = (np.abs(position).max(axis=1) < 0.501) & (np.sum(position * vpls.normal.numpy(), axis=1) < 0.0)
    lit = vpls.flux.numpy()[within].sum(axis=0, dtype=np.float64) / closed.placement.scale**2
    assert lit == pytest.approx(ALBEDO * 4.0 * np.pi * np.array(lamp.intensity), rel=0.02)
