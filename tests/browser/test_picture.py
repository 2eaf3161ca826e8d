"""The picture in a real browser: its sizes, phases and order, what is said about it, and what it costs."""

import re

import numpy as np
import pytest
from harness import Running
from looking import pixel, wait_for, walk
from playwright.sync_api import Locator, Page, expect
from staged import Stage, visit

from server.wire.frame_header import Codec, Phase

NO_OFFSCREEN = "delete HTMLCanvasElement.prototype.transferControlToOffscreen"
NO_MODULE_WORKERS = """window.Worker = class extends EventTarget {
    constructor() { super(); setTimeout(() => this.dispatchEvent(new Event("error"))); }
}"""
SHOW = """async (order) => {
    const { openScreen } = await import("/viewer/screen.js");
    const screen = await openScreen(document.createElement("canvas"));
    const picture = new OffscreenCanvas(4, 4);
    picture.getContext("2d");
    const image = await (await picture.convertToBlob()).arrayBuffer();
    const size = { width: 4, height: 4 };
    const show = (frame) => screen.show({ frame, codec: "png", ...size, bytes: new Uint8Array(image.slice(0)) });
    const alone = [];
    for (const frame of order) alone.push((await show(frame)) !== null);
    screen.restart();
    const together = await Promise.all(order.map(show));
    return [alone, together.at(order.indexOf(Math.max(...order))) !== null];
}"""
BREAK = """async () => {
    const { openScreen } = await import("/viewer/screen.js");
    const screen = await openScreen(document.createElement("canvas"));
    const image = { frame: 1, codec: "png", width: 4, height: 4, bytes: new Uint8Array(8) };
    return screen.show(image).then(() => "shown", () => "refused");
}"""
HIDE = """(hidden) => {
    Object.defineProperty(document, "hidden", { configurable: true, value: hidden });
    document.dispatchEvent(new Event("visibilitychange"));
}"""
USUAL = {"lossless": False, "video": None}
GREY, WHITE, RED = (64, 64, 64), (255, 255, 255), (200, 0, 0)


@pytest.fixture(params=["worker", "no OffscreenCanvas", "no module workers"])
def stage(request: pytest.FixtureRequest, page: Page, gradients: Running) -> Stage:
    """A page with its first picture, however this browser can draw it."""
    if request.param != "worker":
        page.add_init_script(NO_OFFSCREEN if "Offscreen" in request.param else NO_MODULE_WORKERS)
    return visit(page, gradients)


@pytest.fixture
def quick_stage(page: Page, gradients: Running) -> Stage:
    """The same, as most browsers draw it."""
    return visit(page, gradients)


def close(colour: tuple[int, int, int], expected: tuple[int, int, int]) -> bool:
    return all(abs(a - b) < 6 for a, b in zip(colour, expected, strict=True))


def test_frames_of_all_sizes_fill_the_window(page: Page, stage: Stage) -> None:
    wait_for(page, lambda: close(pixel(page), GREY))
    box = page.locator("#view").bounding_box()
    edges = np.zeros((720, 1280, 3), np.uint8)
    edges[:, :640] = RED
    edges[:, 640:] = WHITE
    stage.frame(edges, phase=Phase.STILL, samples=(1, 8))
    wait_for(page, lambda: close(pixel(page, 0.49), RED) and close(pixel(page, 0.51), WHITE))
    assert page.locator("#view").bounding_box() == box == {"x": 0, "y": 0, "width": 1280, "height": 720}

    stage.frame(GREY, size=(320, 180))
    wait_for(page, lambda: close(pixel(page, 0.9), GREY))
    assert page.locator("#view").bounding_box() == box


def test_never_draws_an_older_frame_over_a_newer_one(page: Page, stage: Stage) -> None:
    assert page.evaluate(SHOW, [1, 2, 3]) == [[True, True, True], True]
    assert page.evaluate(SHOW, [3, 1, 2]) == [[True, False, False], True]
    stage.frame(WHITE, frame=9)
    wait_for(page, lambda: close(pixel(page), WHITE))
    stage.frame(RED, frame=8)
    page.wait_for_timeout(300)
    assert close(pixel(page), WHITE)


def test_a_broken_image_is_an_error_and_not_the_end(page: Page, stage: Stage) -> None:
    assert page.evaluate(BREAK) == "refused"


def test_a_picture_without_loss_is_shown_without_loss(page: Page, stage: Stage) -> None:
    colours = np.arange(36 * 64 * 3, dtype=np.uint8).reshape(36, 64, 3)
    stage.frame(colours, phase=Phase.FINAL, samples=(8, 8), codec=Codec.PNG)
    expect(page.locator("#codec")).to_have_text("PNG lossless")
    red, green, blue = (int(value) for value in colours[18, 32])
    wait_for(page, lambda: pixel(page) == (red, green, blue))


