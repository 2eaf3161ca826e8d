from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gltf_motion import moving
from pydantic import ValidationError
from scenes import box, quad, scene_of

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, SceneEdits, edited
from gpu.scene.lighting.added_daylight import overhead_sun
from gpu.scene.lighting.daylight import level_radiance
from gpu.scene.lighting.default_light import SOFT_SKY
from gpu.scene.types import Environment, Light, LightKind, Material, Placement, Scene, Sky, same_picture

LAMP = Material("lamp", emission=(4.0, 2.0, 0.0))
WALL = Material("wall", base_color=(0.5, 0.5, 0.5, 0.25), roughness=0.9)


@pytest.fixture(scope="module")
def scene() -> Scene:
    lights = [Light("bulb", LightKind.POINT, (2.0, 1.0, 0.5)), Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0))]
    block = replace(quad([-0.2, -0.2, -0.2], [0.0, 0.0, 0.3], [0.3, 0.0, 0.0]), name="block")
    return scene_of([block, *box()], [WALL, LAMP], lights=lights, sky=Sky((0.5, 0.5, 1.0)))


def edits_of(**parts: dict[str, dict[str, object]]) -> SceneEdits:
    return SceneEdits.model_validate(parts)


def test_lights_of_every_kind_go_off_and_get_brighter(scene: Scene) -> None:
    bulb, sun = scene.lights
    change = {"bulb": {"on": False, "intensity": 9.0}, "sun": {"intensity": 2.0}, "lamp": {"intensity": 0.5}}
    found = edited(scene, edits_of(lights={**change, "sky": {"intensity": 3.0}}))
    assert [light.intensity for light in found.lights] == [(0.0,) * 3, (6.0,) * 3]
    assert replace(found.lights[0], intensity=bulb.intensity) == bulb
    assert [material.emission for material in found.materials] == [(0.0,) * 3, (2.0, 1.0, 0.0)]
    assert found.sky == Sky((1.5, 1.5, 3.0))
    assert scene.lights == (bulb, sun)


def test_a_colour_leaves_a_light_as_bright_by_its_largest_channel(scene: Scene) -> None:
    found = edited(scene, edits_of(lights={"bulb": {"color": [0.5, 1.0, 0.0]}, "lamp": {"color": [0, 0, 1]}}))
    assert found.lights[0].intensity == (1.0, 2.0, 0.0)
    assert found.materials[1].emission == (0.0, 0.0, 4.0)


def test_materials_change_first_and_their_light_by_what_they_emit_then(scene: Scene) -> None:
    wall = {"color": [0.1, 0.2, 0.3], "roughness": 0.2, "metallic": 1.0}
    parts = {"wall": wall, "lamp": {"emission": [1.0, 1.0, 1.0]}}
    found = edited(scene, edits_of(materials=parts, lights={"lamp": {"intensity": 3.0}})).materials
    assert found[0] == replace(WALL, base_color=(0.1, 0.2, 0.3, 0.25), roughness=0.2, metallic=1.0)
    assert found[1] == replace(LAMP, emission=(3.0, 3.0, 3.0), stays_light=True)


def test_a_picture_around_the_scene_is_tinted_or_gone(scene: Scene) -> None:
    picture = np.full((1, 2, 3), 2.0, np.float32)
    hall = replace(scene, sky=Environment("hall.hdr", picture, turn=0.3))
    found = edited(hall, edits_of(lights={"sky": {"intensity": 2.0, "color": [1.0, 0.5, 0.0]}})).sky
    assert isinstance(found, Environment)
    assert found.turn == 0.3
    assert found.tint == (2.0, 1.0, 0.0)
    gone = edited(hall, edits_of(lights={"sky": {"on": False}})).sky
    assert isinstance(gone, Environment)
    assert gone.tint == (0.0, 0.0, 0.0)
    assert gone.pixels is found.pixels is picture


def test_lights_are_moved_and_turned_in_the_world(scene: Scene) -> None:
    placed = replace(scene, placement=Placement((10.0, 0.0, 0.0), 0.5))
    bulb, sun = edited(
        placed, edits_of(lights={"bulb": {"position": [12.0, 1.0, 0.0]}, "sun": {"direction": [0.0, -2.0, 0.0]}})
    ).lights
    assert (bulb.position, bulb.direction) == ((1.0, 0.5, 0.0), scene.lights[0].direction)
    assert sun.direction == (0.0, -1.0, 0.0)


