import asyncio
import inspect
from typing import Annotated, Any, Self

import httpx
import pytest
from fastapi import FastAPI, Query
from pydantic import BaseModel, Json, model_validator

from gpu.errors import OutOfMemoryError, SceneError, UserError
from server import errors, refusals
from server.render.pending import RenderFaultError
from server.render.worker_link import WorkerLostError

REFUSALS = [kind for _, kind in inspect.getmembers(refusals, inspect.isclass) if kind.__module__ == refusals.__name__]


def answer_to(path: str, error: Exception) -> httpx.Response:
    """What an application answers that meets `error` at /NUMBER."""
    app = FastAPI()
    errors.install(app)

    @app.get("/{number}")
    async def fail(number: int) -> None:
        raise error

    async def get() -> httpx.Response:
        transport = httpx.ASGITransport(app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://here") as client:
            return await client.get(path)

    return asyncio.run(get())


@pytest.mark.parametrize(
    ("error", "status", "code"),
    [
        (refusals.UnknownSceneError("no"), 404, "unknown-scene"),
        (refusals.TooBusyError("no"), 429, "too-busy"),
        (UserError("no"), 422, "bad-request"),
        (SceneError("hall", "nodes[0]", "no"), 422, "bad-request"),  # as its kind's parent
        (OutOfMemoryError("no"), 422, "bad-request"),
        (WorkerLostError("no"), 503, "unavailable"),
        (RenderFaultError("no"), 500, "render-failed"),
    ],
)
def test_an_expected_error_is_told_with_its_status_and_code(error: Exception, status: int, code: str) -> None:
    answer = answer_to("/1", error)
    assert answer.status_code == status
    assert answer.json() == {"code": code, "message": str(error)} == errors.error_body(error).model_dump()
    assert ("retry-after" in answer.headers) is (status in (429, 503))


@pytest.mark.parametrize("kind", REFUSALS)
def test_every_refusal_has_the_status_that_it_names(kind: type[Exception]) -> None:
    status = answer_to("/1", kind("no")).status_code
    assert f"({status})" in str(kind.__doc__)


def test_requests_that_cannot_be_read_and_paths_that_lead_nowhere_are_told_alike() -> None:
    wrong = answer_to("/one", UserError("no"))
    assert wrong.status_code == 422
    assert wrong.json()["code"] == "bad-request"
    assert wrong.json()["message"].startswith("number: ")
    missing = answer_to("/1/2", UserError("no"))
    assert (missing.status_code, missing.json()["code"]) == (404, "not-found")
    assert missing.json()["message"] == "there is nothing at /1/2; api/docs tells what there is"


def test_a_fault_is_told_in_the_same_form_without_what_it_was() -> None:
    answer = answer_to("/1", ZeroDivisionError("secret"))
    assert (answer.status_code, answer.json()["code"]) == (500, "fault")
    assert "secret" not in answer.text


class Thing(BaseModel):
    one: int
    two: int = 0

    @model_validator(mode="after")
    def _differ(self) -> Self:
        if self.one == self.two:
            raise ValueError("one and two must differ")
        return self


@pytest.mark.parametrize(
    ("address", "content", "media_type", "message"),
    [
        ("/thing", b'{"one":', "application/json", "Invalid JSON: Expecting value at character 7"),
        ("/thing", b"[]", "application/json", "body: must be a JSON object, sent with Content-Type"),
        ("/thing", b"", "application/json", "body: must be a JSON object, sent with Content-Type"),
        ("/thing", b'{"one": 1}', "text/plain", "body: must be a JSON object, sent with Content-Type"),
        ("/thing", b"{}", "application/json", "one: is missing"),
        ("/thing", b'{"one": "\xf6"}', "application/json", "body: is not text in UTF-8: invalid start byte at byte 9"),
        ("/thing", b"[" * 100_000, "application/json", "body: is nested too deep"),
        ("/thing", b'{"one": ' + b"1" * 5000, "application/json", "body: cannot be read as JSON: Exceeds the limit"),
        ("/thing", b'{"one": 0}', "application/json", "body: one and two must differ"),
        ("/thing?more=%7B", b'{"one": 1}', "application/json", "more: Invalid JSON: EOF while parsing"),
    ],
)
def test_what_is_wrong_with_a_request_is_told_and_where(
    address: str, content: bytes, media_type: str, message: str
) -> None:
    app = FastAPI()
    errors.install(app)

    @app.post("/thing")
    async def post(thing: Thing, more: Annotated[Json[Any] | None, Query()] = None) -> None: ...

    async def ask() -> httpx.Response:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://here") as client:
            return await client.post(address, content=content, headers={"Content-Type": media_type})

    answer = asyncio.run(ask())
    assert (answer.status_code, answer.json()["code"]) == (422, "bad-request")
    assert answer.json()["message"].startswith(message)


def test_another_method_is_told_which_there_are() -> None:
    app = FastAPI()
    errors.install(app)

    @app.get("/thing")
    async def get() -> None: ...

    @app.delete("/thing")
    async def delete() -> None: ...

    async def ask() -> httpx.Response:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://here") as client:
            return await client.put("/thing")

    answer = asyncio.run(ask())
    assert (answer.status_code, answer.headers["Allow"]) == (405, "GET, HEAD, DELETE")


def test_what_every_request_can_be_refused_for_is_described() -> None:
    assert {400, 401, 404, 500, 503} <= errors.refusals(404).keys()
    assert 404 not in errors.refusals()