def test_says_size_phase_samples_and_codec(page: Page, quick_stage: Stage) -> None:
    expect(page.locator("#size")).to_have_text("64 × 36")
    expect(page.locator("#phase")).to_have_text("moving 1/1")
    expect(page.locator("#codec")).to_have_text("JPEG 85")
    quick_stage.frame(GREY, size=(1280, 720), phase=Phase.STILL, samples=(3, 12))
    expect(page.locator("#phase")).to_have_text("sharpening 3/12")
    expect(page.locator("#refinement")).to_have_js_property("value", 0.25)
    page.keyboard.press("KeyI")
    expect(page.locator("#fps")).to_be_hidden()
    quick_stage.frame(GREY, size=(1280, 720), phase=Phase.FINAL, samples=(12, 12))
    expect(page.locator("#phase")).to_have_text("sharp 12/12")
    expect(page.locator("#size")).to_have_text("1280 × 720")
    expect(page.locator("#size")).to_be_visible()


def test_acknowledges_each_frame_with_its_age_and_decoding(page: Page, quick_stage: Stage) -> None:
    first = quick_stage.hear("ack")
    assert 0 < first["decode_ms"] < first["age_ms"] < 60_000
    quick_stage.frame(GREY, phase=Phase.STILL, samples=(1, 2))
    again = quick_stage.hear("ack", 2)
    assert "age_ms" not in again  # the pose was seen before
    assert again["decode_ms"] > 0
    quick_stage.frame(GREY, frame=9)
    assert quick_stage.hear("ack", 3)["frame"] == 9


def test_says_hello_with_its_whole_size_and_what_it_decodes(page: Page, quick_stage: Stage) -> None:
    hello = quick_stage.hear("hello")
    assert hello["codecs"] == ["jpeg", "png", "h264"]
    assert hello["stream"] == {"motion_scale": None, "lossless": False, "video": None}
    assert quick_stage.hear("settings")["size"] == [1280, 720]


def test_the_size_while_moving_can_be_locked(page: Page, quick_stage: Stage) -> None:
    quick_stage.frame(GREY)
    before = len(quick_stage.all("settings"))
    page.keyboard.press("KeyP")
    page.get_by_label("size while moving", exact=True).fill("0.25")
    assert quick_stage.hear("settings", before + 1)["stream"] == {"motion_scale": 0.25, **USUAL}
    expect(page.locator("#motion-text")).to_have_text("25 %")
    quick_stage.frame(GREY)
    page.get_by_label("sharp picture without loss").check()
    assert quick_stage.hear("settings", before + 2)["stream"] == {"motion_scale": 0.25, **USUAL, "lossless": True}
    quick_stage.frame(GREY)
    page.get_by_label("automatic size while moving").check()
    assert quick_stage.hear("settings", before + 3)["stream"] == {"motion_scale": None, **USUAL, "lossless": True}
    expect(page.locator("#motion-text")).to_have_text("by speed")


def test_a_picture_that_takes_long_is_worth_a_sign(page: Page, quick_stage: Stage) -> None:
    quick_stage.frame(GREY)
    busy = page.locator("body[data-busy]")
    expect(busy).not_to_be_attached()
    poses = len(quick_stage.all("pose"))
    walk(page, "KeyW", lambda: len(quick_stage.all("pose")) > poses)
    expect(busy).to_be_attached()
    quick_stage.frame(GREY)
    expect(busy).not_to_be_attached()


def test_settings_that_come_faster_than_answers_are_merged(page: Page, quick_stage: Stage) -> None:
    quick_stage.frame(GREY)
    before = len(quick_stage.all("settings"))
    page.evaluate("""() => {
        const slider = document.getElementById("motion-scale");
        for (let value = 0.125; value <= 1; value += 0.125) {
            slider.value = value;
            slider.dispatchEvent(new Event("input"));
        }
    }""")
    quick_stage.hear("settings", before + 1)
    quick_stage.frame(GREY)
    assert quick_stage.hear("settings", before + 2)["stream"]["motion_scale"] == 1
    quick_stage.frame(GREY)
    page.wait_for_timeout(600)
    assert len(quick_stage.all("settings")) == before + 2


