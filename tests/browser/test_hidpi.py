"""Screens with more device pixels than CSS pixels: frames have all of them, as far as the server makes so many."""

import io
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from harness import Running
from looking import wait_for
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser, Page, expect
from staged import Stage

from server.wire.frame_header import Codec, Phase

NOTE_QUERIES = """() => {
    const match = window.matchMedia.bind(window);
    window.queries = [];
    window.matchMedia = (words) => {
        const query = match(words);
        if (words.includes("resolution")) window.queries.push(query);
        return query;
    };
}"""
WIDTH, HEIGHT = 401, 301  # of the window in CSS pixels; odd, as windows are


@pytest.fixture
def ratio() -> float:
    """Device pixels a CSS pixel, unless a test has its own."""
    return 2.0


@pytest.fixture
def page(browser: Browser, ratio: float) -> Iterator[Page]:
    viewport = {"width": WIDTH, "height": HEIGHT}
    # bypass_csp: what lies over the picture is to be hidden for a look at it
    with closing(browser.new_context(viewport=viewport, device_scale_factor=ratio, bypass_csp=True)) as context:
        yield context.new_page()


def start(page: Page, service: Running, max_pixels: int = 3840 * 2160) -> Stage:
    stage = Stage(page)
    page.goto(str(service.http.base_url))
    stage.welcome(max_pixels)
    stage.scene()
    stage.say("status", state="ready", text="", fraction=0.0)
    stage.hear("pose")
    stage.frame((64, 64, 64))
    expect(page.locator("body[data-picture]")).to_be_attached()
    return stage


def checks(width: int, height: int) -> NDArray[np.uint8]:
    """A chessboard of single pixels, which any stretching blurs, dark at the left and light at the right."""
    board = (np.indices((height, width)).sum(axis=0) % 2)[..., None] * np.array([120, 60, 30])
    board[:, width // 2 :] += 100
    return board.astype(np.uint8)


def shot(page: Page) -> NDArray[np.uint8]:
    """The window in device pixels, without what lies over the picture."""
    page.add_style_tag(content="body > :not(main) { display: none !important } #view { transition: none !important }")
    return np.asarray(Image.open(io.BytesIO(page.screenshot(scale="device"))).convert("RGB"))


@pytest.mark.parametrize("ratio", [1.25, 2.0, 3.0])
def test_a_frame_is_asked_for_and_shown_pixel_by_pixel(page: Page, gradients: Running, ratio: float) -> None:
    stage = start(page, gradients)
    size = [round(WIDTH * ratio), round(HEIGHT * ratio)]
    assert stage.hear("settings")["size"] == size
    picture = checks(size[0], size[1])
    stage.frame(picture, phase=Phase.FINAL, samples=(8, 8), codec=Codec.PNG)
    expect(page.locator("#size")).to_have_text(f"{size[0]} × {size[1]}")
    expect(page.locator("#size-limit")).to_be_hidden()
    assert np.array_equal(shot(page), picture)


def test_the_limit_of_the_server_is_said(page: Page, gradients: Running) -> None:
    window = 2 * WIDTH, 2 * HEIGHT
    stage = start(page, gradients, max_pixels=window[0] * window[1] // 4)
    width, height = stage.hear("settings")["size"]
    assert abs(width - window[0] / 2) <= 1
    assert abs(height - window[1] / 2) <= 1
    words = f"{width} × {height} of {window[0]} × {window[1]} device pixels"
    expect(page.locator("#size-limit")).to_have_text(words)
    expect(page.locator("#size-limit")).to_be_visible()
    halves = checks(width, height)
    stage.frame(halves, phase=Phase.FINAL, samples=(8, 8), codec=Codec.PNG)
    expect(page.locator("#size")).to_have_text(f"{width} × {height}")
    shown = shot(page).mean(axis=(0, 2))
    middle = window[0] // 2
    assert shown[middle + 6] - shown[middle - 6] > 80.0  # stretched, and where it belongs


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_a_drag_turns_by_css_pixels(page: Page, gradients: Running) -> None:
    stage = start(page, gradients)
    page.mouse.move(200, 150)
    page.mouse.down()
    page.mouse.move(300, 150, steps=4)
    page.mouse.up()
    turned = np.sin(100 * 0.0025)  # web/viewer/fly.js: radians a CSS pixel
    wait_for(page, lambda: abs(abs(stage.all("pose")[-1]["matrix"][8]) - turned) < 1e-4)


def test_zoom_and_another_screen_ask_for_other_frames(page: Page, gradients: Running) -> None:
    page.add_init_script(f"({NOTE_QUERIES})()")
    stage = start(page, gradients)
    session = page.context.new_cdp_session(page)

    def becomes(width: int, height: int, scale: float, event: str = "") -> None:
        metrics = {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": False}
        session.send("Emulation.setDeviceMetricsOverride", metrics)
        stage.frame((64, 64, 64))
        page.evaluate(event)
        wait_for(page, lambda: stage.all("settings")[-1]["size"] == [round(width * scale), round(height * scale)])

    becomes(WIDTH // 2, HEIGHT // 2, 5.0)  # zoomed in
    # The same window on another screen; an emulated one does not say so by itself.
    becomes(WIDTH // 2, HEIGHT // 2, 3.0, "queries.at(-1).dispatchEvent(new Event('change'))")
    becomes(WIDTH // 2, HEIGHT // 2, 1.0, "queries.at(-1).dispatchEvent(new Event('change'))")
