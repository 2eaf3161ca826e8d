"""axe-core finds no violations: light and dark, desktop and phone, whatever is open."""

from pathlib import Path

import pytest
from harness import Running
from playwright.sync_api import Page, expect
from staged import Stage

from server.wire.frame_header import Phase

AXE = Path(__file__).with_name("node_modules") / "axe-core" / "axe.min.js"
RUN = """async () => {
    const { violations } = await axe.run(document, { resultTypes: ["violations"] });
    return violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html} ${node.failureSummary}`));
}"""
DESKTOP, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}


def violations(page: Page) -> list[str]:
    page.wait_for_timeout(700)  # colours fade in, and axe would see them halfway
    found: list[str] = page.evaluate(RUN)
    return found


@pytest.mark.parametrize(("size", "scheme"), [(DESKTOP, "light"), (PHONE, "dark")], ids=["desktop-light", "phone-dark"])
def test_no_violations(page: Page, gradients: Running, size: dict[str, int], scheme: str) -> None:
    if not AXE.exists():
        pytest.skip("needs axe-core: npm ci --prefix tests/browser")
    page.emulate_media(color_scheme="light" if scheme == "light" else "dark")
    page.set_viewport_size({"width": size["width"], "height": size["height"]})
    stage = Stage(page)
    page.goto(str(gradients.http.base_url))
    page.evaluate(AXE.read_text(encoding="utf-8"))
    assert violations(page) == [], "loading"
    stage.start()
    stage.frame((128, 128, 128), size=(64, 36), phase=Phase.STILL, samples=(3, 8))
    expect(page.locator("#notice")).to_be_hidden()
    if size is PHONE:
        page.keyboard.press("KeyI")
    assert violations(page) == [], "walking"
    stage.frame((128, 128, 128), stages={f"stage {number}": 1.0 for number in range(40)})
    assert violations(page) == [], "statistics that are scrolled"
    page.keyboard.press("KeyP")
    assert violations(page) == [], "settings"
    page.keyboard.press("KeyG")
    page.get_by_label("Object", exact=True).select_option("chair")
    page.get_by_label("Material", exact=True).select_option("wall")
    assert violations(page) == [], "objects, materials and lights"
    page.keyboard.press("KeyB")
    page.get_by_label("Name of the bookmark").fill("the door")
    page.keyboard.press("Enter")
    page.locator("#film summary").click()
    page.get_by_role("button", name="Add bookmarks").click()
    page.get_by_role("button", name="Add this view").click()
    assert violations(page) == [], "bookmarks and film"
    page.keyboard.press("Escape")
    page.keyboard.press("KeyH")
    expect(page.locator("#help")).to_be_visible()
    assert violations(page) == [], "help"
    page.keyboard.press("Escape")
    stage.say("error", code="limit", message="settings.samples: 9 is more than this server's limit of 8")
    page.keyboard.press("KeyP")
    assert violations(page) == [], "a refused setting"
    stage.away = True
    stage.close(1012)
    expect(page.locator("#notice")).to_contain_text("Reconnecting")
    assert violations(page) == [], "reconnecting"
