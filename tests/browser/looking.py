"""What tests do with a page: look at its picture, hold keys, wait."""

from collections.abc import Callable, Mapping
from itertools import combinations

from playwright.sync_api import Page

PIXEL = """([x, y]) => {
    const view = document.getElementById("view");
    const copy = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    copy.drawImage(view, -Math.floor(x * view.width), -Math.floor(y * view.height));
    return [...copy.getImageData(0, 0, 1, 1).data.slice(0, 3)];
}"""
CUT_CHOICES = """() => {
    const pen = document.createElement("canvas").getContext("2d");
    return [...document.querySelectorAll(".field select:not([multiple])")].filter((select) => select.clientWidth)
        .flatMap((select) => {
            const style = getComputedStyle(select);
            pen.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
            const room = select.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
            const cut = (text) => pen.measureText(text).width > room;
            return [...select.options].map((option) => option.text).filter(cut);
        });
}"""


def pixel(page: Page, x: float = 0.5, y: float = 0.5) -> tuple[int, int, int]:
    """The colour of the picture at a share of its width and height."""
    red, green, blue = page.evaluate(PIXEL, [x, y])
    return red, green, blue


def wait_for(page: Page, condition: Callable[[], bool]) -> None:
    for _ in range(600):
        if condition():
            return
        page.wait_for_timeout(50)
    raise AssertionError("did not happen within 30 s")


def rest(page: Page, count: Callable[[], object]) -> None:
    """Waits until this stays the same for a while, as what motion changes does when that has eased out."""
    for _ in range(50):
        before = count()
        page.wait_for_timeout(300)
        if count() == before:
            return
    raise AssertionError("did not come to rest")


def hold(page: Page, key: str) -> None:
    """A key that is not to move anything, for as long as it would."""
    page.keyboard.down(key)
    page.wait_for_timeout(300)
    page.keyboard.up(key)
    page.wait_for_timeout(300)


def walk(page: Page, key: str, condition: Callable[[], bool]) -> None:
    """Holds a key until this is so: how far that is depends on how many frames a busy machine draws."""
    page.keyboard.down(key)
    wait_for(page, condition)
    page.keyboard.up(key)


Edges = tuple[float, float, float, float]
"""Left, top, right and bottom of an element, in pixels of the window."""


def edges_of(page: Page, name: str) -> Edges:
    """Where the element with that id is."""
    box = page.locator(f"#{name}").bounding_box()
    assert box is not None
    return box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]


def overlapping(edges: Mapping[str, Edges]) -> list[tuple[str, str]]:
    """Which elements lie over each other."""
    pairs = combinations(edges.items(), 2)
    return [
        (one, other) for (one, a), (other, b) in pairs if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    ]


def cut_choices(page: Page) -> list[str]:
    """The choices of visible fields whose ends are cut off."""
    cut: list[str] = page.evaluate(CUT_CHOICES)
    return cut
