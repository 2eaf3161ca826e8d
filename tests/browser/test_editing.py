"""What is in the picture, in a real browser: clicked, dragged along an axis, moved by keys, undone, seen by others."""

import re
from contextlib import closing
from typing import Any

import pytest
from harness import Running
from looking import wait_for
from playwright.sync_api import Browser, Page, Route, expect
from staged import LAMP, Stage

from gpu.scene.edits import NO_EDITS

CHAIR = {"id": "chair", "box": {"min": [-0.1, -0.1, -0.9], "max": [0.1, 0.1, -0.7]}}
BULB = {"id": "bulb", "form": "point", "color": [1, 1, 1], "position": [0.0, 0.25, -1.0]}
CHAIR_AT, LAMP_AT = (300, 150), (1000, 690)  # on a page of 1280×720, whose service has something in each half
METRES_A_PIXEL = 0.8 * 1.0926 / 720  # at the chair's middle, of a picture 1 rad high


@pytest.fixture
def stage(page: Page, gradients: Running) -> Stage:
    """A page in a scene of a chair straight ahead and a bulb above it; picks are answered by the service."""
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.welcome()
    stage.scene(objects=[CHAIR], lights=[LAMP, BULB])
    stage.say("status", state="ready", text="", fraction=0.0)
    stage.hear("pose")
    stage.frame((64, 64, 64))
    expect(page.locator("body[data-picture]")).to_be_attached()
    return stage


def hears(stage: Stage, patch: dict[str, Any]) -> None:
    """Waits for an edit, which comes after others of its gesture."""
    wait_for(stage.page, lambda: [message["patch"] for message in stage.all("edit")][-1:] == [patch])


