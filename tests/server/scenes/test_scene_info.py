from dataclasses import replace
from math import atan, tan
from pathlib import Path

import numpy as np
import pytest
from gltf_motion import moving

from gpu.scene.lighting.default_light import with_default_light
from gpu.scene.load import load_scene
from gpu.scene.parts import LightForm
from gpu.scene.types import Camera, Light, LightKind, LoadReport, Material, Placement, Scene
from gpu.scene.wording import MOST_CHOICE, MOST_CHOICES, MOST_NAME, MOST_SENTENCE, MOST_SENTENCES
from server.scenes.scene_info import MOST_CAMERAS, MOST_PARTS, PLAN_FIELDS_OF_VIEW, describe_scene
from server.wire.browser import AnimationInfo, Bounds, Pose
from server.wire.worker import MAX_TEXT_BYTES, Opened, pack


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A scene 10 m wide around (100, 0, 0)."""
    vertices = np.array([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5], [0.5, -0.5, 0.0]], np.float32)
    placement, bounds = Placement(centre=(100.0, 0.0, 0.0), scale=0.1), ((95.0, -5.0, -5.0), (105.0, 5.0, 5.0))
    to_world = np.eye(4)
    to_world[:3, 3] = (100.0, 0.0, 20.0)
    cameras = (
        Camera("eye", to_world, half_height=0.5, near=4.0),
        Camera("plan", to_world, half_height=4.0, orthographic=True),
    )
    report = LoadReport(ignored=("a fog was ignored",), dropped_triangles=2)
    box = load_scene("cornell-box")
    triangles = np.array([[0, 1, 2]], np.int32)
    return replace(
        box,
        name="test",
        vertices=vertices,
        triangles=triangles,
        objects=("block",),
        vertex_object=np.zeros(3, np.int32),
        placement=placement,
        bounds=bounds,
        cameras=cameras,
        report=report,
    )


def test_bounds_are_in_world_space(scene: Scene) -> None:
    bounds = describe_scene("id", scene).bounds
    assert bounds.min == pytest.approx((95.0, -5.0, -5.0))
    assert bounds.max == pytest.approx((105.0, 5.0, 5.0))


def test_a_scene_in_an_environment_has_its_sky_and_no_added_light() -> None:
    box = load_scene("cornell-box")
    dark = replace(box, materials=tuple(replace(it, emission=(0.0, 0.0, 0.0)) for it in box.materials))
    lit = with_default_light(dark)
    assert len(describe_scene("id", lit).notes) == 1
    found = describe_scene("id", lit, in_environment=True)
    assert [(light.id, light.form) for light in found.lights if not light.added] == [("sky", LightForm.SKY)]
    assert found.notes == ()


def test_cameras_are_column_major(scene: Scene) -> None:
    camera = describe_scene("id", scene).cameras[0]
    assert camera.matrix[12:15] == (100.0, 0.0, 20.0)
    assert camera.yfov == pytest.approx(2.0 * atan(0.5))
    assert camera.near == 4.0


def test_an_orthographic_camera_becomes_one_that_shows_as_much(scene: Scene) -> None:
    camera = describe_scene("id", scene).cameras[1]
    assert camera.orthographic
    assert camera.yfov == pytest.approx(2.0 * atan(4.0 / 20.0))


@pytest.mark.parametrize(
    ("half_height", "away"), [(4.0, 20.0), (4.0, 0.0), (4.0, 1e-12), (4.0, 1e4), (1e-4, 20.0), (1e5, 20.0)]
)
def test_a_walk_can_begin_at_any_camera_that_is_listed(scene: Scene, half_height: float, away: float) -> None:
    to_world = np.eye(4)
    to_world[:3, 3] = (100.0, 0.0, away)
    both = tuple(Camera("", to_world, half_height, orthographic=flat, near=1.0) for flat in (False, True))
    walk, plan = describe_scene("id", replace(scene, cameras=both)).cameras
    for camera in (walk, plan):
        Pose(type="pose", id=1, matrix=camera.matrix, yfov=camera.yfov, near=camera.near)
    assert walk.matrix[14] == away
    assert plan.matrix[14] * tan(plan.yfov / 2.0) == pytest.approx(half_height)  # shows as much at the centre
    assert plan.near == pytest.approx(max(1.0 + plan.matrix[14] - away, 0.0))  # and nothing that is behind the plan


def test_an_orthographic_camera_of_a_scene_that_is_very_far_away_shows_some_of_it(scene: Scene) -> None:
    far = replace(scene, bounds=((1e31, 0.0, 0.0), (3e31, 1.0, 1.0)))
    camera = describe_scene("id", replace(far, cameras=(Camera("plan", np.eye(4), 1.0, orthographic=True),))).cameras[0]
    assert camera.yfov == pytest.approx(PLAN_FIELDS_OF_VIEW[0])


def test_what_was_ignored_or_dropped_is_said(scene: Scene) -> None:
    info = describe_scene("rooms/hall.glb", scene)
    assert info.notes == ("a fog was ignored", "2 triangles without area were dropped")
    assert (info.id, info.triangles) == ("rooms/hall.glb", 1)


def test_a_scene_is_called_by_its_id_not_by_its_path(scene: Scene) -> None:
    assert describe_scene("rooms/hall.glb", replace(scene, name="/private/rooms/hall.glb")).name == "hall"


@pytest.mark.parametrize("extra", [0, 1, 2000])
def test_some_cameras_are_listed_and_the_others_counted(scene: Scene, extra: int) -> None:
    count = MOST_CAMERAS + extra
    info = describe_scene("id", replace(scene, cameras=scene.cameras[:1] * count))
    assert len(info.cameras) == MOST_CAMERAS
    said = f"{count} cameras, of which the first {MOST_CAMERAS} are listed"
    assert info.notes[2:] == ((said,) if extra else ())


def test_the_most_that_a_scene_can_say_is_told(scene: Scene) -> None:
    name = MOST_NAME * "𝟙"
    sentences = tuple(MOST_SENTENCE * "𝟙" for _ in range(MOST_SENTENCES))
    full = replace(
        scene,
        cameras=4096 * (replace(scene.cameras[0], name=name),),
        report=LoadReport(sentences, 1, sentences),
        choices=dict.fromkeys(("variant", "storey"), MOST_CHOICES * (MOST_CHOICE * "𝟙",)),
        materials=4096 * (Material(name, emission=(1 / 3, 1 / 3, 1 / 3)),),
    )
    assert len(pack(Opened(1, describe_scene("id", full)))) < MAX_TEXT_BYTES / 8


def test_lights_and_materials_are_told_as_the_file_has_them(scene: Scene) -> None:
    info = describe_scene("id", scene)
    assert [(light.id, light.form, light.added) for light in info.lights] == [
        ("light", LightForm.SURFACE, False),
        ("sun", LightForm.DIRECTIONAL, True),
        ("sky", LightForm.SKY, True),
    ]
    assert info.lights[1].direction == (0.0, -1.0, 0.0)
    assert [material.id for material in info.materials] == ["white", "red", "green", "light"]
    assert info.materials[3].emission == scene.materials[3].emission
    assert [thing.id for thing in info.objects] == ["block"]
    assert info.objects[0].box == Bounds(min=(95.0, -5.0, -5.0), max=(105.0, 5.0, 5.0))
    assert info.materials[1].color == scene.materials[1].base_color[:3]


def test_lights_that_can_be_moved_or_turned_say_where_they_are_in_the_world(scene: Scene) -> None:
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    bulb = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.1, 0.2, -0.1))
    spot = replace(bulb, name="spot", kind=LightKind.SPOT)
    told = describe_scene("id", replace(scene, lights=(sun, bulb, spot))).lights
    assert [light.position for light in told] == [None, pytest.approx((101.0, 2.0, -1.0)), told[1].position, None, None]
    assert [light.direction for light in told] == [(0.0, -1.0, 0.0), None, (0.0, 0.0, -1.0), None, None]


def test_some_materials_are_listed_and_the_others_counted(scene: Scene) -> None:
    info = describe_scene("id", replace(scene, materials=scene.materials[:1] * (MOST_PARTS + 1)))
    assert len(info.materials) == MOST_PARTS
    assert info.notes[-1] == f"{MOST_PARTS + 1} materials, of which the first {MOST_PARTS} can be edited"


def test_animations_are_told_with_their_lengths(tmp_path: Path) -> None:
    info = describe_scene("arm.glb", moving(tmp_path).load())
    assert info.animations == (AnimationInfo(id="wave", seconds=2.0),)
