"""The whole path in a real browser: page, service, worker and renderer, on the CPU."""

import re
from collections.abc import Callable

import pytest
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
    return sum(abs(x - y) for x, y in zip(a, b, strict=True)) / len(a)


def wait_for_picture(page: Page, condition: Callable[[list[float]], bool], problem: str) -> list[float]:
    """The first picture that meets the condition; samples of two pictures can be compared while the size stays."""
    for _ in range(PATIENCE // 250):
        picture: list[float] = page.evaluate(SAMPLE)
        if condition(picture):
            return picture
        page.wait_for_timeout(250)
    raise AssertionError(problem)


@pytest.mark.timeout(600)  # the first start ever compiles the kernels
def test_a_key_press_moves_the_camera_and_a_new_frame_shows(page: Page, real_url: str) -> None:
    page.goto(real_url)
    expect(page.locator("body[data-picture]")).to_be_attached(timeout=PATIENCE)
    expect(page.locator("#notice")).to_be_hidden(timeout=PATIENCE)
    # By itself the page may still be finding the size that this machine can do: hold it, to compare pictures.
    page.locator("#resolution").evaluate("(slider) => { slider.value = 0.2; slider.dispatchEvent(new Event('input')) }")
    expect(page.locator("#size")).to_have_text("256 × 144", timeout=PATIENCE)
    first = wait_for_picture(page, lambda picture: spread(picture) > 10, "the picture is uniform")

    page.locator("#view").focus()
    page.keyboard.down("KeyW")
    expect(page.locator("#fps")).to_have_text(NUMBER, timeout=PATIENCE)
    wait_for_picture(page, lambda picture: difference(first, picture) > 3, "the picture did not change")
    page.keyboard.up("KeyW")
    expect(page.locator("#latency")).to_have_text(NUMBER)
    assert spread(page.evaluate(SAMPLE)) > 10, "the picture is uniform"

    page.keyboard.press("KeyR")
    wait_for_picture(page, lambda picture: difference(first, picture) < 1, "the same view is another picture")
