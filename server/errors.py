"""What goes wrong over HTTP, as JSON {code, message} with the status that fits."""

from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.routing import Match

from gpu.errors import UserError
from server.refusals import (
    ForbiddenError,
    InUseError,
    NoRoomError,
    NotAcceptableError,
    NotYetError,
    TooBusyError,
    TooLargeError,
    TooSlowError,
    UnknownJobError,
    UnknownSceneError,
    reason,
)
from server.render.cost import TooLongError
from server.render.pending import RenderFaultError
from server.render.worker_link import WorkerLostError

RETRY_SECONDS = 2
_NO_OBJECT = ("missing", "model_attributes_type", "dict_type")  # how pydantic says that something is none


class ErrorBody(BaseModel):
    """Why a request was not answered as asked."""

    code: str = Field(description="for programs")
    message: str = Field(description="for people: what is wrong and where")


_STATUS: dict[type[Exception], tuple[int, str]] = {
    UnknownSceneError: (404, "unknown-scene"),
    UnknownJobError: (404, "unknown-job"),
    ForbiddenError: (403, "forbidden"),
    InUseError: (409, "in-use"),
    NotYetError: (409, "not-yet"),
    TooLargeError: (413, "too-large"),
    TooSlowError: (408, "too-slow"),
    NoRoomError: (507, "no-room"),
    TooLongError: (422, "too-long"),
    UserError: (422, "bad-request"),
    NotAcceptableError: (406, "not-acceptable"),
    TooBusyError: (429, "too-busy"),
    WorkerLostError: (503, "unavailable"),
    RenderFaultError: (500, "render-failed"),
}


EXPECTED = tuple(_STATUS)

# What each status can mean, for the description of the interface.
_MEANINGS = {
    400: "it is no HTTP, or for a host that this service is not called",
    401: "the token is missing or wrong",
    403: "it comes from a page of another origin, or is not for clients to do",
    404: "there is no such scene or job",
    406: "none of the formats that the client takes can be written",
    408: "the body did not arrive in time",
    409: "not now: somebody uses it, or it is not done",
    413: "the body is too large",
    422: "what was asked for is wrong, or more than a limit allows; the message says where",
    426: "it asks for no WebSocket, or not as RFC 6455 has it",
    429: "as much waits as may, or too many wrong tokens came from this address",
    431: "the headers are too large",
    500: "a fault of the renderer or the service",
    503: "the renderer starts, the service stops, or too many requests are being answered",
    507: "the device or the uploads folder has no room for it",
}
_ALWAYS = (400, 401, 403, 429, 431, 500, 503)
WITH_BODY = (408, 413, 422)
"""What can come of a request that has a body."""


def refusals(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The description of an operation's refusals: of these, and those that can come of any request."""
    return {code: {"model": ErrorBody, "description": _MEANINGS[code]} for code in sorted({*_ALWAYS, *statuses})}


def error_body(error: Exception) -> ErrorBody:
    """One of the EXPECTED errors as it is told."""
    return ErrorBody(code=_status(error)[1], message=str(error))


def error_response(status: int, code: str, message: str) -> JSONResponse:
    """A typed error; those that pass say when to try again."""
    headers = {"Retry-After": str(RETRY_SECONDS)} if status in (429, 503) else None
    return JSONResponse(ErrorBody(code=code, message=message).model_dump(), status, headers)


def _status(error: Exception) -> tuple[int, str]:
    return next(_STATUS[kind] for kind in type(error).__mro__ if kind in _STATUS)


def install(app: FastAPI) -> None:
    """Answer every expected error of `app` in that form."""

    async def expected(_: Request, error: Exception) -> JSONResponse:
        return error_response(*_status(error), str(error))

    async def invalid(_: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, RequestValidationError)
        return error_response(422, "bad-request", _problem(error.errors()[0]))

    async def http(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        if (unread := _unread(error.__cause__)) is not None:
            return error_response(422, "bad-request", unread)
        code = HTTPStatus(error.status_code).phrase.lower().replace(" ", "-")
        words = f"there is nothing at {request.url.path[:100]}; api/docs tells what there is"
        response = error_response(error.status_code, code, words if error.status_code == 404 else str(error.detail))
        response.headers.update(error.headers or {})
        if allowed := _methods(app, request):
            response.headers["Allow"] = ", ".join(allowed)
        return response

    async def fault(_: Request, __: Exception) -> JSONResponse:
        return error_response(500, "fault", "a fault of the service; its log says more")

    async def gone(_: Request, __: Exception) -> JSONResponse:
        return error_response(400, "gone", "the client has left")  # which nobody reads

    app.add_exception_handler(ClientDisconnect, gone)
    for kind in _STATUS:
        app.add_exception_handler(kind, expected)
    app.add_exception_handler(RequestValidationError, invalid)
    app.add_exception_handler(HTTPException, http)
    app.add_exception_handler(Exception, fault)


def _unread(cause: BaseException | None) -> str | None:
    """What is wrong with a body that FastAPI could not read, where it does not say so itself."""
    match cause:
        case UnicodeDecodeError():
            return f"body: is not text in UTF-8: {cause.reason} at byte {cause.start}"
        case RecursionError():
            return "body: is nested too deep"
        case ValueError():  # integers of thousands of digits
            return f"body: cannot be read as JSON: {cause}"
        case _:
            return None


def _problem(first: Mapping[str, Any]) -> str:
    """What is wrong with a request, and where, of one of the problems that FastAPI tells."""
    part, *place = first["loc"]
    if part == "body" and first["type"] == "json_invalid":
        return f"Invalid JSON: {first['ctx']['error']} at character {place[-1]}"
    if part == "body" and first["type"] in _NO_OBJECT and not place:
        return "body: must be a JSON object, sent with Content-Type: application/json"
    return f"{'.'.join(map(str, place)) or part}: {reason(first)}"


def _methods(app: FastAPI, request: Request) -> list[str]:
    """What may be done with what a request is about; nothing where that is no place of the interface."""
    allowed = []
    for method in ("GET", "POST", "PATCH", "DELETE"):
        scope = {**request.scope, "method": method}
        if any(route.matches(scope)[0] is Match.FULL for route in app.routes):
            allowed += [method, "HEAD"] if method == "GET" else [method]
    return allowed
