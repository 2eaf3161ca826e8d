"""GET /scenes/ID/export.glb: a scene as a file, with its edits in it."""

from pathlib import Path
from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Query, Request, Response
from pydantic import Field, Json

from gpu.scene.edits import SceneEdits
from server.errors import refusals
from server.places import asker
from server.refusals import ForbiddenError
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.rest.scene_paths import ABOVE
from server.rest.scenes import Reading
from server.scenes.uploads import EXPORT
from server.service import TheService
from server.wire.browser import SceneId
from server.wire.worker import STILLS, Export

GLB = "model/gltf-binary"


class ExportQuery(Reading):
    """How the scene is read, and what differs of it."""

    edits: Json[SceneEdits] | None = Field(None, description="all that differs of it, as JSON, instead of what all see")


router = APIRouter(prefix="/api/v1/scenes", responses=refusals(404, 422, 507))


@router.get(
    f"{ABOVE}{EXPORT}",
    operation_id="exportScene",
    response_class=Response,
    responses={200: {"content": {GLB: {"schema": {"type": "string", "format": "binary"}}}}},
)
async def export(
    scene_id: SceneId, request: Request, service: TheService, query: Annotated[ExportQuery, Query()]
) -> Response:
    """The scene as it is edited now, as a GLB file in metres with +Y up; 403 unless this service gives scenes out.

    It is loaded for that. Skies and animations stay out. The parameters say how its file is read, as for GET, and what
    differs of it, where that is not what all see.
    """
    if not service.settings.exports:
        raise ForbiddenError("this server gives no scenes out; its option --exports allows that")
    with service.exporting.taken(asker.get()):
        ref = await service.catalogue.look_up(scene_id, query.options)
        if not service.engines.ready:
            raise WorkerLostError(f"the renderer is not ready: {service.engines.activity.text}")
        await service.residency.open(ref)
        job = Export(ref, service.edits_of(ref, query.edits))
        _, file = await service.engines.ask(STILLS, job, Urgency.REFINING, service.settings.max_wait_seconds)
    name = f"attachment; filename*=UTF-8''{quote(Path(scene_id).stem)}.glb"
    return Response(file, media_type=GLB, headers={"Content-Disposition": name})