def drag(page: Page, handle: str, right: int, down: int) -> None:
    end = page.get_by_role("slider", name=handle).locator("circle").bounding_box()
    assert end is not None
    x, y = end["x"] + end["width"] / 2, end["y"] + end["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=4)
    page.mouse.up()


def test_a_click_chooses_what_is_there(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    expect(page.get_by_label("Object", exact=True)).to_have_value("chair")
    expect(page.get_by_label("Material", exact=True)).to_have_value("wall")
    expect(page.locator("#toast")).to_have_text("chair, wall: 0.7 m away")
    assert stage.all("edit") == []


def test_of_two_clicks_the_later_one_counts(page: Page, stage: Stage) -> None:
    asked: list[Route] = []
    page.route(re.compile("/pick$"), lambda route: asked.append(route))
    page.mouse.click(*CHAIR_AT)
    wait_for(page, lambda: len(asked) == 1)
    page.mouse.click(*LAMP_AT)
    wait_for(page, lambda: len(asked) == 2)
    for route, object_ in zip(reversed(asked), ("chair", None), strict=True):
        route.fulfill(json={"object": object_, "material": None, "light": None, "point": None, "distance": None})
        page.wait_for_timeout(100)
    expect(page.get_by_label("Object", exact=True)).to_have_value("chair")
    expect(page.locator("#toast")).to_have_text("chair")


def test_what_the_server_refuses_can_not_be_undone(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    page.get_by_label("moved along X").fill("5")
    number = stage.hear("edit")["id"]
    expect(page.get_by_label("Undo", exact=True)).to_be_enabled()
    words = "objects.chair.offset: takes it 4 m beyond the box of the scene"
    stage.say("error", code="edit-refused", message=words, edit=number)
    edits = NO_EDITS.model_dump(mode="json")
    stage.say("edits", scene="cornell-box", edits=edits, edit=number, own=False, suns={})
    expect(page.get_by_label("Undo", exact=True)).to_be_disabled()
    expect(page.locator("#toast")).to_contain_text("4 m beyond")


@pytest.mark.parametrize(
    ("run", "kept", "enabled"), [("first", True, True), ("second", True, True), ("second", False, False)]
)
def test_what_a_service_did_can_be_undone_in_one_that_knows_of_it(
    page: Page, stage: Stage, run: str, kept: bool, enabled: bool
) -> None:
    page.mouse.click(*CHAIR_AT)
    page.get_by_label("moved along X").fill("5")
    edit = stage.hear("edit")
    none = NO_EDITS.model_dump(mode="json")
    edits = {**none, "objects": {"chair": {"offset": [5, 0, 0]}}}
    stage.say("edits", scene="cornell-box", edits=edits, edit=edit["id"], own=False, suns={})
    stage.run = run
    connections = stage.connections
    stage.close(1012)
    wait_for(page, lambda: stage.connections > connections)
    stage.welcome()
    stage.scene(objects=[CHAIR], lights=[LAMP, BULB])
    stage.say("edits", scene="cornell-box", edits=edits if kept else none, edit=0, own=False, suns={})
    expect(page.locator("#connection-text")).to_have_text("Connected")
    expect(page.get_by_label("Undo", exact=True)).to_be_enabled(enabled=enabled)
    if not enabled:
        expect(page.locator("#toast")).to_contain_text("what was changed before cannot be undone")


def test_a_drag_chooses_nothing(page: Page, stage: Stage) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.mouse.move(*CHAIR_AT)
    page.mouse.down()
    page.mouse.move(CHAIR_AT[0] + 40, CHAIR_AT[1], steps=4)
    page.mouse.up()
    stage.hear("pose", 2)
    page.keyboard.press("KeyV")  # the middle is asked for, and nothing else was
    expect(page.get_by_label("Object", exact=True)).to_have_value("chair")
    assert len([url for url in asked if url.endswith("/pick")]) == 1


def test_what_is_dragged_along_an_axis_moves_in_one_step(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    expect(page.get_by_role("slider", name="Move chair along Z")).to_be_hidden()  # it is seen from its end
    drag(page, "Move chair along X", right=100, down=30)
    field = page.get_by_label("moved along X")
    wait_for(page, lambda: float(field.input_value()) == pytest.approx(100 * METRES_A_PIXEL, abs=2e-3))
    x = float(field.input_value())
    hears(stage, {"objects": {"chair": {"offset": [x, 0, 0]}}})
    page.keyboard.press("Control+z")
    expect(page.get_by_label("moved along X")).to_have_value("0")
    hears(stage, {"objects": {"chair": {"offset": None}}})
    expect(page.get_by_role("button", name="Undo")).to_be_disabled()
    drag(page, "Move chair along Y", right=0, down=-5000)  # it stays within the scene
    expect(page.get_by_label("moved along Y")).to_have_value("0.9")


def test_keys_move_what_is_chosen_and_not_the_camera(page: Page, stage: Stage) -> None:
    page.keyboard.press("KeyV")
    handle = page.get_by_role("slider", name="Move chair along X")
    poses = len(stage.all("pose"))
    handle.press("ArrowRight")
    expect(handle).to_have_attribute("aria-valuetext", "0.02 m")
    page.get_by_label("step [m]").fill("0.5")
    handle.press("ArrowLeft")
    expect(handle).to_have_attribute("aria-valuetext", "-0.48 m")
    handle.press("PageUp")  # ten steps: to the end of the scene
    expect(handle).to_have_attribute("aria-valuetext", "0.9 m")
    hears(stage, {"objects": {"chair": {"offset": [0.9, 0, 0]}}})
    edits = len(stage.all("edit"))
    handle.press("ArrowRight")
    expect(page.locator("#toast")).to_have_text("chair stays within the box of the scene")
    assert (len(stage.all("pose")), len(stage.all("edit"))) == (poses, edits)


def test_undo_is_heard_wherever_the_keyboard_is_while_the_sheet_is_open(page: Page, stage: Stage) -> None:
    page.keyboard.press("KeyV")
    page.get_by_role("slider", name="Move chair along X").press("ArrowRight")
    hears(stage, {"objects": {"chair": {"offset": [0.02, 0, 0]}}})
    page.locator("#view").focus()  # as after a walk
    page.keyboard.press("Control+z")
    hears(stage, {"objects": {"chair": {"offset": None}}})
    page.keyboard.press("Control+y")
    hears(stage, {"objects": {"chair": {"offset": [0.02, 0, 0]}}})
    cyrillic = {"key": "я", "code": "KeyZ", "ctrlKey": True, "bubbles": True}
    page.locator("#view").dispatch_event("keydown", cyrillic)
    hears(stage, {"objects": {"chair": {"offset": None}}})
    page.keyboard.press("Control+y")
    hears(stage, {"objects": {"chair": {"offset": [0.02, 0, 0]}}})
    said = len(stage.all("edit"))
    page.keyboard.press("KeyG")
    expect(page.locator("#mixer")).to_be_hidden()
    page.keyboard.press("Control+z")
    page.wait_for_timeout(100)
    assert len(stage.all("edit")) == said


def test_what_is_dragged_about_an_axis_turns(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    page.get_by_label("Turn", exact=True).check()
    drag(page, "Turn chair about Y", right=-40, down=0)
    turned = float(page.get_by_label("turned about Y").input_value())
    assert -60.0 < turned < -20.0
    hears(stage, {"objects": {"chair": {"rotation": [0, turned, 0]}}})
    page.get_by_role("slider", name="Turn chair about X").press("ArrowUp")
    expect(page.get_by_role("slider", name="Turn chair about Z")).not_to_have_attribute("aria-valuetext", "0°")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    hears(stage, {"objects": {"chair": {"rotation": None}}})
    page.get_by_label("turned about Z").press("ArrowUp")
    hears(stage, {"objects": {"chair": {"rotation": [0, 0, 5]}}})


def test_what_a_field_cannot_have_is_not_sent_with_the_others_and_goes(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    page.get_by_label("turned about X").fill("400")
    page.get_by_label("turned about Y").fill("30")
    hears(stage, {"objects": {"chair": {"rotation": [0, 30, 0]}}})
    expect(page.get_by_label("turned about X")).to_have_value("0")
    page.get_by_label("turned about Z").fill("358")
    page.get_by_label("turned about Z").press("ArrowUp")
    expect(page.get_by_label("turned about Z")).to_have_value("358")
    page.get_by_label("moved along X").fill("2e9")
    page.wait_for_timeout(100)
    hears(stage, {"objects": {"chair": {"rotation": [0, 30, 358]}}})
    page.get_by_label("radiance").fill("-5")
    page.get_by_label("colour of its light").fill("#ff0000")
    hears(stage, {"materials": {"wall": {"emission": [0, 0, 0]}}})


def test_what_is_dragged_by_its_grip_is_made_larger(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    page.get_by_label("Size", exact=True).check()
    drag(page, "Make chair larger", right=24, down=-24)  # from 84 px of the middle to 118
    scale = float(page.get_by_label("times as large").input_value())
    assert scale == pytest.approx(1.4, abs=0.05)
    hears(stage, {"objects": {"chair": {"scale": scale}}})
    page.get_by_role("slider", name="Make chair larger").press("ArrowUp")
    expect(page.get_by_label("times as large")).to_have_value(f"{round(1.05 * scale, 5):g}")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    hears(stage, {"objects": {"chair": {"scale": None}}})
    page.get_by_label("times as large").press("ArrowUp")
    hears(stage, {"objects": {"chair": {"scale": 1.05}}})


def test_a_sun_is_turned_where_the_viewer_looks(page: Page, stage: Stage) -> None:
    sun = {"id": "sun", "form": "directional", "color": [1, 1, 1], "direction": [0.0, -1.0, 0.0]}
    stage.scene(lights=[sun])
    page.keyboard.press("KeyG")
    page.get_by_role("button", name="Turn: sun").click()
    handle = page.get_by_role("slider", name="Turn sun about X")
    page.get_by_label("step [°]").fill("90")
    handle.press("ArrowUp")
    hears(stage, {"lights": {"sun": {"direction": [0, 0, -1]}}})
    expect(page.get_by_label("elevation [°] of sun")).to_have_value("0")
    page.get_by_label("azimuth [°] of sun").fill("90")
    hears(stage, {"lights": {"sun": {"direction": [1, 0, 0]}}})
    page.get_by_label("azimuth [°] of sun").select_text()
    page.keyboard.type("269.5")  # which is -90.5°, and is 269 on the way
    hears(stage, {"lights": {"sun": {"direction": [-0.999962, 0, 0.008727]}}})
    expect(page.get_by_label("azimuth [°] of sun")).to_have_value("269.5")
    page.keyboard.press("Control+z")
    expect(page.get_by_label("azimuth [°] of sun")).not_to_have_value("269.5")


def test_a_light_without_a_surface_is_chosen_by_its_mark(page: Page, stage: Stage) -> None:
    page.keyboard.press("KeyG")
    page.locator(".light-mark").click()
    expect(page.locator(".light[aria-current]")).to_contain_text("bulb")
    drag(page, "Move bulb along X", right=-80, down=0)
    x = float(page.get_by_label("X [m] of bulb").input_value())
    assert x == pytest.approx(-80 * METRES_A_PIXEL / 0.8, abs=2e-3)
    hears(stage, {"lights": {"bulb": {"position": [x, 0.25, -1]}}})
    page.get_by_label("Y [m] of bulb").press("ArrowUp")
    hears(stage, {"lights": {"bulb": {"position": [x, 0.27, -1]}}})


def test_what_is_chosen_stays_so_and_can_be_undone_on_another_connection(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    page.get_by_role("slider", name="Move chair along X").press("ArrowRight")
    hears(stage, {"objects": {"chair": {"offset": [0.02, 0, 0]}}})
    page.get_by_label("step [m]").fill("0.5")
    connections = stage.connections
    stage.close(1012)
    wait_for(page, lambda: stage.connections > connections)
    stage.welcome()
    stage.scene(objects=[CHAIR], lights=[LAMP, BULB])
    edits = {"lights": {}, "materials": {}, "objects": {"chair": {"offset": [0.02, 0, 0]}}, "time": None}
    stage.say("edits", scene="cornell-box", edits=edits | {"animation": None}, edit=0, own=False, suns={})
    expect(page.get_by_label("Object", exact=True)).to_have_value("chair")
    expect(page.get_by_label("moved along X")).to_have_value("0.02")
    expect(page.get_by_role("slider", name="Move chair along X")).to_be_visible()
    expect(page.get_by_label("step [m]")).to_have_value("0.5")
    page.get_by_role("button", name="Undo").click()
    hears(stage, {"objects": {"chair": {"offset": None}}})


def test_what_is_changed_while_the_server_is_away_is_sent_when_it_is_back(page: Page, stage: Stage) -> None:
    page.mouse.click(*CHAIR_AT)
    stage.away = True
    stage.close(1012)
    expect(page.locator("#notice")).to_be_visible()
    page.get_by_label("moved along X").fill("0.5")
    stage.away = False
    connections = stage.connections
    wait_for(page, lambda: stage.connections > connections)
    stage.welcome()
    stage.scene(objects=[CHAIR], lights=[LAMP, BULB])
    hears(stage, {"objects": {"chair": {"offset": [0.5, 0, 0]}}})
    expect(page.get_by_label("moved along X")).to_have_value("0.5")


def test_others_see_what_was_moved_and_what_shines_is_chosen(page: Page, browser: Browser, gradients: Running) -> None:
    """Two viewers of the service itself."""
    with closing(browser.new_context(viewport={"width": 1280, "height": 720})) as context:
        other = context.new_page()
        for one in (page, other):
            one.goto(str(gradients.http.base_url))
            expect(one.locator("body[data-picture]")).to_be_attached()
            one.mouse.click(*CHAIR_AT)
            expect(one.get_by_label("Object", exact=True)).to_have_value("chair")
        drag(page, "Move chair along Y", right=0, down=-60)
        moved = page.get_by_label("moved along Y").input_value()
        assert float(moved) == pytest.approx(60 * METRES_A_PIXEL, abs=2e-3)
        expect(other.get_by_label("moved along Y")).to_have_value(moved)
        other.get_by_role("button", name="All as the file says").click()
        expect(page.get_by_label("moved along Y")).to_have_value("0")
        page.keyboard.press("Escape")
        page.mouse.click(*LAMP_AT)
        expect(page.locator(".light[aria-current]")).to_contain_text("lamp")


def test_a_server_that_takes_no_edits_only_tells_what_is_there(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    stage.takes_edits = False
    page.goto(str(gradients.http.base_url))
    stage.start()
    page.mouse.click(*CHAIR_AT)
    expect(page.locator("#toast")).to_contain_text("chair")
    expect(page.locator("#mixer")).to_be_hidden()
