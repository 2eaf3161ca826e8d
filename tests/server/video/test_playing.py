import pytest

from gpu.scene.edits import NO_EDITS, LightEdit, SceneEdits
from server.video.film_settings import Play
from server.video.playing import played

LENGTHS = {"walk": 2.0, "run": 0.5, "stand": 0.0}
OFF = SceneEdits(lights={"lamp": LightEdit(on=False)})


@pytest.mark.parametrize(
    ("play", "start", "time", "now"),
    [
        (Play.LOOP, None, 0.0, 0.0),
        (Play.LOOP, 0.5, 1.0, 1.5),
        (Play.LOOP, 0.5, 1.5, 0.0),
        (Play.LOOP, 0.5, 6.25, 0.75),
        (Play.ONCE, 0.5, 1.0, 1.5),
        (Play.ONCE, None, 9.0, 2.0),
        (Play.NONE, None, 9.0, None),
        (Play.NONE, 0.5, 9.0, 0.5),
    ],
)
def test_time_goes_on_from_the_moment_that_is_chosen(
    play: Play, start: float | None, time: float, now: float | None
) -> None:
    found = played(OFF.model_copy(update={"time": start}), LENGTHS, play, time)
    assert found == OFF.model_copy(update={"time": now})


def test_the_chosen_animation_gives_the_length() -> None:
    assert played(SceneEdits(animation="run"), LENGTHS, Play.LOOP, 0.75).time == 0.25
    assert played(SceneEdits(animation="stand"), LENGTHS, Play.LOOP, 0.75).time == 0.0


def test_a_scene_without_animations_stays_as_it_is() -> None:
    assert played(NO_EDITS, {}, Play.LOOP, 1.0) is NO_EDITS


def test_an_animation_that_there_is_not_is_left_for_the_worker_to_say() -> None:
    edits = SceneEdits(animation="fly", time=0.5)
    assert played(edits, LENGTHS, Play.LOOP, 1.0) is edits