def test_a_quality_is_chosen_beside_what_it_costs(page: Page, quick_stage: Stage) -> None:
    page.keyboard.press("KeyP")
    expect(page.locator("#cost-best")).to_have_text("sharp after 64 frames")
    quick_stage.frame(GREY, phase=Phase.STILL, samples=(1, 16), stages={"shade": 8.0})
    expect(page.locator("#cost-balanced")).to_have_text("8 ms a frame, sharp after 16: 0.13 s")
    expect(page.locator("#cost-best")).to_have_text("sharp after 64 frames: about 0.51 s")
    before = len(quick_stage.all("settings"))
    page.get_by_label("Draft", exact=True).check()
    assert quick_stage.hear("settings", before + 1)["settings"] == {"quality": "draft"}
    page.get_by_label("Component").select_option("direct")
    assert quick_stage.hear("settings", before + 2)["settings"] == {"component": "direct", "quality": "draft"}


def test_a_refused_setting_is_not_said_again_on_the_next_connection(page: Page, quick_stage: Stage) -> None:
    quick_stage.frame(GREY)
    before = len(quick_stage.all("settings"))
    page.keyboard.press("KeyP")
    page.locator("#advanced summary").click()
    page.get_by_label("VPL clusters").fill("60000")
    page.get_by_label("VPL clusters").press("Enter")
    assert quick_stage.hear("settings", before + 1)["settings"] == {"vpl_clusters": 60000}
    quick_stage.say("error", code="limit", message="settings.vpl_clusters: 60000 is too many")
    expect(page.locator("#settings-problem")).to_contain_text("too many")
    quick_stage.close(1012)
    wait_for(page, lambda: quick_stage.connections == 2)
    assert quick_stage.hear("hello").get("settings", {}) == {}


def test_a_hidden_page_costs_the_server_nothing(page: Page, quick_stage: Stage) -> None:
    wait_for(page, lambda: len(quick_stage.all("ack")) == 1)
    page.evaluate(HIDE, True)
    wait_for(page, lambda: quick_stage.closes == [1000])
    page.keyboard.down("KeyW")
    page.wait_for_timeout(1500)
    page.keyboard.up("KeyW")
    assert quick_stage.connections == 1
    page.evaluate(HIDE, False)
    wait_for(page, lambda: quick_stage.connections == 2)
    quick_stage.start()
    expect(page.locator("#connection-text")).to_have_text("Connected")


def test_a_page_opened_in_the_background_waits_until_it_is_seen(page: Page, gradients: Running) -> None:
    page.add_init_script('Object.defineProperty(document, "hidden", { configurable: true, value: true })')
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    page.wait_for_timeout(500)
    assert stage.connections == 0
    page.evaluate(HIDE, False)
    wait_for(page, lambda: stage.connections == 1)


def says(notice: Locator, title: str, detail: str) -> None:
    expect(notice).to_be_visible()
    expect(notice).to_contain_text(title)
    expect(notice).to_contain_text(detail)


def test_says_each_step_of_loading(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    notice = page.locator("#notice")
    says(notice, "Connected", "Waiting for the scene")
    stage.welcome()
    stage.say("status", state="loading", text="reading hall.glb", fraction=0.25)
    says(notice, "Loading", "reading hall.glb")
    expect(page.locator("#notice-progress")).to_have_js_property("value", 0.25)
    stage.scene()
    stage.say("status", state="ready", text="", fraction=0.0)
    says(notice, "Rendering the first picture", "")
    stage.frame(GREY)
    expect(notice).to_be_hidden()
    stage.say("status", state="loading", text="refining", fraction=0.5)
    page.wait_for_timeout(300)
    expect(notice).to_be_hidden()  # the picture is there and gets better by itself
    page.keyboard.press("KeyP")
    page.get_by_label("Method").select_option("path")
    stage.say("status", state="loading", text="compiling", fraction=0.5)
    says(notice, "Working", "compiling")
    stage.say("status", state="recovering", text="starting", fraction=0.0)
    says(notice, "The renderer starts again", "starting")
    stage.say("status", state="stopping", text="", fraction=0.0)
    says(notice, "The server is stopping", "comes back")
    expect(page.locator("#connection-text")).to_have_text("Stopping")
    stage.away = True
    stage.close(1012)
    says(notice, "Reconnecting", "Trying again")


def test_says_that_a_token_is_wanted(page: Page, gradients: Running, complaints: list[str]) -> None:
    page.add_init_script("""window.WebSocket = class extends EventTarget {
        constructor() { super(); setTimeout(() => this.dispatchEvent(new CloseEvent("close", { code: 1006 }))); }
    }""")
    page.route(
        re.compile("/api/v1/scenes"), lambda route: route.fulfill(status=401, json={"code": "x", "message": "x"})
    )
    page.goto(str(gradients.http.base_url))
    says(page.locator("#notice"), "Not connected", "?token=")
    complaints.clear()  # the browser notes the status by itself
