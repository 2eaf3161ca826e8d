import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from chromium import CHROMIUM, FLAGS
from harness import Running, run
from playwright.sync_api import Browser, ConsoleMessage, Page, Request, expect, sync_playwright

from server.settings import ServerSettings

expect.set_options(timeout=30_000)  # ms, on busy cores


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """Debian's Chromium, without a screen; for this folder alone, since Playwright's loop keeps others from theirs."""
    if not CHROMIUM.exists():
        pytest.skip(f"needs Chromium at {CHROMIUM} (Debian's package chromium-headless-shell)")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        with closing(browser):
            yield browser


@pytest.fixture
def complaints() -> list[str]:
    """What the page complained about in the browser's console, and what it asked of other hosts."""
    return []


@pytest.fixture
def page(browser: Browser, complaints: list[str]) -> Iterator[Page]:
    """An empty page of a desktop's size; the test fails when the console has complaints at its end."""

    def console(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            complaints.append(f"{message.type}: {message.text}")

    def request(request: Request) -> None:
        if not request.url.startswith(("http://127.0.0.1:", "data:")):
            complaints.append(f"asks another host: {request.url}")

    context = browser.new_context(viewport={"width": 1280, "height": 720})
    with closing(context):
        page = context.new_page()
        page.on("console", console)
        page.on("pageerror", lambda error: complaints.append(f"exception: {error}"))
        page.on("request", request)
        yield page
        assert complaints == []


@pytest.fixture(scope="package")
def gradients(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """A service whose pictures are gradients, green by the x of the camera, with a broken scene to choose."""
    folder = tmp_path_factory.mktemp("scenes")
    (folder / "hall.glb").write_bytes(b"")
    (folder / "broken.glb").write_bytes(b"")
    with run(ServerSettings(port=0, scenes_dir=folder, max_stream_pixels=640 * 360)) as service:
        service.wait_ready()
        yield service


@pytest.fixture(scope="module")
def real_url() -> Iterator[str]:
    """The URL of the real program, which renders a built-in scene on the CPU."""
    program = Path(sys.executable).with_name("lumenwalk")
    command = (program, "serve", "--port", "0", "--scene", "cornell-box", "--device", "cpu")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            # It prints its URL when a frame can be had, and ends at once when it cannot start.
            url = process.stdout.readline().strip()
            assert url.startswith("http://"), f"the server did not start (exit status {process.poll()})"
            yield url
        finally:
            process.terminate()
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
