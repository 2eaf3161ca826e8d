"""Views that are kept, shared and saved; light and dark; gamepads."""

import re
from io import BytesIO
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
from harness import Running
from looking import cut_choices, pixel, rest, wait_for, walk
from PIL import Image
from playwright.sync_api import Page, expect
from staged import Stage

from server.wire.frame_header import Phase

GAMEPAD = """() => {
    const button = () => ({ pressed: false, touched: false, value: 0 });
    window.pad = { mapping: "standard", axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, button) };
    window.polls = 0;
    navigator.getGamepads = () => { window.polls += 1; return [null, window.pad]; };
}"""

# The link writes a place in this scene to five decimals.
LINK_PLACE = 1e-5


@pytest.fixture
def stage(page: Page, gradients: Running) -> Stage:
    """A page with its first picture."""
    return visit(page, gradients)


def visit(page: Page, service: Running, hash_: str = "") -> Stage:
    stage = Stage(page)
    page.goto(f"{service.http.base_url}/{hash_}")
    stage.start()
    expect(page.locator("body[data-picture]")).to_be_attached()
    return stage


def x(stage: Stage) -> float:
    """Of the camera's place in the newest pose."""
    return float(stage.all("pose")[-1]["matrix"][12])


def link(page: Page) -> dict[str, str]:
    return {name: values[0] for name, values in parse_qs(urlsplit(page.url).fragment).items()}


def test_bookmarks_are_kept_gone_to_by_number_and_removed(page: Page, gradients: Running, stage: Stage) -> None:
    walk(page, "KeyD", lambda: x(stage) > 0.05)
    rest(page, lambda: x(stage))
    page.keyboard.press("KeyB")
    expect(page.locator("#no-bookmarks")).to_be_visible()
    page.get_by_label("Name of the bookmark").fill("the door")
    page.keyboard.press("Enter")
    expect(page.locator("#bookmarks")).to_contain_text("the door")
    page.keyboard.press("Escape")
    expect(page.locator("#views")).to_be_hidden()
    kept = x(stage)
    assert kept > 0.05
    page.keyboard.press("KeyR")
    wait_for(page, lambda: x(stage) == 0)
    page.keyboard.press("Digit1")
    wait_for(page, lambda: x(stage) == kept)

    stage.reload()
    page.keyboard.press("KeyR")
    wait_for(page, lambda: x(stage) == 0)
    page.get_by_role("button", name="Bookmarks and sharing").click()
    page.get_by_role("button", name="the door", exact=True).click()
    wait_for(page, lambda: x(stage) == kept)
    page.get_by_role("button", name="Remove the door").click()
    expect(page.locator("#no-bookmarks")).to_be_visible()
    page.keyboard.press("Escape")
    page.keyboard.press("KeyR")
    page.keyboard.press("Digit1")
    page.wait_for_timeout(200)
    assert x(stage) == 0


def test_bookmarks_that_another_tab_removes_are_gone_here(page: Page, gradients: Running, stage: Stage) -> None:
    page.keyboard.press("KeyB")
    for name in ("door", "window", "stairs"):
        page.get_by_label("Name of the bookmark").fill(name)
        page.keyboard.press("Enter")
    other = page.context.new_page()
    visit(other, gradients)
    other.keyboard.press("KeyB")
    other.get_by_role("button", name="Remove door").click()
    expect(page.get_by_role("button", name="Remove door")).to_have_count(0)
    page.get_by_role("button", name="Remove window").click()
    expect(other.get_by_role("button", name="Remove window")).to_have_count(0)
    expect(other.get_by_role("button", name="stairs", exact=True)).to_be_visible()


def test_the_address_tells_the_view_and_gives_it_back(page: Page, gradients: Running, stage: Stage) -> None:
    walk(page, "KeyD", lambda: x(stage) > 0.05)
    rest(page, lambda: x(stage))
    page.keyboard.press("KeyP")
    page.get_by_label("Method").select_option("path")
    wait_for(page, lambda: link(page).get("method") == "path")
    assert link(page)["scene"] == "cornell-box"
    assert float(link(page)["at"].split(",")[0]) == pytest.approx(x(stage), abs=LINK_PLACE)
    was = x(stage)
    stage.reload()
    assert x(stage) == pytest.approx(was, abs=LINK_PLACE)
    assert stage.hear("settings")["settings"] == {"method": "path"}
    expect(page.get_by_label("Method")).to_have_value("path")


