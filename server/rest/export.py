"""/scenes/ID/export.glb: a scene as a file, with its edits in it."""

from pathlib import Path
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import APIRouter, Query, Response

from gpu.scene.edits import SceneEdits
from server.errors import WITH_BODY, refusals
from server.places import asker
from server.refusals import ForbiddenError
from server.render.schedule import Urgency
from server.render.worker_link import WorkerLostError
from server.rest.scene_paths import ABOVE
from server.rest.scenes import Reading
from server.scenes.uploads import EXPORT
from server.service import Service, TheService
from server.wire.browser import SceneId
from server.wire.worker import STILLS, Export

GLB = "model/gltf-binary"
FILE: dict[int | str, Any] = {200: {"content": {GLB: {"schema": {"type": "string", "format": "binary"}}}}}

router = APIRouter(prefix="/api/v1/scenes")


@router.get(
    f"{ABOVE}{EXPORT}",
    operation_id="exportScene",
    response_class=Response,
    responses=refusals(404, 422, 507) | FILE,
)
async def export(scene_id: SceneId, service: TheService, reading: Annotated[Reading, Query()]) -> Response:
    """The scene as it is edited now, as a GLB file in metres with +Y up; 403 unless this service gives scenes out.

    It is loaded for that. Skies and animations stay out. The parameters say how its file is read, as for a scene.
    """
    return await _file(scene_id, service, reading, None)


@router.post(
    f"{ABOVE}{EXPORT}",
    operation_id="exportEditedScene",
    response_class=Response,
    responses=refusals(404, 507, *WITH_BODY) | FILE,
)
async def export_edited(
    scene_id: SceneId, edits: SceneEdits, service: TheService, reading: Annotated[Reading, Query()]
) -> Response:
    """As GET, with the edits of the body, all that differs from the scene's file, instead of what all see."""
    return await _file(scene_id, service, reading, edits)


async def _file(scene_id: str, service: Service, reading: Reading, edits: SceneEdits | None) -> Response:
    if not service.settings.exports:
        raise ForbiddenError("this server gives no scenes out; its option --exports allows that")
    with service.exporting.taken(asker.get()):
        ref = await service.catalogue.look_up(scene_id, reading.options)
        if not service.engines.ready:
            raise WorkerLostError(f"the renderer is not ready: {service.engines.activity.text}")
        await service.residency.open(ref)
        job = Export(ref, await service.edits_of(ref, edits))
        _, file = await service.engines.ask(STILLS, job, Urgency.REFINING, service.settings.max_wait_seconds)
    name = f"attachment; filename*=UTF-8''{quote(Path(scene_id).stem)}.glb"
    return Response(file, media_type=GLB, headers={"Content-Disposition": name})
