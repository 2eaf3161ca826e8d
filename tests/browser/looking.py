"""What tests do with a page: look at its picture, hold keys, wait."""

from collections.abc import Callable

from playwright.sync_api import Page

PIXEL = """([x, y]) => {
    const view = document.getElementById("view");
    const copy = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    copy.drawImage(view, -Math.floor(x * view.width), -Math.floor(y * view.height));
    return [...copy.getImageData(0, 0, 1, 1).data.slice(0, 3)];
}"""


def pixel(page: Page, x: float = 0.5, y: float = 0.5) -> tuple[int, int, int]:
    """The colour of the picture at a share of its width and height."""
    red, green, blue = page.evaluate(PIXEL, [x, y])
    return red, green, blue


def wait_for(page: Page, condition: Callable[[], bool]) -> None:
    for _ in range(200):
        if condition():
            return
        page.wait_for_timeout(50)
    raise AssertionError("did not happen within 10 s")


def hold(page: Page, key: str, milliseconds: int = 300) -> None:
    page.keyboard.down(key)
    page.wait_for_timeout(milliseconds)
    page.keyboard.up(key)
    page.wait_for_timeout(300)  # the motion eases out
