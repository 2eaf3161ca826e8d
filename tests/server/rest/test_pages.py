import re

import pytest
from harness import Running
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect


@pytest.mark.parametrize(
    ("path", "media_type"),
    [("/", "text/html"), ("/main.js", "text/javascript")],
)
def test_the_page_is_served_and_asked_about_each_time(running: Running, path: str, media_type: str) -> None:
    response = running.http.get(path)
    assert response.status_code == 200
    assert response.headers["Content-Type"].split(";")[0] == media_type
    assert response.headers["Cache-Control"] == "no-cache"
    again = running.http.get(path, headers={"If-None-Match": response.headers["ETag"]})
    assert (again.status_code, again.headers["Cache-Control"]) == (304, "no-cache")


@pytest.mark.parametrize("path", ["/nothing.js", "/api/v1/nothing", "/../pyproject.toml", "/%2e%2e/pyproject.toml"])
def test_nothing_else_is_served(running: Running, path: str) -> None:
    response = running.http.get(path)
    assert response.status_code == 404
    assert response.json()["code"] == "not-found"


def test_files_are_compressed_for_who_takes_that(running: Running) -> None:
    plain = running.http.get("/main.js", headers={"Accept-Encoding": "identity"})
    small = running.http.get("/main.js", headers={"Accept-Encoding": "gzip"})
    assert "Content-Encoding" not in plain.headers
    assert int(small.headers["Content-Length"]) < 0.4 * int(plain.headers["Content-Length"])
    assert small.content == plain.content
    assert "Accept-Encoding" in small.headers["Vary"]
    again = running.http.get("/main.js", headers={"If-None-Match": small.headers["ETag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_a_socket_to_nowhere_is_refused(running: Running) -> None:
    with pytest.raises(InvalidStatus, match="404"), connect(f"ws://{running.http.base_url.netloc.decode()}/nowhere"):
        pass


def test_the_page_comes_in_a_few_answers_of_which_it_is_asked_about_alone(running: Running) -> None:
    page = running.http.get("/")
    assert (page.headers["Cache-Control"], page.headers["Content-Type"]) == ("no-cache", "text/html; charset=utf-8")
    again = running.http.get("/", headers={"If-None-Match": page.headers["ETag"]})
    assert (again.status_code, again.content) == (304, b"")
    weakly = running.http.get(
        "/", headers={"If-None-Match": f'"other", W/{page.headers["ETag"]}'}
    )  # as proxies may ask
    assert weakly.status_code == 304
    places = re.findall(r' (?:href|src)="([^":#]+)"', page.text)
    assert 0 < len(places) < 6
    for place in places:
        part = running.http.get(f"/{place}")
        assert part.status_code == 200
        assert part.headers["Content-Type"].split(";")[0] in ("text/css", "text/javascript")
        assert part.headers["Cache-Control"] == "private, max-age=31536000, immutable"
        assert part.headers["Content-Encoding"] == "gzip"
        plain = running.http.get(f"/{place}", headers={"Accept-Encoding": "identity"})
        assert plain.content == part.content
        assert re.search(r"^import |@import", plain.text, re.MULTILINE) is None
        digest = place.split("/")[1]
        other = running.http.get(f"/{place.replace(digest, 'of-another-version')}")
        assert (other.status_code, other.headers["Cache-Control"]) == (200, "no-cache")
    assert running.http.get(f"/joined/{digest}/nothing.js").status_code == 404
    assert running.http.post(f"/{places[0]}").status_code == 405
