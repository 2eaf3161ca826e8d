"""The page under a finger: larger letters and larger targets."""

from collections.abc import Iterator
from contextlib import closing

import pytest
from harness import Running
from playwright.sync_api import Browser, Page, expect

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


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """That of a phone."""
    size = {"width": 390, "height": 844}
    with closing(browser.new_context(viewport=size, has_touch=True, is_mobile=True)) as context:
        yield context.new_page()


@pytest.mark.parametrize("sheet", ["panel", "views"])
def test_choices_are_to_be_read_to_their_end(page: Page, gradients: Running, sheet: str) -> None:
    page.goto(str(gradients.http.base_url))
    expect(page.locator("body[data-picture]")).to_be_attached()
    page.locator(f"#toggle-{sheet}").tap()
    page.evaluate("() => document.querySelectorAll('details').forEach((part) => { part.open = true; })")
    expect(page.locator(f"#{sheet} .field select").first).to_be_visible()
    assert page.evaluate(CUT_CHOICES) == []
