"""Whether the service lives, and whether it can render."""

from typing import Any, Literal

from fastapi import APIRouter
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field

from server.errors import RETRY_SECONDS
from server.service import TheService

router = APIRouter()
OPEN: dict[str, Any] = {"security": [{}]}  # no token is asked for


class Alive(BaseModel):
    """The web process lives."""

    status: Literal["ok"] = "ok"


class Readiness(BaseModel):
    """Whether frames can be had, and what goes on otherwise."""

    status: str = Field(description='"ready", or what the service does instead: "starting", "busy", "stopping", …')
    restarts: int = Field(description="times that the renderer was started again")
    viewers: int
    device: str | None = Field(default=None, description="that renders, when it is ready")
    text: str | None = Field(default=None, description="what goes on, when it is not")
    fraction: float | None = Field(default=None, description="how far that is, from 0 to 1")


@router.get("/healthz", operation_id="isAlive", openapi_extra=OPEN)
async def healthz() -> Alive:
    """Answers while the web process lives."""
    return Alive()


@router.get(
    "/readyz",
    operation_id="isReady",
    openapi_extra=OPEN,
    response_model=Readiness,
    responses={
        503: {
            "model": Readiness,
            "description": "the renderer starts, or starts again; a turn takes too long; the service stops",
        }
    },
)
async def readyz(service: TheService) -> JSONResponse:
    """200 while frames can be had: kernels are loaded and one was rendered. Else 503 with what is going on, such as a
    turn that takes too long ("busy").
    """
    engine = service.engine
    stopping, overdue = service.stopping.is_set(), engine.overdue
    state = "busy" if engine.ready and overdue else engine.activity.state
    body: dict[str, Any] = {
        "status": "stopping" if stopping else state,
        "restarts": engine.restarts,
        "viewers": len(service.viewers),
    }
    if engine.ready and not stopping and not overdue:
        return JSONResponse(body | {"device": engine.device})
    words = {"text": overdue or engine.activity.text, "fraction": engine.activity.fraction}
    return JSONResponse(body | words, 503, {"Retry-After": str(RETRY_SECONDS)})
