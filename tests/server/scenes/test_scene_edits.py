from dataclasses import replace

import pytest

from gpu.errors import UserError
from gpu.scene.edits import NO_EDITS, LightEdit, ObjectEdit, SceneEdits
from gpu.scene.import_options import ImportOptions
from gpu.scene.parts import LightForm
from server.refusals import TooBusyError
from server.scenes.scene_edits import MOST_EDITED, EditedScenes, editable, fitting
from server.wire.browser import AnimationInfo, Bounds, LightInfo, ObjectInfo, SceneInfo, ScenePatch
from server.wire.worker import SceneRef

HALL = SceneRef("hall", "hall.glb", stamp=1)
LAMP = LightInfo(id="lamp", form=LightForm.SURFACE, color=(1.0, 1.0, 1.0))
INFO = SceneInfo(
    id="hall", name="hall", cameras=(), bounds=Bounds(min=(0, 0, 0), max=(1, 1, 1)), lights=(LAMP,), triangles=1
)
OFF = ScenePatch(lights={"lamp": LightEdit(on=False)})
SKY = LightInfo(id="sky", form=LightForm.SKY, color=(1.0, 1.0, 1.0))
LIT = INFO.model_copy(update={"lights": (LAMP, SKY)})


def test_edits_are_a_scenes_own_and_who_looks_is_told() -> None:
    scenes, told = EditedScenes(), []
    scenes.listeners.add(told.append)
    edits = scenes.change(HALL, INFO, OFF)
    assert scenes.of(HALL) == edits == SceneEdits(lights={"lamp": LightEdit(on=False)})
    assert scenes.of(SceneRef("hall", "hall.glb", stamp=2)) == NO_EDITS
    assert told == [HALL]
    assert scenes.change(HALL, INFO, ScenePatch(lights=None)) == scenes.of(HALL) == NO_EDITS


def test_a_bad_edit_changes_nothing() -> None:
    scenes, told = EditedScenes(), []
    scenes.change(HALL, INFO, OFF)
    scenes.listeners.add(told.append)
    moon = ScenePatch(lights={"lamp": LightEdit(on=True), "moon": LightEdit(on=True)})
    with pytest.raises(UserError, match=r"lights\.moon: the scene has no such light; it has lamp"):
        scenes.change(HALL, INFO, moon)
    assert scenes.of(HALL).lights == {"lamp": LightEdit(on=False)}
    assert told == []


def test_the_longest_unchanged_edits_are_forgotten_and_that_is_told() -> None:
    scenes, told = EditedScenes(), []
    scenes.listeners.add(told.append)
    refs = [SceneRef(f"hall {number}", "hall.glb") for number in range(MOST_EDITED + 1)]
    for ref in refs:
        scenes.change(ref, INFO, OFF)
    assert scenes.of(refs[0]) == NO_EDITS
    assert scenes.of(refs[1]) != NO_EDITS
    assert told == [*refs[:-1], refs[0], refs[-1]]


def test_a_time_needs_an_animation() -> None:
    scenes, walks = EditedScenes(), INFO.model_copy(update={"animations": (AnimationInfo(id="walk", seconds=2.0),)})
    with pytest.raises(UserError, match=r"^time: the scene has no animations$"):
        scenes.change(HALL, INFO, ScenePatch(time=1.0))
    assert scenes.change(HALL, walks, ScenePatch(time=1.0)) == SceneEdits(time=1.0)


def test_edits_of_a_viewer_begin_as_those_of_all_and_others_neither_see_nor_hear_of_them() -> None:
    scenes, told = EditedScenes(), []
    scenes.change(HALL, INFO, OFF, viewer=1)
    scenes.listeners.add(told.append)
    scenes.begin_own(HALL, 1)
    assert scenes.of(HALL, 1) == scenes.of(HALL, 2) == scenes.of(HALL) != NO_EDITS
    scenes.change(HALL, INFO, ScenePatch(lights=None), viewer=1)
    assert (scenes.of(HALL, 1), scenes.of(HALL, 2).lights) == (NO_EDITS, {"lamp": LightEdit(on=False)})
    assert (scenes.is_own(HALL, 1), scenes.is_own(HALL, 2), told) == (True, False, [])
    scenes.end_own(1)
    assert scenes.of(HALL, 1) == scenes.of(HALL)


