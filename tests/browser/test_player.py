"""The time line of a scene with animations, in a real browser."""

from typing import Any

import pytest
from harness import Running
from looking import edges_of, overlapping, wait_for
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
    page.get_by_role("slider", name="Time").fill("3")
    stage.say("edits", scene="hall.glb", edits=edits, edit=0, own=False, suns={})  # said before that was heard
    page.wait_for_timeout(100)
    expect(page.get_by_text("3.0 of 4.0 s")).to_be_visible()


def test_who_may_not_edit_has_no_time_line(page: Page, stage: Stage) -> None:
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    stage.takes_edits = False
    stage.reload()
    stage.scene("hall.glb", animations=ANIMATIONS)
    wait_for(page, lambda: page.title() == "hall.glb – lumenwalk")
    expect(page.get_by_role("button", name="Play")).to_be_hidden()


def test_what_plays_stops_where_another_scene_is_chosen(page: Page, stage: Stage) -> None:
    page.get_by_role("button", name="Play").click()
    stage.hear("edit", 2)
    page.locator("#scene").select_option("cornell-box")
    wait_for(page, lambda: stage.all("settings")[-1].get("scene") == "cornell-box")
    said = len(stage.all("edit"))
    page.wait_for_timeout(200)
    stage.scene("cornell-box", animations=ANIMATIONS[1:])
    wait_for(page, lambda: page.title() == "cornell-box – lumenwalk")
    page.wait_for_timeout(100)
    assert len(stage.all("edit")) == said
    expect(page.get_by_text("0.0 of 1.0 s")).to_be_visible()


def test_what_plays_goes_on_when_the_connection_is_back(page: Page, stage: Stage) -> None:
    long = [{"id": "walk", "seconds": 600.0}]  # it does not begin anew meanwhile
    stage.scene("hall.glb", animations=long)
    expect(page.get_by_text("of 600.0 s")).to_be_visible()
    page.get_by_role("button", name="Play").click()
    stage.hear("edit", 3)
    before, connections = moments(stage)[-1]["time"], stage.connections
    stage.close(1012)
    wait_for(page, lambda: stage.connections > connections)
    stage.welcome()
    assert stage.all("edit") == []
    stage.scene("hall.glb", animations=long)
    assert stage.hear("edit", 2)["patch"]["time"] > before
    page.get_by_role("button", name="Pause").click()


def test_the_time_line_has_its_place_in_a_window_of_any_width(page: Page, stage: Stage) -> None:
    page.keyboard.press("KeyG")
    for width, height in ((1280, 720), (1000, 600), (844, 390)):
        page.set_viewport_size({"width": width, "height": height})
        edges = {name: edges_of(page, name) for name in ("player", "move-bar", "stats", "mixer", "title-bar")}
        assert overlapping(edges) == [], f"at {width} by {height}"
        assert all(left >= 0 and right <= width for left, _, right, _ in edges.values())


def test_all_of_the_time_line_is_to_be_read_on_a_phone(page: Page, stage: Stage) -> None:
    stage.scene("hall.glb", animations=[{"id": "walk around", "seconds": 600.0}, {"id": "wave", "seconds": 1.0}])
    for width in (390, 320):
        page.set_viewport_size({"width": width, "height": 700})
        _, top, right, bottom = edges_of(page, "player")
        assert edges_of(page, "stats")[3] <= top
        assert bottom <= edges_of(page, "move-bar")[1]
        left, _, end, _ = edges_of(page, "player-animation")
        assert end - left > 150
        _, _, end, low = edges_of(page, "player-loop")
        assert end <= right
        assert low <= bottom
