"""Whether the service lives, and whether it can render."""

from typing import Any, Literal

from fastapi import APIRouter
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field

from server.errors import RETRY_SECONDS
from server.render.engine import Engine
from server.service import Service, TheService

router = APIRouter()
OPEN: dict[str, Any] = {"security": [{}]}  # no token is asked for


class Alive(BaseModel):
    """The web process lives."""

    status: Literal["ok"] = "ok"


class WorkerReadiness(BaseModel):
    """One of the processes that render, each on a device."""

    status: str = Field(description='"ready", "starting", "recovering", "failed", or "busy" with a turn for too long')
    device: str = Field(description="that renders; empty before it has said which")
    restarts: int
    viewers: int = Field(description="whose frames it renders")
    text: str = Field(description="what goes on, when it is not ready")


class Readiness(BaseModel):
    """Whether frames can be had, and what goes on otherwise."""

    status: str = Field(description='"ready", or what the service does instead: "starting", "busy", "stopping", …')
    restarts: int = Field(description="times that a renderer was started again")
    viewers: int
    workers: list[WorkerReadiness] = Field(description="in the order of `device` in the settings; one is enough")
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
    engines = service.engines
    stopping, overdue = service.stopping.is_set(), engines.overdue
    state = "busy" if engines.ready and overdue else engines.activity.state
    body: dict[str, Any] = {
        "status": "stopping" if stopping else state,
        "restarts": engines.restarts,
        "viewers": len(service.viewers),
        "workers": [_worker(service, it) for it in engines.engines],
    }
    if engines.ready and not stopping and not overdue:
        return JSONResponse(body | {"device": engines.device})
    words = {"text": overdue or engines.activity.text, "fraction": engines.activity.fraction}
    return JSONResponse(body | words, 503, {"Retry-After": str(RETRY_SECONDS)})


def _worker(service: Service, engine: Engine) -> dict[str, Any]:
    overdue = engine.overdue if engine.ready else ""
    return {
        "status": "busy" if overdue else engine.activity.state,
        "device": engine.device,
        "restarts": engine.restarts,
        "viewers": len(service.engines.clients_of(engine) & service.viewers.keys()),
        "text": overdue or engine.activity.text,
    }
