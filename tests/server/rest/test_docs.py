import re

from harness import Running


def test_the_docs_and_all_that_they_load_are_served_from_here(running: Running) -> None:
    page = running.http.get("/api/docs")
    assert page.status_code == 200
    icon, *loaded = re.findall(r'(?:src|href)="([^"]+)"', page.text)
    assert icon.startswith("data:")
    assert len(loaded) == 3
    for path in loaded:
        assert path.startswith("docs/")  # from the page's own address, whatever the prefix
        response = running.http.get(f"/api/{path}")
        assert response.status_code == 200
        assert response.headers["Content-Type"].split(";")[0] in ("text/javascript", "text/css")
    assert '"openapi.json"' in running.http.get("/api/docs/start.js").text
    assert not re.search(r"<script[^>]*>[^<]", page.text)  # the Content-Security-Policy allows none inside the page


def test_the_interface_is_described(running: Running) -> None:
    interface = running.http.get("/api/openapi.json").json()
    assert "/api/v1/render" in interface["paths"]
    assert "/api/docs" not in interface["paths"]