def test_a_sun_stands_and_shines_by_date(scene: Scene) -> None:
    noon = {"date": "2024-03-20T12:07:00Z", "place": [0.0, 0.0]}
    (_, sun), (_, before) = edited(scene, edits_of(lights={"sun": noon})).lights, scene.lights
    assert sun.direction == pytest.approx((0.0, -1.0, 0.0), abs=0.01)
    assert sun.intensity == pytest.approx(before.intensity, rel=0.01)
    evening = {**noon, "date": "2024-03-20T19:00:00+01:00", "north": 90.0, "intensity": 2.0}
    (_, sun) = edited(scene, edits_of(lights={"sun": evening})).lights
    assert sun.direction == pytest.approx((0.0, 0.0, 1.0), abs=0.04)  # the west is −Z where the north is +X
    assert sun.intensity[0] > sun.intensity[2] > 0.0
    night = {**evening, "date": "2024-03-21T00:00:00Z", "direction": [1.0, 0.0, 0.0]}
    (_, sun) = edited(scene, edits_of(lights={"sun": night})).lights
    assert (sun.direction, sun.intensity) == ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("one", "change", "words"),
    [
        ("sun", {"date": "2024-03-20T12:00:00Z"}, "lights.sun.place: must be given"),
        ("bulb", {"date": "2024-03-20T12:00:00Z"}, "lights.bulb.date: only a directional light"),
        ("sky", {"date": "2024-03-20T12:00:00Z"}, "lights.sky.place: must be given"),
        ("sun", {"position": [0, 0, 0]}, "lights.sun.position: a light of this kind .directional. has none"),
        ("bulb", {"direction": [0, 1, 0]}, "lights.bulb.direction: a light of this kind .point. has none"),
        ("sky", {"direction": [0, 1, 0]}, "lights.sky.direction"),
        ("lamp", {"position": [0, 1, 0]}, "lights.lamp.position"),
    ],
)
def test_what_cannot_be_moved_or_turned_is_refused(
    scene: Scene, one: str, change: dict[str, object], words: str
) -> None:
    with pytest.raises(UserError, match=f"^{words}"):
        edited(scene, edits_of(lights={one: change}))


def test_objects_go_and_move_within_the_box_of_the_scene(scene: Scene) -> None:
    assert scene.objects == ("block", "mesh")
    moved = edited(scene, edits_of(objects={"block": {"offset": [0.1, 0.0, 0.0]}, "mesh": {"visible": True}}))
    ours = scene.vertex_object == 0
    assert np.allclose(moved.vertices[ours], scene.vertices[ours] + (0.1, 0.0, 0.0))
    assert np.array_equal(moved.vertices[~ours], scene.vertices[~ours])
    turned = edited(scene, edits_of(objects={"block": {"rotation": [0.0, 0.0, 90.0], "offset": [0.1, 0.0, 0.0]}}))
    assert np.ptp(turned.vertices[ours], axis=0).tolist() == pytest.approx([0.0, 0.3, 0.3])
    gone = edited(scene, edits_of(objects={"block": {"visible": False}}))
    assert len(gone.triangles) == len(scene.triangles) - 2


def test_a_sky_is_that_of_its_date_as_bright_as_the_files_with_the_sun_overhead(scene: Scene) -> None:
    noon = {"date": "2024-03-20T12:07:00Z", "place": [0.0, 0.0]}
    found = edited(scene, edits_of(lights={"sky": {**noon, "intensity": 0.5, "color": [1.0, 0.5, 0.0]}})).sky
    assert isinstance(found, Environment)
    assert isinstance(scene.sky, Sky)
    level = 0.5 * 5.0 / 6.0 * np.mean(scene.sky.radiance)
    assert found.tint == pytest.approx((level, 0.5 * level, 0.0))
    again = edited(scene, edits_of(lights={"sky": noon, "bulb": {"on": False}})).sky
    assert same_picture(found, again)
    evening = edited(scene, edits_of(lights={"sky": {**noon, "date": "2024-03-20T18:00:00Z", "north": 90.0}})).sky
    assert isinstance(evening, Environment)
    # West, where the sun sets, is then at −90° + 90° from −Z, of which the first column is.
    assert evening.pixels[:32].sum(axis=(0, 2)).argmax() in (0, 127)
    bright = Environment("noon", np.full((32, 64, 3), 6.0, np.float32), tint=(0.5, 0.5, 0.5))
    dated = edited(replace(scene, sky=bright), edits_of(lights={"sky": noon})).sky
    assert isinstance(dated, Environment)
    assert dated.tint == pytest.approx((3.0, 3.0, 3.0))


