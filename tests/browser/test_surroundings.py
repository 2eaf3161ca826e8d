"""The page where services stand: below a path prefix, over http:// from another machine, and asked by other pages."""

import socket
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest
from harness import Running, run
from playwright.sync_api import Browser, Page, expect

from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"
PREFIX = "/walk"
ASK = """async ([url, token]) => {
    const body = JSON.stringify({ size: [32, 18] });
    const headers = { Authorization: `Bearer ${token}`, "Content-Type": "application/json" };
    const still = await fetch(`${url}/api/v1/render`, { method: "POST", headers, body });
    const made = await fetch(`${url}/api/v1/jobs`, { method: "POST", headers, body });
    const refused = await fetch(`${url}/api/v1/scenes`);
    return [still.status, still.headers.get("X-Lumenwalk-Render-Ms") !== null, made.headers.get("Location") !== null,
            (await refused.json()).code];
}"""
WALK = """([url, token]) => new Promise((resolve) => {
    const socket = new WebSocket(`${url.replace("http", "ws")}/api/v1/stream`, ["lumenwalk", `bearer.${token}`]);
    socket.onopen = () => resolve(socket.protocol);
    socket.onerror = () => resolve("refused");
})"""


@pytest.fixture
def visitor(browser: Browser) -> Iterator[Page]:
    """A page of a context of its own."""
    with closing(browser.new_context(viewport={"width": 1280, "height": 720})) as context:
        yield context.new_page()


@pytest.fixture(scope="module")
def below() -> Iterator[Running]:
    """A service below a prefix."""
    with run(ServerSettings(port=0, token=TOKEN, root_path=PREFIX)) as service:
        service.wait_ready()
        yield service


def test_everything_is_asked_for_below_the_prefix(visitor: Page, below: Running) -> None:
    asked: list[str] = []
    visitor.on("request", lambda request: asked.append(request.url))
    visitor.on("websocket", lambda opened: asked.append(opened.url.replace("ws://", "http://")))
    origin = str(below.http.base_url).rstrip("/")
    visitor.goto(f"{origin}{PREFIX}?token={TOKEN}")
    expect(visitor.locator("body[data-picture]")).to_be_attached()
    visitor.wait_for_url(f"{origin}{PREFIX}/#*")
    visitor.locator("#file").set_input_files({"name": "a.glb", "mimeType": "model/gltf-binary", "buffer": b"glTF"})
    expect(visitor.locator("#scene")).to_have_value("uploads/a.glb")
    visitor.goto(f"{origin}{PREFIX}/api/docs")
    expect(visitor.locator(".scheme-container, .servers").first).to_contain_text(PREFIX)
    assert any("/api/v1/stream" in url for url in asked)
    assert [url for url in asked if not url.startswith((f"{origin}{PREFIX}", "data:", "blob:"))] == []


def lan_address() -> str:
    """This machine's address on its network; the test is skipped where there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("198.51.100.1", 9))  # sends nothing
        except OSError:
            pytest.skip("needs a network")
        address = str(probe.getsockname()[0])
    if address.startswith("127."):
        pytest.skip("needs a network")
    return address


def test_a_page_over_http_from_another_machine_walks_and_copies_links(visitor: Page) -> None:
    complaints: list[str] = []
    visitor.on("pageerror", lambda error: complaints.append(str(error)))
    with run(ServerSettings(host="0.0.0.0", port=0, token=TOKEN)) as service:
        service.wait_ready()
        visitor.goto(f"http://{lan_address()}:{service.http.base_url.port}/?token={TOKEN}")
        expect(visitor.locator("body[data-picture]")).to_be_attached()
        assert not visitor.evaluate("isSecureContext || 'clipboard' in navigator")
        visitor.keyboard.press("KeyC")
        expect(visitor.locator("#toast")).to_have_text("The link is copied")
        visitor.keyboard.press("KeyB")
        visitor.get_by_label("Name of the bookmark").click()
        visitor.keyboard.press("Control+V")
        expect(visitor.get_by_label("Name of the bookmark")).to_have_value(visitor.url[:60])
        visitor.keyboard.press("Escape")
        with visitor.expect_download():
            visitor.keyboard.press("KeyX")
    assert complaints == []


def test_what_a_browser_keeps_from_such_pages_is_said(visitor: Page, below: Running) -> None:
    visitor.add_init_script("delete Navigator.prototype.getGamepads")
    visitor.goto(f"{below.http.base_url}{PREFIX}/?token={TOKEN}")
    expect(visitor.locator("body[data-picture]")).to_be_attached()
    visitor.keyboard.press("KeyH")
    expect(visitor.locator("#no-gamepads")).to_be_visible()


@pytest.fixture
def portal(tmp_path: Path) -> Iterator[str]:
    """The origin of another site's page."""
    (tmp_path / "index.html").write_text("<!doctype html><title>portal</title>")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Silent, directory=str(tmp_path))) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class Silent(SimpleHTTPRequestHandler):
    """One that logs nothing."""

    def log_message(self, *_: object) -> None: ...


def test_a_page_of_an_allowed_origin_renders_and_walks(visitor: Page, portal: str) -> None:
    offered = urlsafe_b64encode(TOKEN.encode()).decode().rstrip("=")
    with run(ServerSettings(port=0, token=TOKEN, allowed_origins=portal)) as service:
        service.wait_ready()
        url = str(service.http.base_url).rstrip("/")
        visitor.goto(portal)
        assert visitor.evaluate(ASK, [url, TOKEN]) == [200, True, True, "unauthorized"]
        assert visitor.evaluate(WALK, [url, offered]) == "lumenwalk"
        assert visitor.evaluate(WALK, [url, "d3Jvbmc"]) == "refused"
        visitor.goto(portal.replace("127.0.0.1", "localhost"))  # another origin
        with pytest.raises(Exception, match="Failed to fetch"):
            visitor.evaluate(ASK, [url, TOKEN])
        assert visitor.evaluate(WALK, [url, offered]) == "refused"
