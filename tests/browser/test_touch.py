"""The page under a finger: larger letters and larger targets."""

from collections.abc import Iterator
from contextlib import closing

import pytest
from harness import Running
from looking import cut_choices
from playwright.sync_api import Browser, Page, expect


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
    assert cut_choices(page) == []


def test_what_only_a_keyboard_does_is_not_told(page: Page, gradients: Running) -> None:
    page.goto(str(gradients.http.base_url))
    expect(page.locator("body[data-picture]")).to_be_attached()
    page.locator("#toggle-mixer").tap()
    hint = page.locator("#pick-hint")
    expect(hint).to_be_visible()
    assert hint.inner_text() == "Click or tap something in the picture; or choose it here."
