"""Lights and materials in a real browser: changed by pointer and keyboard, undone, and seen by others."""

import json
import re
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from harness import Running
from looking import pixel, wait_for
from playwright.sync_api import Browser, Page, expect
from staged import FRONT, Stage, visit

from gpu.scene.edits import NO_EDITS


@pytest.fixture
def stage(page: Page, gradients: Running) -> Stage:
    """A page with its first picture, whose sheet of objects, materials and lights is open."""
    stage = visit(page, gradients)
    page.keyboard.press("KeyG")
    return stage


@pytest.fixture
def other(page: Page, browser: Browser, gradients: Running) -> Iterator[Page]:
    """A second viewer's page beside `page`; the sheets of both are open."""
    with closing(browser.new_context(viewport={"width": 800, "height": 600})) as context:
        second = context.new_page()
        for one in (page, second):
            one.goto(str(gradients.http.base_url))
            expect(one.locator("body[data-picture]")).to_be_attached()
            one.keyboard.press("KeyG")
        yield second


def patches(stage: Stage, count: int) -> list[dict[str, Any]]:
    stage.hear("edit", count)
    return [message["patch"] for message in stage.all("edit")]


def test_what_one_does_all_see(page: Page, other: Page) -> None:
    assert pixel(other, 0.9)[0] > 200
    page.get_by_label("lamp", exact=True).focus()
    page.keyboard.press("Space")
    for one in (page, other):
        wait_for(one, lambda one=one: pixel(one, 0.9)[0] < 30)
    expect(other.get_by_label("lamp", exact=True)).not_to_be_checked()
    expect(other.get_by_role("button", name="Undo")).to_be_disabled()
    page.keyboard.press("Control+z")
    wait_for(other, lambda: pixel(other, 0.9)[0] > 200)
    expect(other.get_by_label("lamp", exact=True)).to_be_checked()
    page.keyboard.press("Control+Shift+Z")
    wait_for(other, lambda: pixel(other, 0.9)[0] < 30)
    other.get_by_role("button", name="All as the file says").click()
    wait_for(page, lambda: pixel(page, 0.9)[0] > 200)


def test_what_one_does_alone_others_see_once_it_is_shared(page: Page, other: Page) -> None:
    page.get_by_label("changes for me alone").check()
    page.get_by_label("lamp", exact=True).click()
    wait_for(page, lambda: pixel(page, 0.9)[0] < 30)
    other.get_by_label("Intensity of lamp").fill("25")  # a quarter as bright, which only others see
    wait_for(other, lambda: 30 < pixel(other, 0.9)[0] < 100)
    expect(other.get_by_label("lamp", exact=True)).to_be_checked()
    expect(page.get_by_label("Intensity of lamp")).to_have_value("50")
    page.get_by_role("button", name="Show mine to all").click()
    wait_for(other, lambda: pixel(other, 0.9)[0] < 30)
    expect(page.get_by_label("changes for me alone")).not_to_be_checked()
    page.get_by_role("button", name="Undo").click()
    for one in (page, other):  # what all saw before
        wait_for(one, lambda one=one: 30 < pixel(one, 0.9)[0] < 100)
    expect(page.get_by_label("Intensity of lamp")).to_have_value("25")
    page.get_by_role("button", name="Redo").click()
    wait_for(other, lambda: pixel(other, 0.9)[0] < 30)
    page.get_by_role("button", name="All as the file says").click()
    wait_for(other, lambda: pixel(other, 0.9)[0] > 200)


def test_a_slider_that_is_dragged_is_one_step(page: Page, stage: Stage) -> None:
    slider = page.get_by_label("Intensity of lamp")
    expect(page.get_by_label("Colour of lamp")).to_have_value("#ffbc89")
    slider.focus()
    expect(slider).to_have_value("50")
    box = slider.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 1, box["y"] + box["height"] / 2, steps=4)
    page.mouse.up()
    wait_for(page, lambda: patches(stage, 1)[-1] == {"lights": {"lamp": {"intensity": 0}}})
    page.get_by_role("button", name="Undo").click()
    wait_for(page, lambda: patches(stage, 1)[-1] == {"lights": {"lamp": {"intensity": None}}})
    expect(slider).to_have_value("50")
    expect(page.get_by_role("button", name="Undo")).to_be_disabled()