@pytest.mark.parametrize(("row", "column"), [(0, 0), (0, 16), (8, 8), (15, 63)])
def test_a_sky_of_a_date_is_as_bright_as_a_picture_lights_the_ground(scene: Scene, row: int, column: int) -> None:
    """Whatever the picture shows where: what is high counts more, and what is below the horizon nothing."""
    picture = np.full((32, 64, 3), 1.0, np.float32)
    picture[16:] = 100.0
    picture[row, column] = 1000.0
    edges = np.cos(2.0 * np.pi * np.arange(33) / 32.0) / 4.0  # of rows: minus the integral of cosine by solid angle
    expected = 1.0 + 999.0 * 2.0 * (edges[row] - edges[row + 1]) / 64.0
    noon = edits_of(lights={"sky": {"date": "2024-03-20T12:07:00Z", "place": [0.0, 0.0]}})
    dated = edited(replace(scene, sky=Environment("sun", picture)), noon).sky
    assert isinstance(dated, Environment)
    assert dated.tint == pytest.approx((expected,) * 3)


def test_a_picture_of_one_row_is_a_sky_to_a_date(scene: Scene) -> None:
    noon = edits_of(lights={"sky": {"date": "2024-03-20T12:07:00Z", "place": [0.0, 0.0]}})
    dated = edited(replace(scene, sky=Environment("even", np.full((1, 2, 3), 2.0, np.float32))), noon).sky
    assert isinstance(dated, Environment)
    assert dated.tint == pytest.approx((2.0, 2.0, 2.0))


@pytest.mark.parametrize(
    ("objects", "words"),
    [
        ({"block": {"offset": [0.0, 0.0, -9.0]}}, "objects.block.offset: takes it 8.7 m beyond the box of the scene"),
        ({"mesh": {"offset": [0.01, 0.0, 0.0]}}, "objects.mesh.offset: takes it 0.01 m beyond the box of the scene"),
        ({"mesh": {"scale": 1.5}}, r"objects.mesh.scale: takes it [\d.]+ m beyond the box of the scene"),
        ({"block": {"visible": False}, "mesh": {"visible": False}}, "objects: one at least must stay visible"),
        ({"chair": {}}, "objects.chair: the scene has no such object; it has block, mesh"),
    ],
)
def test_what_cannot_be_done_with_objects_is_said(scene: Scene, objects: dict[str, object], words: str) -> None:
    with pytest.raises(UserError, match=f"^{words}$"):
        edited(scene, SceneEdits.model_validate({"objects": objects}))


def test_lights_that_are_off_stay_lights(scene: Scene) -> None:
    """So that they keep their places among emitters; other surfaces become lights while they shine."""
    off = edited(scene, edits_of(lights={"lamp": {"on": False}})).materials[1]
    dark = edited(scene, edits_of(materials={"lamp": {"emission": [0, 0, 0]}})).materials[1]
    assert all(one.emission == (0.0, 0.0, 0.0) and one.emits for one in (off, dark))
    walls = [edited(scene, edits_of(materials={"wall": {"emission": [a, 0, 0]}})).materials[0] for a in (0.0, 1.0)]
    assert [wall.emits for wall in walls] == [False, True]


def test_no_edits_change_nothing(scene: Scene) -> None:
    found = edited(scene, NO_EDITS)
    assert (found.lights, found.materials, found.sky) == (scene.lights, scene.materials, scene.sky)
    assert found.vertices is scene.vertices


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"lights": {"moon": {"on": True}}}, "lights.moon: the scene has no such light; it has bulb, sun, lamp, sky"),
        ({"materials": {"bulb": {}}}, "materials.bulb: the scene has no such material; it has wall, lamp"),
    ],
)
def test_what_is_not_there_is_named(scene: Scene, parts: dict[str, dict[str, dict[str, object]]], words: str) -> None:
    with pytest.raises(UserError, match=f"^{words}$"):
        edited(scene, edits_of(**parts))


