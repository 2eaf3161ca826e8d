import asyncio
from base64 import urlsafe_b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import httpx
import pytest
from harness import Running, Walker, run
from starlette.responses import PlainTextResponse
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from server.http.security import HEADERS, TOKEN_PROTOCOL, WRONG_BURST, Guard, with_token
from server.metrics import Metrics
from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}
BROWSER = {"Accept": "text/html,*/*"}


@pytest.fixture(scope="module")
def locked() -> Iterator[Running]:
    """A ready service with a token."""
    with run(ServerSettings(port=0, token=TOKEN)) as running:
        running.wait_ready()
        yield running


def stream(running: Running, headers: Mapping[str, str]) -> None:
    """Opens a WebSocket and says hello."""
    with connect(f"ws://{running.http.base_url.netloc.decode()}/api/v1/stream", additional_headers=headers) as socket:
        Walker(socket).hello()


def judge(path: str = "/", method: str = "GET", times: int = 1, headers: Any = None, **settings: Any) -> httpx.Response:
    """The answer of a Guard alone to the last of some requests; what it lets in is answered with 200."""
    guard = Guard(PlainTextResponse("in"), ServerSettings(**settings), Metrics())

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(guard)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost:8000") as client:
            for _ in range(times - 1):
                await client.request(method, path, headers=headers)
            return await client.request(method, path, headers=headers)

    return asyncio.run(ask())


@pytest.mark.parametrize("path", ["/", "/metrics", "/api/v1/scenes", "/api/docs", "/main.js", "/nothing"])
def test_everything_needs_the_token(locked: Running, path: str) -> None:
    for headers in ({}, {"Authorization": "Bearer wrong"}, {"Authorization": f"Basic {TOKEN}"}, {"Cookie": "token=1"}):
        response = locked.http.get(path, headers=headers)
        assert response.status_code == 401
        assert response.headers["WWW-Authenticate"].startswith("Bearer")
        assert response.json()["code"] == "unauthorized"
    assert locked.http.get(path, headers=BEARER).status_code == (404 if path == "/nothing" else 200)


@pytest.mark.parametrize("path", ["/healthz", "/readyz"])
def test_supervisors_need_none(locked: Running, path: str) -> None:
    assert locked.http.get(path).status_code == 200


