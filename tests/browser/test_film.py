"""Films: views in order, their preview, paths as files, and what the server makes of them."""

import io
import json
from pathlib import Path

import pytest
from harness import Running
from looking import rest, wait_for, walk
from playwright.sync_api import Page, expect
from staged import Stage, visit

# As if the page had been closed before its film was ready.
CLOSED_BEFORE = """() => {
    const ordered = JSON.parse(localStorage.getItem("lumenwalk film ordered"));
    localStorage.setItem("lumenwalk film ordered", JSON.stringify({ ...ordered, told: false }));
}"""


@pytest.fixture
def stage(page: Page, gradients: Running) -> Stage:
    """A page whose film has two views, a second and some way of x apart."""
    stage = visit(page, gradients)
    page.keyboard.press("KeyB")
    page.locator("#film summary").click()
    page.get_by_role("button", name="Add this view").click()
    page.locator("#view").focus()
    walk(page, "KeyD", lambda: x(stage) > 0.05)
    rest(page, lambda: x(stage))
    page.get_by_role("button", name="Add this view").click()
    set_seconds(page, "1")
    expect(page.locator("#film-time")).to_have_text("1 s")
    return stage


def set_seconds(page: Page, words: str) -> None:
    """How long the way to the second view takes."""
    seconds = page.get_by_label("Seconds from the view before to View 2")
    seconds.fill(words)
    seconds.blur()


def x(stage: Stage) -> float:
    """Of the camera's place in the newest pose."""
    return float(stage.all("pose")[-1]["matrix"][12])


def test_views_make_a_way_that_is_flown_changed_and_kept_in_files(page: Page, stage: Stage, tmp_path: Path) -> None:
    end, before = x(stage), len(stage.all("pose"))
    preview = page.get_by_role("button", name="Preview")
    preview.press("Enter")

    def flown() -> list[float]:
        return [pose["matrix"][12] for pose in stage.all("pose")[before:]]

    wait_for(page, lambda: len(flown()) > 1 and abs(flown()[-1] - end) < 1e-9)
    assert flown()[0] < 0.01 * end
    assert flown() == sorted(flown())
    expect(preview).to_be_focused()
    set_seconds(page, "60")
    preview.click()
    expect(page.locator("#film-time")).to_contain_text("of 60 s")
    page.locator("#view").focus()
    page.keyboard.down("KeyA")  # who walks takes over
    expect(preview).to_be_visible()
    page.keyboard.up("KeyA")
    set_seconds(page, "1")

    with page.expect_download() as saving:
        page.get_by_role("button", name="Save path").click()
    path = tmp_path / "path.json"
    saving.value.save_as(path)
    keyframes = json.loads(path.read_text())["keyframes"]
    assert [it["time"] for it in keyframes] == [0, 1]
    assert keyframes[1]["camera"]["position"][0] == pytest.approx(end)
    later = [{**it, "time": 3 + it["time"]} for it in keyframes]
    path.write_text(json.dumps({"keyframes": [{"time": 2, "camera": 0, "name": "front"}, *later]}))
    page.set_input_files("#film-file", path)
    expect(page.locator("#film-time")).to_have_text("2 s")
    path.write_text(json.dumps({"keyframes": [{"time": 2, "camera": 0}, {"time": 1, "camera": 0}]}))
    page.set_input_files("#film-file", path)
    expect(page.locator("#film-problem")).to_contain_text("keyframes[1].time: must be a number after 2")

    names = page.locator("#film-stops .go")
    page.get_by_role("button", name="Move View 1 before the view before").press("Enter")
    assert names.all_text_contents() == ["View 1", "front", "View 2"]
    expect(names.first).to_be_focused()
    page.get_by_role("button", name="Remove front from the film").press("Enter")
    stage.reload()
    page.keyboard.press("KeyB")
    page.locator("#film summary").click()
    assert names.all_text_contents() == ["View 1", "View 2"]
    names.last.click()
    wait_for(page, lambda: abs(x(stage) - end) < 1e-9)
    page.get_by_role("button", name="Remove View 2 from the film").click()
    expect(page.get_by_role("button", name="Render film")).to_be_disabled()
    expect(page.locator("#film-hint")).to_be_visible()


def test_a_page_that_is_loaded_again_goes_on_telling_of_its_film(page: Page, stage: Stage) -> None:
    pytest.importorskip("av", reason="the extra video is not installed")
    page.get_by_label("size", exact=True).select_option("640x360")
    page.get_by_label("frames a picture").fill("2")
    set_seconds(page, "60")
    page.get_by_role("button", name="Render film").click()
    expect(page.locator("#film-state")).to_contain_text("of 1800")
    stage.reload()
    expect(page.locator("#toast")).to_have_text("Your film is being rendered; see Bookmarks (B)")
    page.keyboard.press("KeyB")
    expect(page.locator("#film-state")).to_contain_text("of 1800")
    expect(page.locator("#film-state")).to_be_in_viewport()
    page.get_by_role("button", name="Cancel", exact=True).click()
    expect(page.locator("#film-job")).to_be_hidden()


def test_the_server_renders_the_film_or_says_why_not(page: Page, stage: Stage, complaints: list[str]) -> None:
    av = pytest.importorskip("av", reason="the extra video is not installed")
    page.get_by_label("size", exact=True).select_option("640x360")
    page.get_by_label("pictures a second").select_option("24")
    page.get_by_label("frames a picture").fill("2")
    page.get_by_label("codec").select_option("av1")
    set_seconds(page, "0.25")
    page.get_by_role("button", name="Render film").click()
    expect(page.locator("#film-state")).to_have_text("The film is ready", timeout=60_000)
    stage.reload()  # the browser remembers what it ordered, and that it has told of it
    page.keyboard.press("KeyB")
    page.locator("#film summary").click()
    expect(page.locator("#film-state")).to_have_text("The film is ready")
    expect(page.locator("#toast")).to_be_hidden()
    page.evaluate(CLOSED_BEFORE)
    stage.reload()
    expect(page.locator("#toast")).to_have_text("The film is ready; see Bookmarks (B)")
    page.keyboard.press("KeyB")
    expect(page.locator("#film-state")).to_be_visible()
    with page.expect_download() as saving:
        page.get_by_role("link", name="Download film").click()
    assert saving.value.suggested_filename == "cornell-box.mp4"
    with av.open(io.BytesIO(Path(saving.value.path()).read_bytes())) as container:
        assert container.streams.video[0].codec_context.name == "libdav1d"
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert (len(frames), frames[0].shape) == (6, (360, 640, 3))

    page.get_by_label("size", exact=True).select_option("3840x2160")
    page.get_by_label("frames a picture").fill("4096")
    set_seconds(page, "600")
    page.get_by_role("button", name="Render film").click()
    expect(page.locator("#film-problem")).to_contain_text("are expected to take")
    expect(page.get_by_role("button", name="Render film")).to_be_enabled()
    assert all("422" in complaint for complaint in complaints)  # the browser notes every refusal
    complaints.clear()
