from collections.abc import Iterator
from typing import Any

import pytest

from server.app import create_app
from server.settings import ServerSettings

TOKEN = "correct-horse-battery-staple"


def described(**settings: Any) -> dict[str, Any]:
    document: dict[str, Any] = create_app(ServerSettings(port=0, **settings)).openapi()
    return document


@pytest.fixture(scope="module")
def interface() -> dict[str, Any]:
    return described(token=TOKEN)


def operations(interface: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for path, item in interface["paths"].items():
        for method, operation in item.items():
            yield method, path, operation


def test_every_operation_has_a_name_and_says_what_it_does(interface: dict[str, Any]) -> None:
    names = [operation["operationId"] for _, _, operation in operations(interface)]
    assert len(names) == len(set(names))
    assert all(name.isalpha() for name in names)
    assert all(operation["description"] for _, _, operation in operations(interface))


def test_every_refusal_is_described_in_the_one_form(interface: dict[str, Any]) -> None:
    for method, path, operation in operations(interface):
        refused = {code: it for code, it in operation["responses"].items() if code >= "400"}
        for code, response in refused.items():
            (form,) = response["content"].values()
            name = "Readiness" if path == "/readyz" else "ErrorBody"
            assert form["schema"]["$ref"].endswith(name), (path, code)
            assert len(response["description"]) > 20
        if path not in ("/healthz", "/readyz"):
            assert {"400", "401", "403", "429", "431", "500", "503"} <= refused.keys(), path
        if method in ("post", "delete"):
            assert {"408", "413", "422"} <= refused.keys(), path


def test_no_refusal_is_described_that_cannot_come(interface: dict[str, Any]) -> None:
    for method, path, operation in operations(interface):
        if method == "get":  # which has no body
            assert not {"408", "413"} & operation["responses"].keys(), path
        busy = operation["operationId"] in ("unloadScene", "deleteScene", "getResult")
        assert ("409" in operation["responses"]) == busy, path


def test_pictures_and_metrics_are_what_they_are(interface: dict[str, Any]) -> None:
    def kinds(path: str, method: str) -> set[str]:
        return set(interface["paths"][path][method]["responses"]["200"]["content"])

    pictures = {"image/png", "image/jpeg", "image/x-exr", "application/x-npy"}
    assert kinds("/api/v1/render", "post") == pictures
    assert kinds("/api/v1/jobs/{job_id}/result", "get") == {*pictures, "video/mp4"}
    assert kinds("/metrics", "get") == {"text/plain"}
    assert kinds("/api/v1/jobs/{job_id}/events", "get") == {"text/event-stream"}


def test_how_to_come_in_is_described(interface: dict[str, Any]) -> None:
    schemes = interface["components"]["securitySchemes"]
    assert schemes["token"] == {"type": "http", "scheme": "bearer"}
    assert schemes["cookie"]["in"] == "cookie"
    assert TOKEN not in str(interface)
    assert interface["security"] == [{"token": []}, {"cookie": []}]
    assert interface["paths"]["/healthz"]["get"]["security"] == [{}]
    assert described()["security"] == [{}, {"token": []}]


def test_requests_have_examples(interface: dict[str, Any]) -> None:
    schemas = interface["components"]["schemas"]
    assert schemas["RenderRequest"]["examples"]
    assert schemas["JobRequest"]["examples"]


def test_what_this_server_gives_at_most_is_described() -> None:
    counts = described(max_samples=4, max_vpls=5000)["components"]["schemas"]["RenderSettings"]["properties"]
    most = {name: counts[name]["anyOf"][0]["maximum"] for name in ("samples", "vpls", "photons")}
    assert most == {"samples": 4, "vpls": 5000, "photons": 1_048_576}


def test_no_parameter_is_described_that_the_format_has_tools_ignore(interface: dict[str, Any]) -> None:
    names = {it["name"].lower() for _, _, operation in operations(interface) for it in operation.get("parameters", ())}
    assert "scene_id" in names
    assert "accept" not in names