@pytest.mark.parametrize("date", ["1900-01-01T00:00:00+23:59", "2100-12-31T23:59:59.999999-23:59"])
@pytest.mark.parametrize("place", [[90.0, -180.0], [-90.0, 180.0]])
def test_a_sun_shines_at_the_ends_of_time_and_of_the_world(date: str, place: list[float]) -> None:
    sun = edits_of(lights={"sun": {"date": date, "place": place, "north": -360.0}}).lights["sun"]
    assert sun.shines is not None
    assert np.linalg.norm(sun.shines) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("parts", "place"),
    [
        ({"lights": {"bulb": {"intensity": -1.0}}}, "lights.bulb.intensity"),
        ({"lights": {"bulb": {"intensity": float("nan")}}}, "lights.bulb.intensity"),
        ({"lights": {"bulb": {"color": [1, 2, 0]}}}, "lights.bulb.color.1"),
        ({"lights": {"bulb": {"flux": 1}}}, "lights.bulb.flux"),
        ({"lights": {"sun": {"date": "2024-03-20T12:00:00"}}}, "lights.sun.date"),
        ({"lights": {"sun": {"date": "0001-01-01T00:00:00+23:59"}}}, "lights.sun.date"),  # before there is UTC
        ({"lights": {"sun": {"date": "1899-12-31T00:00:00Z"}}}, "lights.sun.date"),
        ({"lights": {"sun": {"date": "2101-01-01T00:00:00Z"}}}, "lights.sun.date"),
        ({"lights": {"sun": {"place": [91, 0]}}}, "lights.sun.place.0"),
        ({"lights": {"sun": {"direction": [0, 0, 0]}}}, "lights.sun.direction"),
        ({"lights": {"sun": {"direction": [0, 1e200, 0]}}}, "lights.sun.direction"),
        ({"lights": {"bulb": {"position": [1e300, 0, 0]}}}, "lights.bulb.position.0"),
        ({"objects": {"block": {"rotation": [0, 361, 0]}}}, "objects.block.rotation.1"),
        ({"objects": {"block": {"scale": 0.0}}}, "objects.block.scale"),
        ({"materials": {"wall": {"roughness": 1.5}}}, "materials.wall.roughness"),
        ({"materials": {"wall": {"emission": [1e9, 0, 0]}}}, "materials.wall.emission.0"),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_its_place(
    parts: dict[str, dict[str, dict[str, object]]], place: str
) -> None:
    with pytest.raises(ValidationError) as refused:
        edits_of(**parts)
    assert ".".join(map(str, refused.value.errors()[0]["loc"])) == place


def test_equal_edits_are_one_key() -> None:
    changes: list[tuple[str, dict[str, object]]] = [("bulb", {"on": False}), ("sun", {"direction": [0.0, -1.0, 0.0]})]
    orders = [edits_of(lights=dict(order)) for order in (changes, reversed(changes))]
    assert len({*orders, NO_EDITS}) == 2


def test_edits_are_of_what_is_there_at_a_time(tmp_path: Path) -> None:
    scene = moving(tmp_path).load()
    (lamp,) = scene.lights
    edits = edits_of(lights={"lamp": {"intensity": 2.0}}, objects={"arm": {"visible": False}})
    found = edited(scene, edits.model_copy(update={"time": 1.0}))
    (there,) = edited(scene, SceneEdits(time=1.0, animation="wave")).lights
    assert there.position != lamp.position
    (brighter,) = found.lights
    assert brighter == replace(there, intensity=tuple(2.0 * channel for channel in lamp.intensity))
    assert len(found.triangles) == len(scene.triangles) - 1
    assert len({hash(SceneEdits(time=1.0)), hash(SceneEdits(time=2.0)), hash(SceneEdits(animation="wave"))}) == 3


def test_a_moment_that_a_scene_has_not_is_refused(tmp_path: Path, scene: Scene) -> None:
    with pytest.raises(UserError, match=r"^time: the scene has no animations$"):
        edited(scene, SceneEdits(time=1.0))
    with pytest.raises(UserError, match=r"^animation: the scene has no 'run'; it has none$"):
        edited(scene, SceneEdits(animation="run"))
    with pytest.raises(UserError, match=r"^animation: the scene has no 'run'; it has wave$"):
        edited(moving(tmp_path).load(), SceneEdits(time=1.0, animation="run"))
    with pytest.raises(ValidationError, match="time"):
        SceneEdits(time=-1.0)


def test_a_sun_and_a_sky_that_the_file_has_not_are_added_by_edits(scene: Scene) -> None:
    lamps = replace(scene, lights=scene.lights[:1], sky=None)
    noon = {"date": "2024-03-20T12:07:00Z", "place": [0.0, 0.0]}
    for unlit in ({"on": False}, {"intensity": 2.0}, {**noon, "on": False}):
        found = edited(lamps, edits_of(lights={"sun": unlit, "sky": unlit}))
        assert (found.lights, found.sky) == (lamps.lights, None)
    found = edited(lamps, edits_of(lights={"sun": {**noon, "intensity": 0.5}, "sky": noon, "bulb": {"on": False}}))
    bulb, sun = found.lights
    assert bulb.intensity == (0.0, 0.0, 0.0)
    assert sun.direction == pytest.approx((0.0, -1.0, 0.0), abs=0.02)
    assert sun.intensity == pytest.approx(0.5 * np.array(overhead_sun(None).intensity), rel=0.01)
    assert isinstance(found.sky, Environment)
    assert level_radiance(found.sky) == pytest.approx(level_radiance(SOFT_SKY), rel=0.01)
    on = edited(lamps, edits_of(lights={"sun": {"on": True, "direction": [3.0, 0.0, 0.0]}, "sky": {"on": True}}))
    assert on.sky == SOFT_SKY
    assert on.lights[1] == replace(overhead_sun(None), direction=(1.0, 0.0, 0.0))
    assert edited(replace(lamps, sky=scene.sky), edits_of(lights={"sun": {"on": True}})).lights[1] == overhead_sun(
        scene.sky
    )
