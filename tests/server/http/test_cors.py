"""Pages of allowed origins, as their browsers ask for them."""

from collections.abc import Iterator

import pytest
from harness import Running, Walker, run
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}
PORTAL = {"Origin": "https://portal.example.org"}
OTHER = {"Origin": "https://other.example.org"}
RENDER = {"size": [32, 18]}
ASKS = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "authorization,content-type"}


@pytest.fixture(scope="module")
def portal() -> Iterator[Running]:
    """A ready service with a token, for the pages of one origin."""
    with run(ServerSettings(port=0, token=TOKEN, allowed_origins=PORTAL["Origin"])) as running:
        running.wait_ready()
        yield running


@pytest.mark.parametrize("path", ["/api/v1/render", "/api/v1/scenes?name=a.glb", "/api/v1/jobs/1", "/nothing"])
def test_a_browser_may_ask_first_without_the_token(portal: Running, path: str) -> None:
    response = portal.http.options(path, headers=PORTAL | ASKS)
    assert response.status_code == 204
    assert response.headers["Access-Control-Allow-Origin"] == PORTAL["Origin"]
    assert response.headers["Access-Control-Allow-Credentials"] == "true"
    assert {"POST", "DELETE"} <= set(response.headers["Access-Control-Allow-Methods"].split(", "))
    assert {"Authorization", "Content-Type"} <= set(response.headers["Access-Control-Allow-Headers"].split(", "))
    assert "Origin" in response.headers["Vary"]


def test_its_page_may_ask_and_read_the_answer(portal: Running) -> None:
    response = portal.http.post("/api/v1/render", json=RENDER, headers=PORTAL | BEARER)
    assert response.status_code == 200
    assert response.headers["Access-Control-Allow-Origin"] == PORTAL["Origin"]
    exposed = response.headers["Access-Control-Expose-Headers"].split(", ")
    assert {name.lower() for name in response.headers if name.startswith("x-lumenwalk")} <= {
        name.lower() for name in exposed
    }
    made = portal.http.post("/api/v1/jobs", json=RENDER, headers=PORTAL | BEARER)
    assert (made.status_code, "Location" in exposed) == (202, True)


def test_its_page_may_read_why_it_is_refused(portal: Running) -> None:
    response = portal.http.post("/api/v1/render", json=RENDER, headers=PORTAL)
    assert (response.status_code, response.json()["code"]) == (401, "unauthorized")
    assert response.headers["Access-Control-Allow-Origin"] == PORTAL["Origin"]


@pytest.mark.parametrize("origin", ["https://other.example.org", "http://portal.example.org", "null"])
def test_other_origins_are_refused_with_the_reason(portal: Running, origin: str) -> None:
    for response in (
        portal.http.options("/api/v1/render", headers=ASKS | {"Origin": origin}),
        portal.http.post("/api/v1/render", json=RENDER, headers=BEARER | {"Origin": origin}),
    ):
        assert (response.status_code, response.json()["code"]) == (403, "foreign-origin")
        assert origin in response.json()["message"]
        assert "allowed_origins" in response.json()["message"]
        assert "Access-Control-Allow-Origin" not in response.headers
    shown = portal.http.get("/api/v1/scenes", headers=BEARER | {"Origin": origin})
    assert "Access-Control-Allow-Origin" not in shown.headers  # so that its page cannot read it
    assert "Origin" in shown.headers["Vary"]


def test_its_page_may_walk(portal: Running) -> None:
    url = f"ws://{portal.http.base_url.netloc.decode()}/api/v1/stream"
    with connect(url, additional_headers=PORTAL | BEARER) as socket:
        Walker(socket).hello()
    with pytest.raises(InvalidStatus, match="403"):
        connect(url, additional_headers=OTHER | BEARER)


def test_without_such_origins_nothing_is_said_of_them(running: Running) -> None:
    response = running.http.get("/api/v1/scenes", headers=PORTAL)
    assert not [name for name in response.headers if name.startswith("access-control")]
