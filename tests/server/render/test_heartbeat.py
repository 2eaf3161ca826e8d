from dataclasses import replace

import pytest

from gpu.settings import RenderSettings
from server.render.heartbeat import heartbeat, is_warm
from server.wire.worker import HEARTBEAT, Render, SceneCamera, SceneRef

HALL, YARD = SceneRef("hall", "hall"), SceneRef("yard", "yard")
LAST = Render(7, HALL, SceneCamera(2), (640, 360), RenderSettings(seed=5), "jpeg", sample=3)


def test_a_heartbeat_is_one_pixel_of_what_was_rendered_last() -> None:
    beat = heartbeat(LAST, (YARD, HALL), YARD)
    assert replace(beat, settings=LAST.settings) == Render(
        HEARTBEAT, HALL, SceneCamera(2), (1, 1), LAST.settings, "none"
    )
    assert beat.settings.seed == 5
    assert is_warm(LAST, (YARD, HALL))


@pytest.mark.parametrize("last", [None, LAST])
@pytest.mark.parametrize(("scenes", "rendered"), [((), HALL), ((HALL, YARD), YARD)])
def test_without_that_it_is_of_a_scene_on_the_device_or_the_served_one(
    last: Render | None, scenes: tuple[SceneRef, ...], rendered: SceneRef
) -> None:
    last = last and replace(last, scene=SceneRef("closed", "closed"))
    assert not is_warm(last, scenes)
    assert heartbeat(last, scenes, HALL).scene == rendered


@pytest.mark.parametrize("last", [None, LAST])
def test_nothing_kept_is_shown(last: Render | None) -> None:
    assert not heartbeat(last, (HALL,), HALL).settings.skip.unchanged_camera
