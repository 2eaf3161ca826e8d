import asyncio
from collections.abc import Mapping

import httpx
import pytest
from starlette.requests import Request
from starlette.responses import JSONResponse
from starlette.types import Receive, Scope, Send

from server.http.forwarded import Forwarded, route_path

NAMES = frozenset(("", "api", "viewer", "main.js"))


async def echo(scope: Scope, receive: Receive, send: Send) -> None:
    """Answers with what it knows of a request."""
    request = Request(scope)
    known = {"root": scope["root_path"], "route": route_path(scope), "path": scope["path"]}
    client = request.client.host if request.client else None
    await JSONResponse(known | {"scheme": scope["scheme"], "client": client})(scope, receive, send)


def ask(
    path: str, headers: Mapping[str, str] | None = None, root_path: str = "", client: str = "127.0.0.1"
) -> httpx.Response:
    """The answer to a request from `client`, where 127.0.0.1, ::1 and 192.0.2.0/24 are trusted."""
    app = Forwarded(echo, root_path, ["127.0.0.1", "::1", "192.0.2.0/24"], NAMES)

    async def get() -> httpx.Response:
        transport = httpx.ASGITransport(app, client=(client, 1))
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as http:
            return await http.get(path, headers=headers)

    return asyncio.run(get())


@pytest.mark.parametrize("prefix", ["/walk", "/viewer", "/api", "/api/v1", "/a/b"])
@pytest.mark.parametrize("path", ["/", "/main.js", "/viewer/screen.js", "/api/v1/jobs/a%20b"])
@pytest.mark.parametrize("strips", [True, False])
@pytest.mark.parametrize("said", ["option", "header"])
def test_a_prefix_is_found_whether_the_proxy_takes_it_away_or_not(
    prefix: str, path: str, strips: bool, said: str
) -> None:
    header, option = ({}, prefix) if said == "option" else ({"X-Forwarded-Prefix": prefix}, "")
    known = ask(path if strips else prefix + path, header, option).json()
    assert known["root"] == prefix
    assert known["route"] == path.replace("%20", " ")
    assert known["path"] == prefix + known["route"]


def test_a_prefix_of_the_server_counts() -> None:
    async def get() -> httpx.Response:
        transport = httpx.ASGITransport(Forwarded(echo, "", [], NAMES), root_path="/r/one")
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as http:
            return await http.get("/r/one/api/v1/jobs")

    known = asyncio.run(get()).json()
    assert (known["root"], known["route"], known["path"]) == ("/r/one", "/api/v1/jobs", "/r/one/api/v1/jobs")


def test_without_a_prefix_nothing_changes() -> None:
    assert ask("/walk/main.js").json()["route"] == "/walk/main.js"


def test_a_file_that_is_not_there_is_not_there_below_a_prefix() -> None:
    assert ask("/walk/nothing", root_path="/walk").json()["route"] == "/walk/nothing"


@pytest.mark.parametrize(
    ("said", "root"),
    [
        ("/walk/", "/walk"),
        ("/outer, /inner", "/outer/inner"),
        ("//evil.example", ""),
        ("https://evil.example", ""),
        ("/a/../b", ""),
        ("/", ""),
        ("", ""),
    ],
)
def test_what_a_proxy_says_is_taken_if_it_is_a_prefix(said: str, root: str) -> None:
    assert ask("/", {"X-Forwarded-Prefix": said}).json()["root"] == root


def test_the_option_counts_more_than_what_a_proxy_passes_on() -> None:
    assert ask("/", {"X-Forwarded-Prefix": "/other"}, "/walk").json()["root"] == "/walk"


@pytest.mark.parametrize(
    ("client", "trusted"),
    [
        ("127.0.0.1", True),
        ("::1", True),
        ("::ffff:127.0.0.1", True),
        ("192.0.2.77", True),
        ("198.51.100.1", False),
        ("2001:db8::1", False),
    ],
)
def test_only_trusted_proxies_are_believed(client: str, trusted: bool) -> None:
    headers = {"X-Forwarded-Prefix": "/walk", "X-Forwarded-Proto": "https", "X-Forwarded-For": "[2001:db8::7]:4711"}
    known = ask("/main.js", headers, client=client).json()
    assert known["root"] == ("/walk" if trusted else "")
    assert known["scheme"] == ("https" if trusted else "http")
    assert known["client"] == ("2001:db8::7" if trusted else client.removeprefix("::ffff:"))


def test_the_folder_itself_gets_its_slash() -> None:
    response = ask("/walk?token=a&x=1", root_path="/walk")
    assert response.status_code == 307
    assert response.headers["Location"] == "/walk/?token=a&x=1"
    assert ask("/walk", {"X-Forwarded-Prefix": "/walk"}).headers["Location"] == "/walk/"
