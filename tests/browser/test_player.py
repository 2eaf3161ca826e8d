"""The time line of a scene with animations, in a real browser."""

from typing import Any

import pytest
from harness import Running
from looking import wait_for
from playwright.sync_api import Page, expect
from staged import Stage, visit

ANIMATIONS = [{"id": "walk", "seconds": 4.0}, {"id": "wave", "seconds": 1.0}]


@pytest.fixture
def stage(page: Page, gradients: Running) -> Stage:
    """A page in a scene with animations."""
    stage = visit(page, gradients)
    expect(page.get_by_label("Animation").first).to_be_hidden()
    stage.scene("hall.glb", animations=ANIMATIONS)
    return stage


def moments(stage: Stage) -> list[dict[str, Any]]:
    return [message["patch"] for message in stage.all("edit")]


def test_an_animation_is_played_sought_and_chosen(page: Page, stage: Stage) -> None:
    page.get_by_role("button", name="Play").click()
    stage.hear("edit", 4)
    page.get_by_role("button", name="Pause").click()
    times = [moment["time"] for moment in moments(stage)]
    assert times == sorted(times)
    assert times[-1] > times[0] == 0.0
    page.get_by_role("slider", name="Time").fill("2.5")
    wait_for(page, lambda: moments(stage)[-1] == {"time": 2.5, "animation": "walk"})
    expect(page.get_by_text("2.5 of 4.0 s")).to_be_visible()
    page.get_by_role("combobox", name="Animation").select_option("wave")
    wait_for(page, lambda: moments(stage)[-1] == {"time": 0, "animation": "wave"})
    edits = {"lights": {}, "materials": {}, "objects": {}, "time": 0.5, "animation": "walk"}
    stage.say("edits", scene="hall.glb", edits=edits, edit=stage.all("edit")[-1]["id"], own=False, suns={})
    expect(page.get_by_text("0.5 of 4.0 s")).to_be_visible()
    expect(page.get_by_role("combobox", name="Animation")).to_have_value("walk")


def test_who_may_not_edit_has_no_time_line(page: Page, stage: Stage) -> None:
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    stage.takes_edits = False
    stage.reload()
    stage.scene("hall.glb", animations=ANIMATIONS)
    wait_for(page, lambda: page.title() == "hall.glb – lumenwalk")
    expect(page.get_by_role("button", name="Play")).to_be_hidden()
