"""The service below a path prefix: every address that it writes stays there, whatever way it was told of the prefix."""

import re
from collections.abc import Iterator
from urllib.parse import urljoin, urlsplit

import httpx
import pytest
from harness import Running, Walker, run
from websockets.sync.client import connect

from server.app import NAMES
from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}
PREFIX = "/walk"
RENDER = {"size": [32, 18]}
SAID = {"X-Forwarded-Prefix": PREFIX}


class Front:
    """What a browser reaches at /walk/: with a service that was told of it, or a proxy that strips it and says so."""

    def __init__(self, service: Running, strips: bool) -> None:
        self.service, self.strips = service, strips

    def ask(self, method: str, url: str, headers: dict[str, str] | None = None, **kwargs: object) -> httpx.Response:
        path = url.removeprefix(PREFIX) if self.strips else url
        assert url.startswith(f"{PREFIX}/"), f"{url} leaves the prefix"
        asked = BEARER | (SAID if self.strips else {}) | (headers or {})
        return self.service.http.request(method, path, headers=asked, follow_redirects=False, **kwargs)  # type: ignore[arg-type]


@pytest.fixture(scope="module", params=["option", "header"])
def front(request: pytest.FixtureRequest) -> Iterator[Front]:
    told = request.param == "option"
    with run(ServerSettings(port=0, token=TOKEN, root_path=PREFIX if told else "")) as service:
        service.wait_ready()
        yield Front(service, strips=not told)


def test_jobs_are_watched_and_fetched_below_it(front: Front) -> None:
    made = front.ask("POST", "/walk/api/v1/jobs", json=RENDER)
    assert made.headers["Location"] == made.json()["url"]
    url = made.json()["url"]
    events = front.ask("GET", f"{url}/events").text
    assert f'"url":"{url}"' in events
    assert front.ask("GET", f"{url}/result").headers["Content-Type"] == "image/png"
    assert [job["url"] for job in front.ask("GET", "/walk/api/v1/jobs").json()] == [url]
    assert front.ask("DELETE", url).json()["url"] == url


def test_uploads_are_found_below_it(front: Front) -> None:
    made = front.ask("POST", "/walk/api/v1/scenes?name=a%20b.glb", content=b"glTF")
    assert made.status_code == 201, made.text
    assert front.ask("GET", made.headers["Location"]).json()["id"] == made.json()["id"]
    loaded = front.ask("POST", f"{made.headers['Location']}/load", {"Accept": "text/event-stream"})
    assert "event: end" in loaded.text


def test_the_docs_load_and_ask_below_it(front: Front) -> None:
    page = front.ask("GET", "/walk/api/docs")
    for link in re.findall(r'(?:src|href)="([^":]+)"', page.text):
        assert front.ask("GET", urljoin("/walk/api/docs", link)).status_code == 200
    described = front.ask("GET", "/walk/api/openapi.json").json()
    assert described["servers"] == [{"url": PREFIX}]


def test_the_token_becomes_a_cookie_of_the_prefix(front: Front) -> None:
    response = front.ask("GET", f"/walk/?token={TOKEN}&scene=a", {"Authorization": ""})
    assert response.status_code == 303
    assert urljoin("https://house.example/walk/?token=x", response.headers["Location"]).endswith("/walk/?scene=a")
    assert f"Path={PREFIX}/;" in response.headers["Set-Cookie"]


def test_the_page_names_what_it_loads_from_where_it_is(front: Front) -> None:
    page = front.ask("GET", "/walk/")
    links = [link for link in re.findall(r'(?:src|href)="([^"#][^"]*)"', page.text) if not link.startswith("data:")]
    assert len(links) > 3
    for link in links:
        assert front.ask("GET", urljoin("/walk/", link)).status_code == 200


def test_a_viewer_walks_below_it(front: Front) -> None:
    place = front.service.http.base_url.netloc.decode()
    url, said = (f"ws://{place}", SAID) if front.strips else (f"ws://{place}{PREFIX}", {})
    with connect(f"{url}/api/v1/stream", additional_headers=BEARER | said) as socket:
        Walker(socket).hello()


def test_supervisors_find_it_with_and_without(front: Front) -> None:
    for path in ("/healthz", "/readyz"):
        assert front.service.http.get(path).status_code == 200
        assert front.ask("GET", PREFIX + path, {"Authorization": ""}).status_code == 200


def test_limits_of_bodies_are_those_of_their_paths(front: Front) -> None:
    large = bytes(ServerSettings().max_message_bytes + 1)
    assert front.ask("POST", "/walk/api/v1/render", content=large).status_code == 413
    assert front.ask("POST", "/walk/api/v1/scenes?name=b.glb", content=b"glTF" + large).status_code == 201


def test_all_at_the_top_is_known(front: Front) -> None:
    described = front.ask("GET", "/walk/api/openapi.json").json()
    assert {urlsplit(path).path.split("/")[1] for path in described["paths"]} <= NAMES
