"""The whole path in a real browser: page, service, worker and renderer, on the CPU."""

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect

SAMPLE = """() => {
    const view = document.getElementById("view");
    const copy = new OffscreenCanvas(view.width, view.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(view, 0, 0);
    const { data } = copy.getImageData(0, 0, view.width, view.height);
    const grey = [];
    for (let at = 0; at < data.length; at += 4 * 97) grey.push((data[at] + data[at + 1] + data[at + 2]) / 3);
    return grey;
}"""
NUMBER = re.compile(r"^\d+(\.\d)?$")
PATIENCE = 60_000  # ms


def spread(values: list[float]) -> float:
    mean = sum(values) / len(values)
    return float((sum((value - mean) ** 2 for value in values) / len(values)) ** 0.5)


def difference(a: list[float], b: list[float]) -> float:
    """Of two pictures; those of different sizes differ wholly."""
    if len(a) != len(b):
        return 255.0
    return sum(abs(x - y) for x, y in zip(a, b, strict=True)) / len(a)


def wait_for_picture(page: Page, condition: Callable[[list[float]], bool], problem: str) -> list[float]:
    """The first picture that meets the condition."""
    for _ in range(PATIENCE // 250):
        picture: list[float] = page.evaluate(SAMPLE)
        if condition(picture):
            return picture
        page.wait_for_timeout(250)
    raise AssertionError(problem)


def test_a_key_press_moves_the_camera_and_the_picture_gets_sharp(page: Page, real_url: str) -> None:
    page.set_viewport_size({"width": 160, "height": 90})
    page.goto(f"{real_url}/#frames=2")
    expect(page.locator("#phase")).to_have_text("sharp 2/2", timeout=PATIENCE)
    expect(page.locator("#notice")).to_be_hidden()
    expect(page.locator("#size")).to_have_text("160 × 90")
    first = wait_for_picture(page, lambda picture: spread(picture) > 10, "the picture is uniform")

    page.locator("#view").focus()
    page.keyboard.down("KeyW")
    expect(page.locator("#phase")).to_have_text(re.compile("moving"), timeout=PATIENCE)
    expect(page.locator("#fps")).to_have_text(NUMBER, timeout=PATIENCE)
    page.wait_for_timeout(500)  # some way, however soon that was
    page.keyboard.up("KeyW")
    expect(page.locator("#phase")).to_have_text("sharp 2/2", timeout=PATIENCE)
    expect(page.locator("#latency")).to_have_text(NUMBER)
    wait_for_picture(page, lambda picture: difference(first, picture) > 3, "the picture did not change")

    page.keyboard.press("KeyR")
    wait_for_picture(page, lambda picture: difference(first, picture) < 1, "the same view is another picture")
