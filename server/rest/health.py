"""Whether the service lives, and whether it can render."""

from typing import Any

from fastapi import APIRouter
from fastapi.responses import JSONResponse

from server.errors import RETRY_SECONDS
from server.service import TheService

router = APIRouter()


@router.get("/healthz")
async def healthz() -> dict[str, str]:
    """Answers while the web process lives."""
    return {"status": "ok"}


@router.get(
    "/readyz",
    responses={503: {"description": "the renderer starts, for the first time or again, or the service stops"}},
)
async def readyz(service: TheService) -> JSONResponse:
    """200 while frames can be had: kernels are loaded and one was rendered. Else 503 with what is going on."""
    engine = service.engine
    stopping = service.stopping.is_set()
    body: dict[str, Any] = {
        "status": "stopping" if stopping else engine.activity.state,
        "restarts": engine.restarts,
        "viewers": len(service.viewers),
    }
    if engine.ready and not stopping:
        return JSONResponse(body | {"device": engine.device})
    words = {"text": engine.activity.text, "fraction": engine.activity.fraction}
    return JSONResponse(body | words, 503, {"Retry-After": str(RETRY_SECONDS)})
