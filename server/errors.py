"""What goes wrong over HTTP, as JSON {code, message} with the status that fits."""

from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

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
)
from server.render.pending import RenderFaultError
from server.render.worker_link import WorkerLostError

RETRY_SECONDS = 2


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
    UserError: (422, "bad-request"),
    NotAcceptableError: (406, "not-acceptable"),
    TooBusyError: (429, "too-busy"),
    WorkerLostError: (503, "unavailable"),
    RenderFaultError: (500, "render-failed"),
}


EXPECTED = tuple(_STATUS)


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
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"][1:])
        return error_response(422, "bad-request", f"{place}: {first['msg']}" if place else str(first["msg"]))

    async def http(_: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        code = HTTPStatus(error.status_code).phrase.lower().replace(" ", "-")
        return error_response(error.status_code, code, str(error.detail))

    async def gone(_: Request, __: Exception) -> JSONResponse:
        return error_response(400, "gone", "the client has left")  # which nobody reads

    app.add_exception_handler(ClientDisconnect, gone)
    for kind in _STATUS:
        app.add_exception_handler(kind, expected)
    app.add_exception_handler(RequestValidationError, invalid)
    app.add_exception_handler(HTTPException, http)
