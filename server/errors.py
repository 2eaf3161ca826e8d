"""What goes wrong over HTTP, as JSON {code, message} with the status that fits."""

from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException

from gpu.errors import UserError
from server.engine import RenderFaultError
from server.link import WorkerLostError
from server.scenes import UnknownSceneError

RETRY_SECONDS = 2


class ErrorBody(BaseModel):
    """Why a request was not answered as asked."""

    code: str = Field(description="for programs")
    message: str = Field(description="for people: what is wrong and where")


class TooBusyError(Exception):
    """As much waits to be rendered as may."""


class NotAcceptableError(Exception):
    """None of the formats that the client takes can be written."""


_STATUS: dict[type[Exception], tuple[int, str]] = {
    UnknownSceneError: (404, "unknown-scene"),
    UserError: (422, "bad-request"),
    NotAcceptableError: (406, "not-acceptable"),
    TooBusyError: (429, "too-busy"),
    WorkerLostError: (503, "unavailable"),
    RenderFaultError: (500, "render-failed"),
}


def error_response(status: int, code: str, message: str) -> JSONResponse:
    """A typed error; those that pass say when to try again."""
    headers = {"Retry-After": str(RETRY_SECONDS)} if status in (429, 503) else None
    return JSONResponse(ErrorBody(code=code, message=message).model_dump(), status, headers)


def install(app: FastAPI) -> None:
    """Answer every expected error of `app` in that form."""

    async def expected(_: Request, error: Exception) -> JSONResponse:
        status, code = next(_STATUS[kind] for kind in type(error).__mro__ if kind in _STATUS)
        return error_response(status, code, str(error))

    async def invalid(_: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, RequestValidationError)
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"][1:])
        return error_response(422, "bad-request", f"{place}: {first['msg']}" if place else str(first["msg"]))

    async def http(_: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        code = HTTPStatus(error.status_code).phrase.lower().replace(" ", "-")
        return error_response(error.status_code, code, str(error.detail))

    for kind in _STATUS:
        app.add_exception_handler(kind, expected)
    app.add_exception_handler(RequestValidationError, invalid)
    app.add_exception_handler(HTTPException, http)