def test_edits_of_a_viewer_can_become_those_of_all() -> None:
    scenes, told = EditedScenes(), []
    scenes.listeners.add(told.append)
    scenes.begin_own(HALL, 1)
    scenes.change(HALL, INFO, OFF, viewer=1)
    assert scenes.end_own(1, share=True)
    assert not scenes.end_own(1, share=True)  # which it has not any more
    assert scenes.of(HALL).lights == {"lamp": LightEdit(on=False)}
    assert told == [HALL]


def test_few_viewers_have_edits_of_their_own() -> None:
    scenes = EditedScenes(most_own=1)
    scenes.begin_own(HALL, 1)
    scenes.begin_own(HALL, 1)
    with pytest.raises(TooBusyError, match="1 viewers have edits of their own, as many as may"):
        scenes.begin_own(HALL, 2)
    scenes.end_own(1)
    scenes.begin_own(HALL, 2)


def test_a_file_that_changes_takes_over_what_fits(caplog: pytest.LogCaptureFixture) -> None:
    scenes, told = EditedScenes(), []
    scenes.change(HALL, LIT, OFF)
    scenes.change(HALL, LIT, ScenePatch(lights={"sky": LightEdit(on=False)}))
    before = scenes.of(HALL)
    scenes.listeners.add(told.append)
    newer = replace(HALL, stamp=2)
    scenes.learn(newer, INFO)
    assert scenes.of(newer).lights == {"lamp": LightEdit(on=False)}
    assert (scenes.of(HALL), [*scenes.all], told) == (before, [newer], [newer])  # whoever sees the old one still does
    assert "hall: edits that do not fit its file any more end: lights.sky" in caplog.text
    scenes.change(newer, INFO, ScenePatch(lights=None))
    scenes.learn(newer, INFO)
    scenes.learn(replace(HALL, stamp=3), INFO)
    assert scenes.all == {}


def test_an_older_file_that_replaces_a_newer_one_takes_over_what_that_has() -> None:
    scenes, older = EditedScenes(), replace(HALL, stamp=0)
    scenes.change(HALL, INFO, OFF)
    assert scenes.unproven(older)
    scenes.learn(older, INFO)
    assert (scenes.of(older), [*scenes.all]) == (scenes.of(HALL), [older])
    scenes.change(older, INFO, ScenePatch(lights={"lamp": LightEdit(intensity=2.0)}))
    scenes.learn(HALL, INFO)  # which comes back
    assert (scenes.of(HALL), [*scenes.all]) == (scenes.of(older), [HALL])
    scenes.change(HALL, INFO, ScenePatch(lights=None))
    scenes.learn(older, INFO)
    assert (scenes.of(older), scenes.all) == (NO_EDITS, {})


def test_another_scene_can_take_edits_over() -> None:
    scenes, again = EditedScenes(), SceneRef("hall-2", "hall-2", 1)
    scenes.change(HALL, INFO, OFF)
    scenes.change(HALL, LIT, ScenePatch(lights={"sky": LightEdit(on=False)}))
    scenes.take_over(HALL, again)
    assert scenes.unproven(again)
    scenes.learn(again, INFO)
    assert not scenes.unproven(again)
    assert (scenes.of(again).lights, len(scenes.of(HALL).lights)) == ({"lamp": LightEdit(on=False)}, 2)
    scenes.take_over(SceneRef("other", "other"), SceneRef("third", "third"))
    assert [*scenes.all] == [HALL, again]


def test_a_file_that_is_read_otherwise_takes_nothing_over() -> None:
    scenes = EditedScenes()
    scenes.change(HALL, INFO, OFF)
    for other in (
        replace(HALL, stamp=2, options=ImportOptions(unit="mm")),
        SceneRef("b", "b", 2),
    ):
        scenes.learn(other, INFO)
        assert scenes.of(other) == NO_EDITS
    assert [*scenes.all] == [HALL]


def test_edits_fit_each_alone_and_all_objects_together() -> None:
    box = Bounds(min=(0, 0, 0), max=(1, 1, 1))
    info = INFO.model_copy(update={"objects": (ObjectInfo(id="a", box=box), ObjectInfo(id="b", box=box))})
    hidden, off = ObjectEdit(visible=False), {"lamp": LightEdit(on=False)}
    fits, gone = fitting(SceneEdits(time=1.0, objects={"a": hidden, "c": hidden}, lights=off), editable(info))
    assert (fits, gone) == (SceneEdits(objects={"a": hidden}, lights=off), ["objects.c", "time"])
    fits, gone = fitting(SceneEdits(objects={"a": hidden, "b": hidden}, lights=off), editable(info))
    assert (fits, gone) == (SceneEdits(lights=off), ["objects"])
