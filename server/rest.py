"""The REST endpoints: stills and the list of scenes."""

import asyncio
import json
import math
from time import monotonic
from typing import Annotated, Any

from fastapi import APIRouter, Header, Response
from pydantic import BaseModel, ConfigDict, Discriminator, Field, FiniteFloat, StrictInt, Tag, field_validator

from gpu.settings import RenderSettings
from server.errors import ErrorBody, TooBusyError
from server.link import WorkerLostError
from server.messages import STILLS, Done, LookAt, Placed, Render, SceneCamera, View
from server.negotiate import MEDIA_TYPES, choose_format
from server.protocol import Matrix, SceneId, SceneInfo, SceneName, Size, check_rigid
from server.schedule import Urgency
from server.service import Service, TheService

router = APIRouter(prefix="/api/v1", responses={code: {"model": ErrorBody} for code in (404, 406, 413, 422, 429, 503)})

Vector = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Degrees = Annotated[float, Field(gt=0.5, lt=178.0, description="vertical field of view [°]")]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class LookAtCamera(_Strict):
    """A view from a point towards another, in the scene's own space."""

    position: Vector
    target: Vector
    up: Vector = (0.0, 1.0, 0.0)
    yfov_degrees: Degrees = 60.0


class MatrixCamera(_Strict):
    """A view by its camera-to-world matrix: 16 numbers, column after column, looking along −Z with +Y up."""

    matrix: Matrix
    yfov_degrees: Degrees = 60.0

    @field_validator("matrix")
    @classmethod
    def _rigid(cls, matrix: tuple[float, ...]) -> tuple[float, ...]:
        check_rigid(matrix)
        return matrix


def _camera_form(camera: Any) -> str:
    if isinstance(camera, str):
        return "name"
    if isinstance(camera, dict):
        return "matrix" if "matrix" in camera else "look-at"
    if isinstance(camera, MatrixCamera):
        return "matrix"
    return "look-at" if isinstance(camera, LookAtCamera) else "index"


CameraChoice = Annotated[
    Annotated[StrictInt, Tag("index"), Field(ge=0)]
    | Annotated[str, Tag("name"), Field(max_length=512)]
    | Annotated[LookAtCamera, Tag("look-at")]
    | Annotated[MatrixCamera, Tag("matrix")],
    Discriminator(_camera_form),
]


class RenderRequest(_Strict):
    """A still; what is left out gets its default."""

    scene: SceneId | None = Field(default=None, description="scene id; the served scene when not given")
    camera: CameraChoice = Field(default=0, description="one of the scene's by index or name, or one of your own")
    size: Size = Field(default=(1280, 720), description="width and height [px]")
    settings: RenderSettings = Field(default=RenderSettings(), description="method and quality")

    def view(self) -> View:
        """The camera as the worker takes it."""
        match self.camera:
            case LookAtCamera(position=position, target=target, up=up, yfov_degrees=yfov):
                return LookAt(position, target, up, yfov)
            case MatrixCamera(matrix=matrix, yfov_degrees=yfov):
                return Placed(matrix, math.radians(yfov))
            case camera:
                return SceneCamera(camera)


class SceneDetails(BaseModel):
    """What is in a scene, and what can be chosen of its renders."""

    scene: SceneInfo
    settings_schema: dict[str, Any] = Field(description="JSON schema of `settings` in a render request")


@router.post(
    "/render",
    response_class=Response,
    responses={200: {"content": {name: {"schema": {"type": "string", "format": "binary"}} for name in MEDIA_TYPES}}},
)
async def render(
    request: RenderRequest, service: TheService, accept: Annotated[str | None, Header()] = None
) -> Response:
    """Render a picture in the format that Accept asks for; statistics (JSON, milliseconds) are in X-Lumenwalk-*."""
    media_type, output = choose_format(accept)
    scene = service.catalogue.find(request.scene)
    service.settings.check_render(request.size, request.settings, service.settings.max_pixels)
    job = Render(STILLS, scene, request.view(), request.size, request.settings, output)
    began = monotonic()
    done, image = await _still(service, job)
    total_ms = 1e3 * (monotonic() - began)
    headers = {
        "Stage-Ms": json.dumps({name: round(ms, 3) for name, ms in done.stage_ms.items()}),
        "Counts": json.dumps(done.counts),
        "Skips": json.dumps(done.skips),
        "Render-Ms": f"{done.render_ms:.3f}",
        "Encode-Ms": f"{done.encode_ms:.3f}",
        "Queue-Ms": f"{max(total_ms - done.render_ms - done.encode_ms, 0.0):.3f}",
    }
    return Response(image, media_type=media_type, headers={f"X-Lumenwalk-{name}": it for name, it in headers.items()})


async def _still(service: Service, job: Render) -> tuple[Done, bytes]:
    if not service.engine.ready:
        raise WorkerLostError(f"the renderer is not ready: {service.engine.activity.text}")
    if service.stills_waiting >= service.settings.max_waiting_renders:
        raise TooBusyError(f"{service.stills_waiting} renders are waiting already; try again later")
    service.stills_waiting += 1
    try:
        async with asyncio.timeout(service.settings.max_wait_seconds), service.still_turn:
            reply = await service.engine.submit(STILLS, Urgency.STILL, lambda: job)
    except TimeoutError:
        raise WorkerLostError(f"no turn within {service.settings.max_wait_seconds:g} s; try again later") from None
    finally:
        service.stills_waiting -= 1
    if reply is None:
        raise WorkerLostError("the renderer was lost; it is being started again")
    done, image = await reply
    assert isinstance(done, Done)
    return done, image


@router.get("/scenes")
async def scenes(service: TheService) -> list[SceneName]:
    """The scenes that can be chosen, the served one first."""
    return list(service.catalogue.names())


@router.get("/scenes/{scene_id:path}")
async def scene(scene_id: SceneId, service: TheService) -> SceneDetails:
    """A scene's cameras, bounds and notes; it is loaded for that."""
    ref = service.catalogue.find(scene_id)
    if not service.engine.ready:
        raise WorkerLostError(f"the renderer is not ready: {service.engine.activity.text}")
    info = await service.catalogue.open(ref, service.engine)
    return SceneDetails(scene=info, settings_schema=RenderSettings.model_json_schema())
