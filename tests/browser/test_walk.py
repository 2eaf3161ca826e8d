"""The whole path in a real browser: page, service, worker and renderer, on the CPU."""

import re

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
SECONDS = 60_000


def spread(values: list[float]) -> float:
    mean = sum(values) / len(values)
    return float((sum((value - mean) ** 2 for value in values) / len(values)) ** 0.5)


def difference(a: list[float], b: list[float]) -> float:
    return sum(abs(x - y) for x, y in zip(a, b, strict=True)) / len(a)


def test_a_key_press_moves_the_camera_and_a_new_frame_shows(page: Page, real_url: str) -> None:
    page.goto(real_url)
    expect(page.locator("body[data-picture]")).to_be_attached(timeout=SECONDS)
    expect(page.locator("#notice")).to_be_hidden(timeout=SECONDS)
    # The size may still be finding what this machine can do: hold it, so that pictures can be compared.
    page.locator("#resolution").evaluate("(slider) => { slider.value = 0.2; slider.dispatchEvent(new Event('input')) }")
    expect(page.locator("#size")).to_have_text("256 × 144", timeout=SECONDS)
    first = page.evaluate(SAMPLE)
    assert spread(first) > 10, "the picture is uniform"

    page.locator("#view").focus()
    page.keyboard.down("KeyW")
    expect(page.locator("#fps")).to_have_text(re.compile(r"^\d+(\.\d)?$"), timeout=SECONDS)
    page.wait_for_timeout(1000)
    page.keyboard.up("KeyW")
    expect(page.locator("#fps")).to_have_text("still", timeout=SECONDS)
    moved = page.evaluate(SAMPLE)
    assert spread(moved) > 10, "the picture is uniform"
    assert difference(first, moved) > 3, "the picture did not change"
    expect(page.locator("#latency")).to_have_text(re.compile(r"^\d+(\.\d)?$"))

    page.keyboard.press("KeyR")
    page.wait_for_timeout(500)
    expect(page.locator("#fps")).to_have_text("still", timeout=SECONDS)
    assert difference(first, page.evaluate(SAMPLE)) < 1, "the same view and seed give another picture"