def test_another_link_is_followed(page: Page, stage: Stage) -> None:
    page.evaluate("location.hash = 'scene=cornell-box&at=0.5,0.25,0&look=0,0&fov=90&samples=3'")
    wait_for(page, lambda: x(stage) == 0.5)
    assert stage.all("settings")[-1]["settings"] == {"samples": 3}
    stage.frame((9, 9, 9))
    page.evaluate("location.hash = 'scene=hall.glb&at=0.75,0,0&look=0,0&fov=90'")
    wait_for(page, lambda: stage.all("settings")[-1].get("scene") == "hall.glb")
    stage.scene("hall.glb")
    wait_for(page, lambda: x(stage) == 0.75)
    stage.frame((9, 9, 9))
    page.evaluate("location.hash = 'scene=hall.glb&at=25,0,0&look=0,0&fov=90&unit=cm'")  # the same file, read otherwise
    wait_for(page, lambda: stage.all("settings")[-1].get("scene_options") == {"unit": "cm"})
    stage.scene("hall.glb", frame={"metres_per_unit": 0.01}, options={"unit": "cm"})
    wait_for(page, lambda: x(stage) == 0.25)


def test_a_link_is_followed_though_the_page_tells_its_own_before_it_hears(page: Page, stage: Stage) -> None:
    given = "location.hash = 'scene=cornell-box&at=0.5,0.25,0&look=0,0&fov=90'"
    page.evaluate(f"() => {{ {given}; document.getElementById('copy-link').click(); }}")
    wait_for(page, lambda: x(stage) == 0.5)


def test_a_link_of_junk_shows_the_scene_as_if_there_were_none(page: Page, gradients: Running) -> None:
    stage = visit(page, gradients, "#at=1,2&look=%%&fov=x&method=magic&samples=-3&nothing=1")
    assert x(stage) == 0
    assert "scene" not in stage.hear("hello")
    assert all(not message.get("settings") for message in stage.all("settings"))


def test_a_link_to_a_scene_that_is_gone_says_so_and_shows_the_served_one(page: Page, gradients: Running) -> None:
    page.goto(f"{gradients.http.base_url}/#scene=gone.glb&at=0.5,0,0&look=0,0&fov=60")
    words = re.compile("'gone.glb' here, but cornell-box, .* more; choose one in the list above, or open a file")
    expect(page.locator("#toast")).to_contain_text(words)
    expect(page.locator("#scene")).to_have_value("cornell-box")
    expect(page.locator("body[data-picture]")).to_be_attached()
    assert pixel(page)[1] < 20  # not at the place of the other scene


def test_copies_the_link(page: Page, stage: Stage) -> None:
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.keyboard.press("KeyC")
    expect(page.locator("#toast")).to_have_text("The link is copied")
    assert page.evaluate("navigator.clipboard.readText()") == page.url
    assert link(page)["fov"] == "57.3"
    page.evaluate("Object.defineProperty(navigator, 'clipboard', { value: undefined })")
    page.evaluate("document.execCommand = () => false")
    page.keyboard.press("KeyC")
    expect(page.locator("#toast")).to_have_text("The link is in the address bar")


@pytest.mark.parametrize(
    ("phase", "words"),
    [
        (Phase.MOVING, "The picture is saved as it was in motion, 40 × 20; it gets sharp at rest"),
        (Phase.STILL, "The picture is saved as it is: 3 of 8"),
        (Phase.FINAL, "The picture is saved"),
    ],
)
def test_saves_the_picture_as_it_is(page: Page, stage: Stage, phase: Phase, words: str) -> None:
    colours = np.full((20, 40, 3), (200, 100, 50), np.uint8)
    stage.frame(colours, phase=phase, samples=(3, 8))
    expect(page.locator("#size")).to_have_text("40 × 20")
    with page.expect_download() as downloading:
        page.keyboard.press("KeyX")
    download = downloading.value
    assert download.suggested_filename == "cornell-box-40x20.png"
    picture = np.asarray(Image.open(BytesIO(Path(download.path()).read_bytes())).convert("RGB"))
    assert picture.shape == (20, 40, 3)
    assert np.abs(picture.astype(int) - colours).max() < 8
    expect(page.locator("#toast")).to_have_text(words)


def test_light_or_dark_is_the_systems_choice_or_the_users(page: Page, stage: Stage) -> None:
    def light() -> bool:
        ink = page.locator("#connection-text").evaluate("(words) => getComputedStyle(words).color")
        return sum(int(value) for value in re.findall(r"\d+", str(ink))[:3]) < 300

    page.emulate_media(color_scheme="light")
    assert light()
    page.emulate_media(color_scheme="dark")
    assert not light()
    page.keyboard.press("KeyP")
    page.get_by_label("Light", exact=True).check()
    assert light()
    stage.reload()
    assert light()
    expect(page.get_by_label("Light", exact=True)).to_be_checked()


