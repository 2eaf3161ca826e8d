"""POST /render: a picture, at once."""

import json
from time import monotonic
from typing import Annotated

from fastapi import APIRouter, Header, Response

from gpu.errors import UserError
from server.errors import WITH_BODY, refusals
from server.places import asker
from server.render.schedule import Urgency
from server.render.stills import render_frames
from server.render.worker_link import WorkerLostError
from server.rest.negotiate import MEDIA_TYPES, choose_format
from server.rest.requests import RenderRequest
from server.service import Service, TheService
from server.wire.worker import STILLS, Done, Render

MAX_FRAMES = 64
# Headers of an answer: JSON, and milliseconds.
STATISTICS = tuple(
    f"X-Lumenwalk-{name}" for name in ("Stage-Ms", "Counts", "Skips", "Estimates", "Render-Ms", "Encode-Ms", "Queue-Ms")
)
router = APIRouter(prefix="/api/v1", responses=refusals(404, 406, 507, *WITH_BODY))


@router.post(
    "/render",
    operation_id="renderStill",
    response_class=Response,
    responses={200: {"content": {name: {"schema": {"type": "string", "format": "binary"}} for name in MEDIA_TYPES}}},
)
async def render(
    request: RenderRequest, service: TheService, accept: Annotated[str | None, Header(include_in_schema=False)] = None
) -> Response:
    """Render a picture in the format that Accept asks for; statistics (JSON, milliseconds) are in X-Lumenwalk-*."""
    media_type, output = choose_format(accept)
    scene = await service.catalogue.look_up(request.scene, request.scene_options)
    service.settings.check_render(request.size, request.settings, service.settings.max_pixels)
    frames = request.frames()[0]
    if (weight := request.weight()) > MAX_FRAMES:
        raise UserError(
            f"settings: the work of {weight} frames, more than the {MAX_FRAMES} that are rendered at once; "
            "POST it to /api/v1/jobs instead"
        )
    # Frames that are averaged are kept by viewer number; a lone one needs no number of its own.
    job = request.render(
        STILLS if frames == 1 else service.number(), scene, output, await service.edits_of(scene, request.edits)
    )
    service.check_cost(job, frames)
    began = monotonic()
    done, image = await _still(service, job, frames)
    total_ms = 1e3 * (monotonic() - began)
    figures = (
        json.dumps({name: round(ms, 3) for name, ms in done.stage_ms.items()}),
        json.dumps(done.counts),
        json.dumps(done.skips),
        json.dumps(done.estimates),
        f"{done.render_ms:.3f}",
        f"{done.encode_ms:.3f}",
        f"{max(total_ms - done.render_ms - done.encode_ms, 0.0):.3f}",
    )
    return Response(image, media_type=media_type, headers=dict(zip(STATISTICS, figures, strict=True)))


async def _still(service: Service, job: Render, frames: int) -> tuple[Done, bytes]:
    if not service.engines.ready:
        raise WorkerLostError(f"the renderer is not ready: {service.engines.activity.text}")
    try:
        with service.stills.taken(asker.get()):
            await service.residency.open(job.scene, job.viewer)
            wait = service.settings.max_wait_seconds
            return await render_frames(service.engines, job, frames, Urgency.STILL, turn_seconds=wait)
    finally:
        if job.viewer != STILLS:
            service.dismiss(job.viewer)
