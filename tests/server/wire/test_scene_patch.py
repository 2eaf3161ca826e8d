import pytest

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, LightEdit, MaterialEdit, SceneEdits
from server.wire.scene_patch import patched

OFF = SceneEdits(lights={"bulb": LightEdit(on=False, intensity=2.0)}, materials={"wall": MaterialEdit(roughness=0.5)})


def test_what_is_named_changes_and_the_rest_stays() -> None:
    found = patched(OFF, {"lights": {"bulb": {"intensity": 3.0}, "sun": {"on": True}}})
    assert found.lights == {"bulb": LightEdit(on=False, intensity=3.0), "sun": LightEdit(on=True)}
    assert found.materials == OFF.materials
    assert OFF.lights["bulb"].intensity == 2.0


@pytest.mark.parametrize(
    ("patch", "lights"),
    [
        ({"lights": {"bulb": {"on": None}}}, {"bulb": LightEdit(intensity=2.0)}),
        ({"lights": {"bulb": {"on": None, "intensity": None}}}, {}),
        ({"lights": {"bulb": None}}, {}),
        ({"lights": None}, {}),
        ({"lights": {"moon": None, "sun": {}}}, OFF.lights),
    ],
)
def test_null_takes_an_edit_back(patch: dict[str, object], lights: dict[str, LightEdit]) -> None:
    assert patched(OFF, patch) == SceneEdits(lights=lights, materials=OFF.materials)


def test_without_edits_there_is_nothing() -> None:
    assert patched(OFF, {"lights": None, "materials": None}) == NO_EDITS


@pytest.mark.parametrize(
    ("patch", "words"),
    [
        ({"lights": {"bulb": {"intensity": -1}}}, "lights.bulb.intensity: Input should be greater than or equal to 0"),
        ({"lights": {"bulb": 3}}, "lights.bulb: Input should be"),
        ({"cameras": {}}, "cameras: Extra inputs are not permitted"),
        ({"lights": [1]}, "lights: Input should be a valid dictionary"),
        ({"materials": {"": {}}}, "materials"),
    ],
)
def test_a_wrong_patch_is_refused_with_the_field(patch: dict[str, object], words: str) -> None:
    with pytest.raises(UserError, match=f"^{words}"):
        patched(OFF, patch)