def test_materials_are_changed_by_their_fields(page: Page, stage: Stage) -> None:
    expect(page.get_by_label("roughness")).to_be_hidden()
    page.get_by_label("Material", exact=True).select_option("wall")
    page.get_by_label("roughness").fill("0.25")
    assert patches(stage, 1)[-1] == {"materials": {"wall": {"roughness": 0.25}}}
    page.locator("#material-color").fill("#0000ff")
    assert patches(stage, 2)[-1] == {"materials": {"wall": {"color": [0, 0, 1]}}}
    page.get_by_label("radiance").fill("4")
    assert patches(stage, 3)[-1] == {"materials": {"wall": {"emission": [4, 4, 4]}}}
    expect(page.get_by_label("radiance")).to_have_value("4")


def test_objects_go_and_move(page: Page, stage: Stage) -> None:
    page.get_by_label("Object", exact=True).select_option("chair")
    page.get_by_label("visible").focus()
    page.keyboard.press("Space")
    assert patches(stage, 1)[-1] == {"objects": {"chair": {"visible": False}}}
    page.get_by_label("moved along Y").fill("0.5")
    assert patches(stage, 2)[-1] == {"objects": {"chair": {"offset": [0, 0.5, 0]}}}
    page.get_by_role("button", name="Undo").click()
    assert patches(stage, 3)[-1] == {"objects": {"chair": {"offset": None}}}
    expect(page.get_by_label("moved along Y")).to_have_value("0")
    page.get_by_label("moved along Y").press("ArrowDown")
    assert patches(stage, 4)[-1] == {"objects": {"chair": {"offset": [0, -0.02, 0]}}}