def test_a_gamepad_moves_turns_and_is_asked_only_while_connected(page: Page, gradients: Running) -> None:
    page.add_init_script(f"({GAMEPAD})()")
    stage = visit(page, gradients)
    page.wait_for_timeout(200)
    assert page.evaluate("window.polls") == 0
    page.evaluate("window.dispatchEvent(new Event('gamepadconnected'))")
    page.evaluate("window.pad.axes = [1, 0, 0, 0]")
    wait_for(page, lambda: x(stage) > 0.05)
    page.evaluate("window.pad.axes = [0, 0, 1, 0]")
    wait_for(page, lambda: stage.all("pose")[-1]["matrix"][8] < -0.05)  # turned to the right
    page.evaluate("window.pad.axes = [0, 0, 0, 0]")
    rest(page, lambda: len(stage.all("pose")))
    page.evaluate("window.pad.buttons[3].pressed = true")
    wait_for(page, lambda: x(stage) == 0)
    page.evaluate("window.pad.buttons[2].pressed = true")
    expect(page.get_by_label("Orbit", exact=True)).to_be_checked()
    page.evaluate("navigator.getGamepads = () => { window.polls += 1; return [null]; }")
    rest(page, lambda: page.evaluate("window.polls"))


SURVEY = {"up": "z", "metres_per_unit": 0.001, "origin": [456_789_000.0, 5_432_100_000.0, 120_000.0]}


def test_links_have_the_coordinates_of_a_survey_and_how_its_file_is_read(page: Page, stage: Stage) -> None:
    options = {"up": "z", "unit": "mm", "storeys": ["ground, east", "first"]}
    stage.scene("hall.glb", frame=SURVEY, options=options)
    wait_for(page, lambda: link(page).get("scene") == "hall.glb")
    place = [float(number) for number in link(page)["at"].split(",")]
    x, y, z = stage.all("pose")[-1]["matrix"][12:15]
    assert np.allclose(place, np.add(SURVEY["origin"], (1000 * x, -1000 * z, 1000 * y)), rtol=0, atol=0.1)
    words = {name: link(page)[name] for name in ("up", "unit", "storeys")}
    assert words == {"up": "z", "unit": "mm", "storeys": "ground%2C%20east,first"}


def test_a_link_goes_to_the_coordinates_of_a_survey(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    words = "scene=hall.glb&at=456790500.5,5432102000,121600&look=0,0&fov=60&unit=mm"
    page.goto(f"{gradients.http.base_url}/#{words}")
    stage.welcome()
    assert stage.hear("hello")["scene_options"] == {"unit": "mm"}
    stage.scene("hall.glb", frame=SURVEY, options={"unit": "mm"})
    assert np.allclose(stage.hear("pose")["matrix"][12:15], (1.5005, 1.6, -2.0), atol=1e-9)


def test_how_a_file_is_read_can_be_chosen(page: Page, stage: Stage) -> None:
    choices = {"variant": ["oak", "beech"], "storey": ["ground", "first"]}
    stage.scene("hall.glb", choices=choices)
    page.keyboard.press("KeyP")
    expect(page.get_by_label("unit of the file")).to_contain_text("automatic: m")
    assert cut_choices(page) == []
    page.get_by_label("variant").select_option("beech")
    wait_for(page, lambda: stage.all("settings")[-1].get("scene_options", {}).get("variant") == "beech")
    assert stage.all("settings")[-1]["scene"] == "hall.glb"
    chosen = stage.all("settings")[-1]["scene_options"]
    stage.scene("hall.glb", choices=choices, options=chosen)
    page.get_by_label("up in the file").select_option("z")
    wait_for(page, lambda: stage.all("settings")[-1].get("scene_options", {}).get("up") == "z")
    assert stage.all("settings")[-1]["scene_options"]["variant"] == "beech"


def test_the_origin_can_be_chosen(page: Page, stage: Stage) -> None:
    stage.scene("hall.glb", frame=SURVEY, options={"unit": "mm"})
    page.keyboard.press("KeyP")
    field = page.get_by_label("origin in the file")
    expect(page.locator("#reading-frame")).to_contain_text(
        "Metres count from 456789000, 5432100000, 120000 in the file"
    )
    for text, origin in (("456000000, 5432000000.5, -1", [456e6, 5432000000.5, -1]), ("auto", "auto"), ("", None)):
        field.fill(text)
        field.press("Enter")
        field.blur()
        wait_for(page, lambda wanted=origin: stage.all("settings")[-1]["scene_options"]["origin"] == wanted)
        chosen = stage.all("settings")[-1]["scene_options"]
        assert chosen["unit"] == "mm"
        stage.scene("hall.glb", frame=SURVEY, options=chosen)
        expect(field).to_have_value(text)
    before = len(stage.all("settings"))
    for text in ("1, 2", "here", "1, 2, inf"):
        field.fill(text)
        field.blur()
        assert "x, y, z" in field.evaluate("field => field.validationMessage")
    assert len(stage.all("settings")) == before


def test_a_built_in_scene_has_no_file_to_read(page: Page, stage: Stage) -> None:
    page.keyboard.press("KeyP")
    expect(page.get_by_label("Method")).to_be_visible()
    expect(page.locator("#reading")).to_be_hidden()