def test_the_token_in_the_address_becomes_a_cookie(locked: Running) -> None:
    with httpx.Client(base_url=locked.http.base_url) as browser:
        response = browser.get("/", params={"scene": "a b", "token": TOKEN, "x": "1"})
        assert response.status_code == 303
        assert response.headers["Location"] == "./?scene=a+b&x=1"
        cookie = response.headers["Set-Cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        assert "Path=/;" in cookie
        assert TOKEN not in cookie
        assert browser.get("/").status_code == 200
        stream(locked, {"Cookie": cookie.split(";")[0]})


@pytest.mark.parametrize(
    ("path", "expected"),
    [("//elsewhere.example/%5Cx", "./%5Cx"), ("/api/docs", "./docs"), ("/", "./"), ("/http:x", "./http%3Ax")],
)
def test_a_redirect_stays_here(path: str, expected: str) -> None:
    response = judge(f"http://localhost:8000{path}?token={TOKEN}", token=TOKEN)
    assert response.headers["Location"] == expected


def test_a_browser_without_the_token_is_asked_for_it(locked: Running) -> None:
    response = locked.http.get("/", headers=BROWSER)
    assert response.status_code == 401
    assert 'name="token"' in response.text
    assert "refresh" not in response.text
    assert "not the token" not in response.text
    wrong = locked.http.get("/", params={"token": "wrong"}, headers=BROWSER)
    assert (wrong.status_code, "That is not the token." in wrong.text) == (401, True)
    elsewhere = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
    assert "refresh" in locked.http.get("/", headers=BROWSER | elsewhere).text  # the cookie comes with the second try


def test_a_handshake_needs_the_token(locked: Running) -> None:
    for headers in ({}, {"Authorization": "Bearer wrong"}):
        with pytest.raises(InvalidStatus, match="401"):
            stream(locked, headers)
    stream(locked, BEARER)


def test_a_page_may_bring_the_token_as_a_subprotocol(locked: Running) -> None:
    url = f"ws://{locked.http.base_url.netloc.decode()}/api/v1/stream"
    offered = TOKEN_PROTOCOL + urlsafe_b64encode(TOKEN.encode()).decode().rstrip("=")
    with connect(url, subprotocols=[Subprotocol("lumenwalk"), Subprotocol(offered)]) as socket:
        assert socket.subprotocol == "lumenwalk"
        Walker(socket).hello()
    for wrong in ("bearer.d3Jvbmc", "bearer.x", "bearer."):
        with pytest.raises(InvalidStatus, match="401"):
            connect(url, subprotocols=[Subprotocol("lumenwalk"), Subprotocol(wrong)])


def test_a_handshake_from_another_page_is_refused(locked: Running) -> None:
    own = f"http://{locked.http.base_url.netloc.decode()}"
    stream(locked, BEARER | {"Origin": own})
    for origin in ("http://elsewhere.example", own + "1", "null", "http://["):
        with pytest.raises(InvalidStatus, match="403"):
            stream(locked, BEARER | {"Origin": origin})


def test_a_form_of_another_page_is_refused() -> None:
    assert judge(method="POST", headers={"Origin": "http://elsewhere.example"}).status_code == 403
    assert judge(method="DELETE", headers={"Origin": "null"}).status_code == 403
    assert judge(method="POST", headers={"Origin": "http://localhost:8000"}).status_code == 200
    assert judge(method="POST").status_code == 200
    assert judge(headers={"Origin": "http://elsewhere.example"}).status_code == 200
    allowed = judge(method="POST", headers={"Origin": "https://Page.example"}, allowed_origins=["https://page.example"])
    assert allowed.status_code == 200


def test_an_origin_is_of_this_scheme_and_port() -> None:
    for origin in ("https://localhost:8000", "http://localhost", "http://localhost:8001", "http://localhost:08000x"):
        response = judge(method="POST", headers={"Origin": origin})
        assert (response.status_code, response.json()["code"]) == (403, "foreign-origin")
        assert "http://localhost:8000" in response.json()["message"]
    assert judge(method="POST", headers={"Origin": "http://[::1]", "Host": "[::1]:80"}).status_code == 200
    only = {"allowed_origins": ["https://page.example"]}
    for origin in ("http://page.example", "https://page.example:8443", "https://a.page.example"):
        assert judge(method="POST", headers={"Origin": origin}, **only).status_code == 403
    assert judge(method="POST", headers={"Origin": "https://page.example:443"}, **only).status_code == 200


def test_a_page_elsewhere_is_told_at_once_that_it_may_not() -> None:
    preflight = {"Origin": "https://page.example", "Access-Control-Request-Method": "POST"}
    response = judge(method="OPTIONS", headers=preflight, token=TOKEN)
    assert (response.status_code, response.json()["code"]) == (403, "foreign-origin")


def test_on_loopback_only_loopback_names_are_answered_to() -> None:
    for name in ("localhost", "LOCALHOST:9", "127.0.0.1:8000", "[::1]:8000", "[::ffff:127.0.0.1]", "a.localhost"):
        assert judge(headers={"Host": name}).status_code == 200
    for name in (
        "rebound.example",
        "192.0.2.1",
        "127.0.0.1.example:8000",
        "[2001:db8::1]:80",
        "localhost@a.example",
        "[",
        "",
    ):
        response = judge(headers={"Host": name})
        assert (response.status_code, response.json()["code"]) == (400, "unknown-host")
    assert judge(headers={"Host": "rebound.example"}, allowed_hosts="Rebound.example, b").status_code == 200


def test_elsewhere_any_name_or_only_those_allowed() -> None:
    open_ = {"host": "0.0.0.0", "token": TOKEN}
    assert judge(headers=BEARER | {"Host": "any.example"}, **open_).status_code == 200
    assert judge(headers=BEARER | {"Host": "any.example"}, allowed_hosts=["one.example"], **open_).status_code == 400
    assert judge(headers=BEARER | {"Host": "one.example:80"}, allowed_hosts=["one.example"], **open_).status_code == 200
    assert judge(headers=BEARER | {"Host": "127.0.0.1"}, allowed_hosts=["one.example"], **open_).status_code == 200


def test_who_guesses_has_to_wait() -> None:
    wrong = {"Authorization": "Bearer a-wrong-guess"}
    assert judge(headers=wrong, times=int(WRONG_BURST), token=TOKEN).status_code == 401
    response = judge(headers=wrong, times=int(WRONG_BURST) + 1, token=TOKEN)
    assert response.status_code == 429
    assert "Retry-After" in response.headers
    assert judge(times=int(WRONG_BURST) + 1, token=TOKEN).status_code == 401  # to bring none is no guess


def test_who_has_the_token_comes_in_whatever_others_guess() -> None:
    guard = Guard(PlainTextResponse("in"), ServerSettings(token=TOKEN), Metrics())
    wrong = {"Authorization": "Bearer a-wrong-guess"}

    async def main() -> list[int]:
        transport = httpx.ASGITransport(guard)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost:8000") as client:
            guesses = [await client.get("/api/v1/jobs", headers=wrong) for _ in range(int(WRONG_BURST) + 1)]
            right = [await client.get(f"/?token={TOKEN}"), await client.get("/api/v1/jobs")]  # the second by the cookie
            client.cookies.clear()
            right.append(await client.get("/api/v1/jobs", headers=BEARER))
        return [answer.status_code for answer in (guesses[-1], *right)]

    assert asyncio.run(main()) == [429, 303, 200, 200]


def test_pages_of_other_sites_cause_no_work() -> None:
    elsewhere = {"Sec-Fetch-Site": "cross-site"}
    assert judge(headers=elsewhere | {"Sec-Fetch-Mode": "no-cors"}).status_code == 403
    assert judge(headers=elsewhere | {"Sec-Fetch-Mode": "navigate"}).status_code == 200
    assert judge(headers={"Sec-Fetch-Site": "same-origin", "Sec-Fetch-Mode": "cors"}).status_code == 200


def test_a_token_is_made_where_others_could_come() -> None:
    made = [with_token(ServerSettings(host="0.0.0.0")).token for _ in range(2)]
    assert all(token is not None and len(token.get_secret_value()) >= 32 for token in made)
    assert made[0] != made[1]
    assert with_token(ServerSettings(host="127.0.0.1")).token is None
    given = ServerSettings(host="0.0.0.0", token=TOKEN)
    assert with_token(given) is given
    assert TOKEN not in repr(given)


@pytest.mark.parametrize("path", ["/", "/main.js", "/api/v1/scenes", "/nothing", "/metrics", "/healthz"])
def test_every_answer_has_the_headers(locked: Running, path: str) -> None:
    for headers in ({}, BEARER):
        response = locked.http.get(path, headers=headers)
        assert {name: response.headers.get(name) for name in HEADERS} == HEADERS
        assert "Server" not in response.headers


def test_the_page_loads_nothing_from_elsewhere() -> None:
    assert "http" not in HEADERS["Content-Security-Policy"]
    assert "unsafe" not in HEADERS["Content-Security-Policy"]


def test_no_path_leaves_the_scenes_folder(tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    (tmp_path / "outside.glb").write_bytes(b"")
    (folder / "link.glb").symlink_to(tmp_path / "outside.glb")
    with run(ServerSettings(port=0, scenes_dir=folder)) as running:
        running.wait_ready()
        for name in ("../outside.glb", "/etc/passwd", "a/../../outside.glb", "link.glb", "%2e%2e/outside.glb"):
            assert running.http.post("/api/v1/render", json={"scene": name, "size": [8, 8]}).status_code == 404, name
            assert running.http.get(f"/api/v1/scenes/{name}").status_code == 404, name