def test_a_sun_stands_by_day_and_hour(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.welcome()
    stage.scene(lights=[{"id": "sun", "form": "directional", "color": [1, 1, 1], "direction": [0, -1, 0]}])
    stage.hear("pose")
    page.keyboard.press("KeyG")
    page.get_by_role("button", name="Turn: sun").click()
    page.get_by_label("Sun by date: sun").check()
    page.get_by_label("longitude [°] of sun").fill("-74")
    page.get_by_label("Day of sun").fill("60")
    page.get_by_label("Hour of sun").fill("6.5")
    expect(page.locator(".slider span")).to_have_text(["1 Mar", "6:30"])
    wait_for(page, lambda: patches(stage, 1)[-1]["lights"]["sun"].get("date", "")[4:] == "-03-01T06:30:00-05:00")
    edits = {**NO_EDITS.model_dump(), "lights": {"sun": {"date": "2026-03-01T12:00:00Z", "place": [40, -74]}}}
    stage.say("edits", scene="cornell-box", edits=edits, edit=9, own=False, suns={"sun": [-1, 0, 0]})
    expect(page.get_by_label("azimuth [°] of sun")).to_have_value("-90")
    expect(page.locator(".slider span")).to_have_text(["1 Mar", "7:00"])
    page.get_by_label("Sun by date: sun").uncheck()
    wait_for(page, lambda: patches(stage, 1)[-1]["lights"]["sun"]["date"] is None)


def test_a_sky_has_a_day_and_hour_of_its_own(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.welcome()
    stage.scene(lights=[{"id": "sky", "form": "sky", "color": [1, 1, 1]}])
    stage.hear("pose")
    page.keyboard.press("KeyG")
    page.get_by_label("Sun by date: sky").check()
    page.get_by_label("Hour of sky").fill("18")
    wait_for(page, lambda: "T18:00:00" in patches(stage, 1)[-1]["lights"]["sky"].get("date", ""))


def test_sun_and_sky_are_of_one_time(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.welcome()
    sun = {"id": "sun", "form": "directional", "color": [1, 1, 1], "direction": [0, -1, 0], "added": True}
    stage.scene(lights=[sun, {"id": "sky", "form": "sky", "color": [1, 1, 1]}])
    stage.hear("pose")
    page.keyboard.press("KeyG")
    page.get_by_label("Sun by date: sun").check()
    page.get_by_label("Hour of sun").fill("18")
    wait_for(page, lambda: "T18:00:00" in patches(stage, 1)[-1]["lights"]["sun"].get("date", ""))
    page.get_by_label("Sun by date: sky").check()
    wait_for(page, lambda: "T18:00:00" in patches(stage, 1)[-1]["lights"].get("sky", {}).get("date", ""))
    page.get_by_label("Hour of sky").fill("9")
    wait_for(page, lambda: patches(stage, 1)[-1]["lights"].keys() == {"sun", "sky"})
    told = patches(stage, 1)[-1]["lights"]
    assert told["sun"] == {name: told["sky"][name] for name in ("date", "place", "north")}
    assert "T09:00:00" in told["sun"]["date"]


def test_a_sun_that_the_file_has_not_is_off_until_it_is_added(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.welcome()
    stage.scene(lights=[{"id": "sun", "form": "directional", "color": [1, 1, 1], "direction": [0, -1, 0],
                         "added": True}])  # fmt: skip
    stage.hear("pose")
    page.keyboard.press("KeyG")
    expect(page.get_by_text("This scene has none.")).to_be_visible()
    shines = page.get_by_label("sun not in the file")
    expect(shines).not_to_be_checked()
    page.get_by_label("Sun by date: sun").check()
    wait_for(page, lambda: "date" in patches(stage, 1)[-1]["lights"]["sun"])
    expect(shines).to_be_checked()
    page.get_by_label("Sun by date: sun").uncheck()
    expect(shines).not_to_be_checked()
    shines.check()
    wait_for(page, lambda: patches(stage, 1)[-1] == {"lights": {"sun": {"on": True}}})


def test_a_light_is_brought_to_the_camera(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.welcome()
    spot = {"id": "spot", "form": "spot", "color": [1, 1, 1], "position": [5, 5, 5], "direction": [0, -1, 0]}
    sun = {"id": "sun", "form": "directional", "color": [1, 1, 1], "direction": [0, -1, 0]}
    matrix = [*FRONT["matrix"][:12], 1.0, 2.0, 3.0, 1.0]
    stage.scene(lights=[spot, sun], cameras=[{**FRONT, "matrix": matrix}])
    stage.hear("pose")
    page.keyboard.press("KeyG")
    page.get_by_role("button", name="Bring here: spot").press("Enter")
    patch = patches(stage, 1)[-1]["lights"]["spot"]
    assert patch["position"] == [1, 2, 3]
    assert patch["direction"] == pytest.approx([0, 0, -1])
    page.get_by_role("button", name="Shine along the view: sun").press("Enter")
    assert patches(stage, 2)[-1]["lights"] == {"sun": {"direction": pytest.approx([0, 0, -1])}}


def test_a_refused_edit_is_said_and_taken_back(page: Page, stage: Stage) -> None:
    page.get_by_label("lamp", exact=True).click()
    expect(page.get_by_label("lamp", exact=True)).not_to_be_checked()
    number = stage.hear("edit")["id"]
    stage.say("error", code="edit-refused", message="this server takes no edits of its scenes", edit=number)
    stage.say("edits", scene="cornell-box", edits=NO_EDITS.model_dump(), edit=number, own=False, suns={})
    expect(page.get_by_label("lamp", exact=True)).to_be_checked()
    expect(page.locator("#toast")).to_contain_text("takes no edits")


def test_a_server_that_takes_no_edits_offers_none(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    stage.takes_edits = False
    page.goto(str(gradients.http.base_url))
    stage.start()
    expect(page.locator("body[data-picture]")).to_be_attached()
    expect(page.get_by_role("button", name="Lights, materials and objects")).to_be_hidden()
    page.keyboard.press("KeyG")
    expect(page.locator("#mixer")).to_be_hidden()


def test_own_changes_outlast_a_reload_of_the_page(page: Page, other: Page) -> None:
    page.get_by_label("for me alone").check()
    light = page.locator("#lights input[type=checkbox]").first
    light.click()
    expect(light).not_to_be_checked()
    page.wait_for_timeout(300)  # until the server knows
    page.reload()
    expect(page.locator("body[data-picture]")).to_be_attached()
    page.keyboard.press("KeyG")
    expect(page.get_by_label("for me alone")).to_be_checked()
    expect(light).not_to_be_checked()
    expect(other.locator("#lights input[type=checkbox]").first).to_be_checked()
    page.get_by_label("for me alone").uncheck()
    expect(light).to_be_checked()
    page.reload()
    expect(page.locator("body[data-picture]")).to_be_attached()
    page.keyboard.press("KeyG")
    expect(page.get_by_label("for me alone")).not_to_be_checked()


def test_a_scene_is_downloaded_where_the_server_gives_it_out(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    stage.gives_exports = True
    page.goto(str(gradients.http.base_url))
    stage.start()
    page.keyboard.press("KeyG")
    link = page.get_by_role("link", name="Download as GLB")
    expect(link).to_have_attribute("href", re.compile(r"/api/v1/scenes/cornell-box/export\.glb$"))
    page.get_by_label("for me alone").check()
    page.route(re.compile(r"/export\.glb$"), lambda route: route.fulfill(body=route.request.post_data or ""))
    with page.expect_download() as downloaded:
        link.click()
    assert downloaded.value.suggested_filename == "cornell-box.glb"
    assert json.loads(downloaded.value.path().read_text())["lights"] == {}
    expect(page.locator("#toast")).to_have_text("The scene is saved")
    stage.gives_exports = False
    stage.reload()
    page.keyboard.press("KeyG")
    expect(page.locator("#mixer")).to_be_visible()
    expect(link).to_be_hidden()
