"""The page in a real browser, with gradients for pictures: what it sends, shows and says."""

import os
import re
import signal
from pathlib import Path

import pytest
import staged
from harness import Running, run
from looking import edges_of, hold, overlapping, pixel, rest, wait_for, walk
from playwright.sync_api import Page, expect
from staged import Stage

from server.settings import ServerSettings

PATIENCE = 30_000  # ms: a process starts to check a scene's file
NUMBER = re.compile(r"^\d+(\.\d)?$")
NOTE_WORDS = """() => {
    const connection = document.getElementById("connection-text");
    window.words = [];
    new MutationObserver(() => window.words.push(connection.textContent)).observe(connection, { childList: true });
}"""
RENDER_FAILS_SEED = "1002"  # a lever of the gradient worker


def visit(page: Page, service: Running) -> None:
    page.goto(str(service.http.base_url))
    expect(page.locator("body[data-picture]")).to_be_attached()
    expect(page.locator("#notice")).to_be_hidden()


def test_shows_the_scene_and_its_name(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    left, right = pixel(page, 0.1), pixel(page, 0.9)
    assert left[0] < 60 < 200 < right[0]
    assert page.title() == "cornell-box – lumenwalk"
    expect(page.locator("#scene")).to_have_value("cornell-box")
    expect(page.locator("#connection-text")).to_have_text("Connected")
    expect(page.locator("#method")).to_have_text("fuzzy-vpl")


def test_fits_the_frames_to_the_window_and_the_servers_limit(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    expect(page.locator("#size")).to_have_text("640 × 360")
    page.set_viewport_size({"width": 500, "height": 250})
    expect(page.locator("#size")).to_have_text("500 × 250")


def test_the_overlay_has_figures(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.keyboard.down("KeyW")
    expect(page.locator("#fps")).to_have_text(NUMBER)
    expect(page.locator("#latency")).to_have_text(NUMBER)
    page.keyboard.up("KeyW")
    stages = {row.split("\n")[0]: row.split("\n")[-1] for row in page.locator(".stage").all_inner_texts()}
    assert {"gbuffer", "shade", "extra"} <= stages.keys()
    assert stages["shade"] == "1.5"
    parts = page.locator("#parts div").all_inner_texts()
    assert [part.split()[0] for part in parts] == ["queue", "render", "encode", "network", "decode"]
    assert all(NUMBER.match(part.split()[1]) for part in parts)
    expect(page.locator("#fps")).to_have_text("still")
    expect(page.locator("#phase")).to_have_text("sharp 4/4")


def test_moves_right_and_back_with_key_codes(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    start = pixel(page)[1]
    walk(page, "KeyD", lambda: pixel(page)[1] > start + 20)
    page.keyboard.press("KeyR")
    wait_for(page, lambda: abs(pixel(page)[1] - start) < 3)  # but for the coding of another size


def test_ctrl_is_no_movement(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    start = pixel(page)
    page.keyboard.down("Control")
    hold(page, "KeyD")
    page.keyboard.up("Control")
    assert abs(pixel(page)[1] - start[1]) < 3


def test_a_key_let_go_while_a_mac_keeps_it_to_itself_is_let_go(page: Page, gradients: Running) -> None:
    stage = staged.visit(page, gradients)
    walk_on = len(stage.all("pose")) + 3
    page.keyboard.down("KeyD")
    wait_for(page, lambda: len(stage.all("pose")) > walk_on)
    page.keyboard.down("Meta")
    page.keyboard.up("Meta")  # no event says that KeyD was let go meanwhile
    rest(page, lambda: len(stage.all("pose")))


def test_keys_typed_into_a_setting_do_not_move(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    start = pixel(page)
    page.keyboard.press("KeyP")
    page.locator("#advanced summary").click()
    page.locator("#setting-seed").focus()
    hold(page, "KeyD")
    assert abs(pixel(page)[1] - start[1]) < 3


def test_orbits_about_the_middle_of_the_scene(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.get_by_label("Orbit").check()
    page.mouse.move(640, 360)
    page.mouse.down()
    page.mouse.move(540, 360, steps=4)
    page.mouse.up()
    # The scene turns with the pointer, to the left: the camera goes to the right.
    wait_for(page, lambda: pixel(page)[1] > 20)


def test_sends_nothing_while_nothing_moves(page: Page, gradients: Running) -> None:
    sent: list[str | bytes] = []
    page.on("websocket", lambda socket: socket.on("framesent", lambda message: sent.append(message)))
    visit(page, gradients)
    rest(page, lambda: len(sent))
    before = len(sent)
    walk(page, "KeyA", lambda: len(sent) > before)


def test_says_why_a_scene_cannot_be_had_and_goes_on(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.locator("#scene").select_option("broken.glb")
    expect(page.locator("#toast")).to_contain_text("accessors[0]: is cut off", timeout=PATIENCE)
    expect(page.locator("#scene")).to_have_value("cornell-box")
    walk(page, "KeyD", lambda: pixel(page)[1] > 20)
    expect(page.locator("#notice")).to_be_hidden()


def test_changes_the_scene(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.locator("#scene").select_option("hall.glb")
    expect(page).to_have_title("hall.glb – lumenwalk", timeout=PATIENCE)
    expect(page.locator("#notice")).to_be_hidden()
    expect(page.locator("body")).not_to_have_attribute("data-busy", "")


def test_settings_come_from_the_schema_and_reach_the_renderer(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.get_by_role("button", name="Settings", exact=True).click()
    expect(page.get_by_label("VPL clusters")).to_be_hidden()
    page.locator("#advanced summary").click()
    expect(page.get_by_label("VPL clusters")).to_have_attribute("placeholder", "auto")
    page.get_by_label("Method").select_option("path")
    expect(page.locator("#method")).to_have_text("path")
    page.get_by_label("Seed").fill(RENDER_FAILS_SEED)
    page.get_by_label("Seed").press("Enter")
    expect(page.locator("#notice")).to_contain_text("settings.seed: is the wrong one")
    page.get_by_role("button", name="Back to defaults").click()
    expect(page.locator("#notice")).to_be_hidden()
    expect(page.locator("#method")).to_have_text("fuzzy-vpl")


def test_says_which_setting_the_server_refused(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.keyboard.press("KeyP")
    page.locator("#advanced summary").click()
    page.get_by_label("VPL clusters").fill("60000")
    page.get_by_label("VPL clusters").press("Enter")
    expect(page.locator("#settings-problem")).to_contain_text("settings.vpl_clusters")
    expect(page.locator("body")).not_to_have_attribute("data-busy", "")


def test_takes_no_value_that_a_setting_must_be_more_than(page: Page, gradients: Running) -> None:
    stage = staged.visit(page, gradients)
    page.keyboard.press("KeyP")
    field = page.get_by_label("exposure", exact=True)
    for typed, problem in (("0", "Value must be greater than 0."), ("2", "")):
        field.fill(typed)
        field.press("Enter")
        assert field.evaluate("field => field.validationMessage") == problem
    assert [it["settings"]["exposure"] for it in stage.all("settings") if it.get("settings")] == [2]


def test_comes_back_after_the_server_was_gone(page: Page, complaints: list[str]) -> None:
    with run(ServerSettings(port=0)) as first:
        first.wait_ready()
        port = first.http.base_url.port
        assert port is not None
        visit(page, first)
        walk(page, "KeyD", lambda: pixel(page)[1] > 20)
        rest(page, lambda: pixel(page))
        expect(page.locator("#fps")).to_have_text("still")
    expect(page.locator("#notice")).to_contain_text("Trying again")
    expect(page.locator("#connection-text")).to_have_text("Reconnecting")
    moved = pixel(page)[1]
    assert moved > 20
    with run(ServerSettings(port=port)) as second:
        second.wait_ready()
        expect(page.locator("#notice")).to_be_hidden(timeout=PATIENCE)
        expect(page.locator("#connection-text")).to_have_text("Connected")
        walk(page, "KeyW", lambda: page.locator("#fps").inner_text() != "still")
        assert abs(pixel(page)[1] - moved) < 3  # it stands where it stood
    complaints.clear()  # the browser notes each failed attempt by itself


def test_walks_on_after_the_renderer_died(page: Page) -> None:
    with run(ServerSettings(port=0)) as service:
        service.wait_ready()
        visit(page, service)
        worker = service.service.engines.engines[0].worker_pid
        assert worker is not None
        page.evaluate(NOTE_WORDS)
        os.kill(worker, signal.SIGKILL)
        wait_for(page, lambda: "Recovering" in page.evaluate("window.words"))
        expect(page.locator("#connection-text")).to_have_text("Connected")
        expect(page.locator("#notice")).to_be_hidden()
        walk(page, "KeyD", lambda: pixel(page)[1] > 20)


def test_stays_away_when_refused(page: Page, tmp_path: Path) -> None:
    page.route_web_socket(re.compile("stream"), lambda socket: socket.close(code=1008, reason="no entry"))
    with run(ServerSettings(port=0)) as service:
        page.goto(str(service.http.base_url))
        expect(page.locator("#notice")).to_contain_text("no entry")
        expect(page.get_by_role("button", name="Try again now")).to_be_visible()


def test_pictures_that_are_still_decoded_do_not_hide_that_the_connection_is_gone(
    page: Page, gradients: Running
) -> None:
    stage = staged.visit(page, gradients)
    for _ in range(10):
        stage.frame((9, 9, 9), size=(1280, 720))
    stage.close(1009, "too large")
    expect(page.locator("#size")).to_have_text("1280 × 720")
    page.wait_for_timeout(500)  # until all are decoded
    expect(page.locator("#notice")).to_contain_text("too large")
    expect(page.locator("#connection-text")).to_have_text("Refused")


def test_says_to_reload_where_the_server_understands_other_words(page: Page, gradients: Running) -> None:
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.hear("hello")
    stage.say("error", code="bad-message", message="settings.vpls: Extra inputs are not permitted")
    stage.close(1002, "the hello was refused")
    expect(page.locator("#notice-detail")).to_contain_text("Reload the page")


def test_connects_anew_when_the_network_is_back(page: Page, gradients: Running) -> None:
    stage = staged.visit(page, gradients)
    first = stage.hear("hello")
    page.context.set_offline(True)
    page.context.set_offline(False)
    wait_for(page, lambda: stage.connections == 2)
    assert stage.hear("hello")["size"] == first["size"]  # which a server takes that makes smaller ones now
    stage.start()
    expect(page.locator("#connection-text")).to_have_text("Connected")
    expect(page.locator("#notice")).to_be_hidden()
    assert stage.connections == 2


def test_everything_is_reached_by_keyboard_and_has_a_name(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    page.keyboard.press("KeyP")
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("button, select, input, #view")]
            .filter((control) => !control.labels?.length && !control.ariaLabel && !control.textContent.trim())
            .map((control) => control.outerHTML)"""
    )
    assert nameless == []
    reached = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("() => document.activeElement.id || document.activeElement.name"))
    assert {"view", "scene", "mode", "home", "toggle-panel", "toggle-help", "setting-method", "defaults"} <= reached


@pytest.mark.parametrize("width", [390, 320])
def test_fits_a_phone(page: Page, gradients: Running, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 844})
    visit(page, gradients)
    boxes = {name: page.locator(f"#{name}").bounding_box() for name in ("title-bar", "tools", "stats", "move-bar")}
    for name, box in boxes.items():
        assert box is not None, name
        assert box["x"] >= 0, name
        assert box["x"] + box["width"] <= width, name
        assert box["y"] + box["height"] <= 844, name
    title, tools = boxes["title-bar"], boxes["tools"]
    assert title is not None
    assert tools is not None
    assert title["x"] + title["width"] <= tools["x"]
    chosen = page.locator("#scene").bounding_box()
    assert chosen is not None
    assert chosen["width"] > 60  # of which the arrow takes 30


@pytest.mark.parametrize("size", [(1280, 720), (1000, 600), (900, 560)])
def test_what_takes_a_while_is_told_beside_statistics_and_sheets(
    page: Page, gradients: Running, size: tuple[int, int]
) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    stage.start()
    expect(page.locator("body[data-picture]")).to_be_attached()
    stage.say("status", state="recovering", text="compiling kernels, which the first time takes a minute")
    expect(page.locator("#notice")).to_be_visible()
    names = ["notice", "stats", "tools", "title-bar", "move-bar"]
    assert overlapping({name: edges_of(page, name) for name in names}) == []
    page.keyboard.press("KeyG")
    assert overlapping({name: edges_of(page, name) for name in [*names, "mixer"]}) == []


@pytest.mark.parametrize("width", [1100, 1280])
def test_statistics_that_are_taller_than_the_window_are_scrolled(page: Page, gradients: Running, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 700})
    stage = staged.visit(page, gradients)
    stage.frame((64, 64, 64), stages={f"stage {number}": 1.0 for number in range(40)})
    expect(page.locator("#stages")).to_contain_text("stage 39")
    statistics, bar = page.locator("#stats").bounding_box(), page.locator("#move-bar").bounding_box()
    assert statistics is not None
    assert bar is not None
    beside = statistics["x"] + statistics["width"] < bar["x"]
    assert statistics["y"] + statistics["height"] <= (700 if beside else bar["y"])
    page.locator("#stats").hover()
    page.mouse.wheel(0, 5000)
    expect(page.get_by_text("stage 39")).to_be_in_viewport()


def test_a_link_whose_settings_are_refused_leaves_the_viewer_in_the_scene_before(
    page: Page, gradients: Running
) -> None:
    stage = staged.visit(page, gradients)
    page.evaluate("location.hash = 'scene=hall.glb&vpls=65536'")
    wait_for(page, lambda: stage.all("settings")[-1].get("scene") == "hall.glb")
    stage.say("error", code="limit", message="settings.vpls: too many")
    expect(page.locator("#toast")).to_have_text("settings.vpls: too many")
    expect(page.locator("#scene")).to_have_value("cornell-box")
    expect(page.locator("#notice")).to_be_hidden()
    poses = len(stage.all("pose"))
    walk(page, "KeyD", lambda: len(stage.all("pose")) > poses)


def test_waits_for_nothing_after_a_refusal(page: Page, gradients: Running) -> None:
    visit(page, gradients)
    expect(page.locator("#phase")).to_have_text("sharp 4/4")
    page.evaluate("location.hash = 'scene=nowhere'")
    expect(page.locator("#toast")).to_contain_text("nowhere")
    page.wait_for_timeout(1000)  # a picture that is owed is late by then
    assert page.locator("body[data-busy]").count() == 0


def test_a_scene_of_the_connection_before_is_not_gone_back_to(page: Page, gradients: Running) -> None:
    stage = staged.visit(page, gradients)
    page.locator("#scene").select_option("hall.glb")
    stage.hear("settings", 2)
    stage.scene("hall.glb")
    stage.hear("pose", 2)
    stage.close(1012)
    wait_for(page, lambda: stage.connections == 2)
    stage.welcome()
    stage.say("error", code="scene-failed", message="hall.glb is gone")
    expect(page.locator("#notice")).to_contain_text("hall.glb is gone")
    assert stage.all("pose") == []
