import pytest

from gpu.scene.edits import NO_EDITS, LightEdit, MaterialEdit, SceneEdits
from server.wire.browser import ScenePatch
from server.wire.scene_patch import patched

OFF = SceneEdits(lights={"bulb": LightEdit(on=False, intensity=2.0)}, materials={"wall": MaterialEdit(roughness=0.5)})


def patch_of(words: dict[str, object]) -> ScenePatch:
    return ScenePatch.model_validate(words)


def test_what_is_named_changes_and_the_rest_stays() -> None:
    found = patched(OFF, patch_of({"lights": {"bulb": {"intensity": 3.0}, "sun": {"on": True}}}))
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
    assert patched(OFF, patch_of(patch)) == SceneEdits(lights=lights, materials=OFF.materials)


def test_what_is_not_named_is_neither_copied_nor_looked_at() -> None:
    found = patched(OFF, patch_of({"lights": {"sun": {"on": False}}}))
    assert list(found.lights) == ["bulb", "sun"]
    assert found.lights["bulb"] is OFF.lights["bulb"]
    assert found.materials is OFF.materials


def test_without_edits_there_is_nothing() -> None:
    assert patched(OFF, patch_of({"lights": None, "materials": None})) == NO_EDITS


def test_a_moment_is_named_and_taken_back() -> None:
    found = patched(OFF, patch_of({"time": 1.5, "animation": "walk"}))
    assert (found.time, found.animation, found.lights) == (1.5, "walk", OFF.lights)
    assert patched(found, patch_of({"time": 0})).animation == "walk"
    assert patched(found, patch_of({"time": None, "animation": None})) == OFF
