"""The application, put together."""

import asyncio
from pathlib import Path

import httpx
import pytest
from pydantic import TypeAdapter

from gpu.errors import UserError
from server.app import create_app, prepare, server_config
from server.settings import ServerSettings
from server.walk.stream import ROUTE
from server.walk.viewer import settings_schema


def test_proxies_and_rest_are_as_the_settings_say() -> None:
    settings = ServerSettings(keepalive_seconds=7.0)
    config = server_config(create_app(settings), settings)
    assert config.ws_ping_interval == 7.0
    assert not config.proxy_headers  # read once only, by server.http.forwarded


def test_the_first_request_finds_all_made_that_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    app, made, make, frozen = create_app(ServerSettings()), list[object](), TypeAdapter.__init__, list[bool]()

    def count(adapter: object, *args: object, **options: object) -> None:
        made.append(adapter)
        make(adapter, *args, **options)

    monkeypatch.setattr(TypeAdapter, "__init__", count)
    monkeypatch.setattr("gc.freeze", lambda: frozen.append(True))
    settings_schema.cache_clear()
    prepare(app)
    assert made
    assert settings_schema.cache_info().currsize == 1
    assert frozen
    made.clear()

    async def ask() -> int:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
            return (await client.get("/healthz")).status_code

    assert asyncio.run(ask()) == 200
    assert not made


def test_no_answer_waits_for_a_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    async def thread(*_: object) -> None:
        pytest.fail("a thread is asked, which waits for the interpreter while frames are sent")

    monkeypatch.setattr("fastapi.dependencies.utils.run_in_threadpool", thread)

    async def ask() -> int:
        transport = httpx.ASGITransport(create_app(ServerSettings()))
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
            return (await client.get("/api/v1/jobs")).status_code

    assert asyncio.run(ask()) == 200


def test_an_environment_that_cannot_be_read_is_told_at_the_start(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read: No such file"):
        create_app(ServerSettings(environment=tmp_path / "gone.hdr"))


def test_a_walk_is_asked_for_before_all_else() -> None:
    """A crowd that comes, most of it to be refused, is not matched with one route after the other."""
    routes = create_app(ServerSettings()).routes
    assert routes.index(ROUTE) <= 1
    assert all(getattr(route, "path", "") == "/api/openapi.json" for route in routes[: routes.index(ROUTE)])
