"""Scene files brought to the page: by the button, dropped, refused, cancelled."""

import re
import zipfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import pytest
from harness import Running
from looking import wait_for
from playwright.sync_api import FilePayload, Page, Request, Route, expect
from staged import SCENES, Stage, visit

HALL: FilePayload = {"name": "hall.glb", "mimeType": "model/gltf-binary", "buffer": b"glTF" + bytes(1000)}
DROP = """(files) => {
    const data = new DataTransfer();
    for (const name of files) data.items.add(new File(["content"], name));
    for (const type of ["dragover", "drop"]) {
        window.dispatchEvent(new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true }));
    }
}"""
Answer = Callable[[Route], None]


@pytest.fixture
def stage(page: Page, gradients: Running) -> Stage:
    """A page with its first picture."""
    return visit(page, gradients)


def answers(page: Page, answer: Answer) -> list[str]:
    """Has the server take uploads so; returns the addresses that they went to, as they come."""
    asked: list[str] = []

    def take(route: Route) -> None:
        if route.request.method == "GET":
            route.fulfill(json=[*SCENES, {"id": "new/1", "name": "hall", "builtin": False, "served": False}])
            return
        asked.append(route.request.url)
        answer(route)

    page.route(re.compile("/api/v1/scenes"), take)
    return asked


def test_a_chosen_file_is_sent_and_entered(page: Page, stage: Stage) -> None:
    asked = answers(page, lambda route: route.fulfill(status=201, json={"id": "new/1", "name": "hall"}))
    with page.expect_file_chooser() as choosing:
        page.get_by_role("button", name="Open a scene file").click()
    choosing.value.set_files(HALL)
    wait_for(page, lambda: stage.all("settings")[-1].get("scene") == "new/1")
    assert [url.split("?")[1] for url in asked] == ["name=hall.glb"]
    expect(page.locator("#scene")).to_have_value("new/1")
    expect(page.locator("#upload")).to_be_hidden()


def test_a_scene_that_another_page_has_sent_since_can_be_seen_in_the_list(page: Page, stage: Stage) -> None:
    answers(page, lambda route: route.abort())
    stage.scene("new/1")
    expect(page.locator("#scene")).to_have_value("new/1")
    labels = page.locator("#scene option").all_text_contents()
    assert labels == ["cornell-box", "hall – hall.glb", "hall – new/1"]  # two are called alike


@pytest.mark.parametrize("way", ["hover", "focus"])
def test_who_comes_to_choose_a_scene_sees_those_that_others_brought(page: Page, stage: Stage, way: str) -> None:
    answers(page, lambda route: route.abort())
    choices = page.locator("#scene option")
    assert "new/1" not in choices.evaluate_all("all => all.map(({ value }) => value)")
    getattr(page.locator("#scene"), way)()
    expect(choices.last).to_have_attribute("value", "new/1")
    expect(page.locator("#scene")).to_have_value("cornell-box")


def test_a_dropped_file_is_sent(page: Page, stage: Stage) -> None:
    asked = answers(page, lambda route: route.fulfill(status=201, json={"id": "new/1"}))
    page.evaluate(DROP, ["große halle.glb"])
    wait_for(page, lambda: len(asked) == 1)
    assert "name=gro%C3%9Fe+halle.glb" in asked[0]
    expect(page.locator("#drop")).to_be_hidden()


def archive(request: Request) -> dict[str, bytes]:
    """What was sent, by its names."""
    with zipfile.ZipFile(BytesIO(request.post_data_buffer or b"")) as sent:
        assert sent.testzip() is None
        return {entry.filename: sent.read(entry) for entry in sent.infolist()}


def test_several_files_are_sent_as_an_archive(page: Page, stage: Stage) -> None:
    sent: list[Request] = []
    answers(page, lambda route: (sent.append(route.request), route.fulfill(status=201, json={"id": "new/1"}))[1])
    page.evaluate(DROP, ["holz.png", "große halle.gltf", "halle.bin"])
    wait_for(page, lambda: len(sent) == 1)
    assert sent[0].url.split("?")[1] == "name=gro%C3%9Fe+halle.zip"
    assert archive(sent[0]) == dict.fromkeys(("holz.png", "große halle.gltf", "halle.bin"), b"content")
    expect(page.locator("#upload")).to_be_hidden()


def test_a_folder_is_sent_as_an_archive(page: Page, stage: Stage, tmp_path: Path) -> None:
    sent: list[Request] = []
    answers(page, lambda route: (sent.append(route.request), route.fulfill(status=201, json={"id": "new/1"}))[1])
    maps = tmp_path / "house" / "maps"
    maps.mkdir(parents=True)
    (maps.parent / "scene.obj").write_bytes(b"f 1 2 3")
    for number in range(120):  # more than a browser gives at once
        (maps / f"{number}.png").write_bytes(bytes([number]) * 70_000)
    browser = page.context.new_cdp_session(page)
    data = {"items": [], "files": [str(maps.parent)], "dragOperationsMask": 1}
    for event in ("dragEnter", "dragOver", "drop"):
        browser.send("Input.dispatchDragEvent", {"type": event, "x": 300, "y": 300, "data": data})
    wait_for(page, lambda: len(sent) == 1)
    assert sent[0].url.split("?")[1] == "name=house.zip"
    files = archive(sent[0])
    assert files.pop("house/scene.obj") == b"f 1 2 3"
    assert files == {f"house/maps/{number}.png": bytes([number]) * 70_000 for number in range(120)}


def test_too_many_files_are_told(page: Page, stage: Stage) -> None:
    asked = answers(page, lambda route: route.abort())
    page.evaluate(DROP, [f"{number}.png" for number in range(2001)])
    expect(page.locator("#toast")).to_contain_text("More than 2000 files")
    assert asked == []


@pytest.mark.parametrize(
    ("status", "body", "words"),
    [
        (422, {"code": "scene-failed", "message": "hall.glb: accessors[0]: is cut off"}, "accessors[0]: is cut off"),
        (500, None, "status 500"),
    ],
)
def test_says_why_a_file_was_not_taken(
    page: Page, stage: Stage, complaints: list[str], status: int, body: dict[str, str] | None, words: str
) -> None:
    answers(page, lambda route: route.fulfill(status=status, json=body))
    page.locator("#file").set_input_files(HALL)
    expect(page.locator("#toast")).to_contain_text(words)
    expect(page.locator("#upload")).to_be_hidden()
    assert "scene" not in stage.all("settings")[-1]
    complaints.clear()  # the browser notes the status by itself


def test_a_server_takes_what_the_page_sends(page: Page, gradients: Running) -> None:
    page.goto(str(gradients.http.base_url))
    expect(page.locator("body[data-picture]")).to_be_attached()
    page.locator("#file").set_input_files(HALL | {"name": "kitchen.glb"})
    expect(page).to_have_title(re.compile("kitchen.* – lumenwalk"), timeout=30_000)
    expect(page.locator("#scene option:checked")).to_have_text("kitchen")
    expect(page.locator("#phase")).to_contain_text("sharp")


def test_an_upload_can_be_cancelled_and_another_waits_for_it(page: Page, stage: Stage) -> None:
    answers(page, lambda _: None)  # never answered
    page.locator("#file").set_input_files(HALL)
    expect(page.locator("#upload-text")).to_contain_text("hall.glb")
    page.evaluate(DROP, ["b.glb"])
    expect(page.locator("#toast")).to_contain_text("Another file")
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator("#upload")).to_be_hidden()
