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


@router.get("/readyz", responses={503: {"description": "kernels are being loaded, or the renderer is started again"}})
async def readyz(service: TheService) -> JSONResponse:
    """200 once kernels are loaded and a frame was rendered; 503 with what is going on before, and while recovering."""
    engine = service.engine
    body: dict[str, Any] = {
        "status": engine.activity.state,
        "restarts": engine.restarts,
        "viewers": len(service.viewers),
    }
    if engine.ready:
        return JSONResponse(body | {"device": engine.device})
    words = {"text": engine.activity.text, "fraction": engine.activity.fraction}
    return JSONResponse(body | words, 503, {"Retry-After": str(RETRY_SECONDS)})
