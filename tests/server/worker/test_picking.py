from dataclasses import replace

import pytest
from scenes import grey, quad, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.scene.camera import look_at
from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits, edited
from gpu.scene.types import Scene, Sky
from server.wire.browser import PickedPart
from server.worker.picking import picked_part

# From (0, 0, 5) towards −Z, 90° high and wide.
CAMERA = look_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), yfov_degrees=90.0, aspect=1.0)
LEFT, RIGHT, ABOVE = (0.25, 0.5), (0.75, 0.5), (0.5, 0.05)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A wall, dark on the left and shining on the right, under a sky."""
    wall = quad((-4.0, -4.0, 0.0), (4.0, 0.0, 0.0), (0.0, 8.0, 0.0), 0)
    lamp = quad((0.0, -4.0, 0.0), (4.0, 0.0, 0.0), (0.0, 8.0, 0.0), 1)
    parts = [replace(wall, name="wall"), replace(lamp, name="lamp")]
    materials = [replace(grey(0.5), name="paint"), replace(grey(0.5, emission=2.0), name="glow")]
    return scene_of(parts, materials, sky=Sky((1.0, 1.0, 1.0)))


def picked(scene: Scene, place: tuple[float, float], edits: SceneEdits = SceneEdits()) -> PickedPart:  # noqa: B008
    return picked_part(scene, DeviceScene(edited(scene, edits), "cpu"), CAMERA, place)


def test_a_surface_is_picked_with_its_object_and_material(scene: Scene) -> None:
    part = picked(scene, LEFT)
    assert (part.object, part.material, part.light) == ("wall", "paint", None)
    assert part.point == pytest.approx((-2.5, 0.0, 0.0), abs=1e-5)
    assert part.distance == pytest.approx((5.0**2 + 2.5**2) ** 0.5)


def test_what_shines_is_picked_as_the_light_that_it_is(scene: Scene) -> None:
    part = picked(scene, RIGHT)
    assert (part.object, part.material, part.light) == ("lamp", "glow", "glow")
    assert picked(scene, ABOVE) == PickedPart(light="sky")
    dark = replace(scene, sky=None)
    assert picked(dark, ABOVE) == PickedPart()
    assert picked(dark, ABOVE, SceneEdits(lights={"sky": LightEdit(on=True)})) == PickedPart(light="sky")


def test_ids_are_those_of_the_file_whatever_was_edited(scene: Scene) -> None:
    dark = SceneEdits(
        materials={"glow": MaterialEdit(emission=(0.0, 0.0, 0.0)), "paint": MaterialEdit(emission=(1.0, 1.0, 1.0))}
    )
    assert picked(scene, RIGHT, dark).light == "glow"
    assert picked(scene, LEFT, dark).light is None
    gone = SceneEdits(objects={"wall": ObjectEdit(visible=False)})
    assert picked(scene, LEFT, gone).object is None
    assert picked(scene, RIGHT, gone).object == "lamp"
