from dataclasses import replace

import pytest
from emitters import POINT, SUN, lamp_room

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.path_light import PathLight
from gpu.scene.edits import LightEdit, MaterialEdit, SceneEdits, edited
from gpu.scene.types import Scene, Sky


@pytest.fixture(scope="module")
def base() -> DeviceScene:
    return lamp_room(lights=[POINT, replace(SUN, intensity=(0.1, 0.1, 0.1))], sky=Sky((0.1, 0.2, 0.3)))


def path_light_of(device_scene: DeviceScene) -> PathLight:
    return PathLight(device_scene, build_light_table(device_scene).suns, lambda *_: None)


def followed(base: DeviceScene, light: PathLight, scene: Scene) -> bool:
    state = base.edited(scene)
    table = build_light_table(state)
    table.suns = light.table.suns
    drawn = light.of(state, table, same_suns=True)
    light.become(scene, drawn)
    return drawn is None


@pytest.mark.parametrize(
    ("edits", "same"),
    [
        (
            SceneEdits(
                lights={
                    "sky": LightEdit(on=False),
                    "default": LightEdit(on=False),
                    "point": LightEdit(color=(1.0, 0.0, 1.0)),
                }
            ),
            True,
        ),
        (SceneEdits(materials={"default (2)": MaterialEdit(emission=(1.0, 2.0, 3.0))}), True),
        (SceneEdits(materials={"default": MaterialEdit(color=(0.1, 0.2, 0.3))}), False),
        (SceneEdits(lights={"point": LightEdit(position=(0.1, 0.1, 0.1))}), False),
        (SceneEdits(lights={"sun": LightEdit(intensity=1000.0)}), False),
    ],
)
def test_paths_are_others_where_they_meet_something_else(base: DeviceScene, edits: SceneEdits, same: bool) -> None:
    light = path_light_of(base)
    power = light.table.all_emitters.cumulative.numpy().tolist()
    scene = edited(base.scene, edits)
    assert followed(base, light, scene) == same
    assert followed(base, light, scene)  # what it has become
    anew = path_light_of(base.edited(scene))
    found = light.table.all_emitters.cumulative.numpy().tolist()
    assert found == anew.table.all_emitters.cumulative.numpy().tolist()
    assert (found == power) == (not edits.lights.get("sun"))
    assert light.shares.numpy().tobytes() == anew.shares.numpy().tobytes()
    seen, other = light.seen_by_paths(base.data), anew.seen_by_paths(base.data)
    assert (seen.materials.numpy() == other.materials.numpy()).all()  # by fields: there are bytes between them
    assert seen.sky.numpy().tobytes() == other.sky.numpy().tobytes()
