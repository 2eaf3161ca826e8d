"""Render jobs: asked for, watched, fetched, cancelled."""

from collections.abc import AsyncGenerator
from typing import Literal

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, Field

from server.errors import WITH_BODY, refusals
from server.jobs import ENDED, JobState, RenderJob
from server.refusals import NotYetError
from server.rest.negotiate import MEDIA_TYPES
from server.rest.requests import RenderRequest
from server.rest.scene_parts import check_parts
from server.rest.server_sent_events import MEDIA_TYPE, event, event_stream
from server.service import TheService
from server.video.film_settings import FILM_TYPE
from server.wire.worker import Output

router = APIRouter(prefix="/api/v1/jobs", responses=refusals())
_ONE = refusals(404, 422)

RESULTS = (*MEDIA_TYPES, FILM_TYPE)
_FORMATS: dict[str, tuple[str, Output]] = {output[1:]: (name, output) for name, output in MEDIA_TYPES.items()}


class JobRequest(RenderRequest):
    """A picture to be rendered in the background."""

    format: Literal["png", "jpg", "exr", "npy"] = Field(default="png", description="of the result")


class JobInfo(BaseModel):
    """How far a job is."""

    id: str
    state: JobState
    progress: float = Field(description="from 0 to 1")
    frames: int = Field(description="that the picture is the mean of, or of all pictures of a film together")
    frames_done: int
    pictures: int = Field(description="of a film; 1 of a still")
    scene: str
    size: tuple[int, int]
    format: str = Field(description="media type of the result")
    error: str = Field(description="why it failed, if it did")
    url: str = Field(description="of the job; its result is at /result below that, its progress at /events")


def describe(job: RenderJob, request: Request) -> JobInfo:
    """A job as clients see it, below the prefix that they ask below."""
    return JobInfo(
        id=job.id,
        state=job.state,
        progress=job.progress,
        frames=job.frames,
        frames_done=job.samples,
        pictures=job.pictures,
        scene=job.render.scene.id,
        size=job.render.size,
        format=job.media_type,
        error=job.error,
        url=f"{request.scope['root_path']}{router.prefix}/{job.id}",
    )


@router.post("", operation_id="addJob", status_code=202, responses=refusals(404, *WITH_BODY))
async def add(wanted: JobRequest, service: TheService, request: Request, response: Response) -> JobInfo:
    """Queue a picture; it is rendered when nobody who walks needs the device."""
    media_type, output = _FORMATS[wanted.format]
    scene = await service.catalogue.look_up(wanted.scene, wanted.scene_options)
    service.settings.check_render(wanted.size, wanted.settings, service.settings.max_pixels)
    edits, frames = await service.edits_of(scene, wanted.edits), wanted.frames()[0]
    render = wanted.render(service.number(), scene, output, edits)
    service.check_cost(render, frames)
    await check_parts(service, scene, render.view, wanted.edits)
    job = service.jobs.add(render, frames, media_type)
    told = describe(job, request)
    response.headers["Location"] = told.url
    return told


@router.get("", operation_id="listJobs")
async def jobs(service: TheService, request: Request) -> list[JobInfo]:
    """All jobs that are not forgotten yet, the oldest first."""
    return [describe(job, request) for job in service.jobs.all]


@router.get("/{job_id}", operation_id="describeJob", responses=_ONE)
async def job(job_id: str, service: TheService, request: Request) -> JobInfo:
    """How far a job is."""
    return describe(service.jobs.find(job_id), request)


@router.get(
    "/{job_id}/result",
    operation_id="getResult",
    response_class=Response,
    responses=refusals(404, 409, 422)
    | {200: {"content": {name: {"schema": {"type": "string", "format": "binary"}} for name in RESULTS}}},
)
async def result(job_id: str, service: TheService) -> Response:
    """The picture or film; 409 before it is done, or when it will not be."""
    found = service.jobs.find(job_id)
    if found.state is not JobState.DONE:
        why = f": {found.error}" if found.error else ""
        raise NotYetError(f"job {job_id} has no result: it is {found.state}{why}")
    return Response(found.result, media_type=found.media_type)


@router.get(
    "/{job_id}/events",
    operation_id="watchJob",
    response_class=Response,
    responses=_ONE | {200: {"content": {MEDIA_TYPE: {}}}},
)
async def events(job_id: str, service: TheService, request: Request) -> Response:
    """What happens to a job, as server-sent events: `progress` each time, and `end`, both with the job as data."""
    found = service.jobs.find(job_id)

    async def told() -> AsyncGenerator[str]:
        async for now in service.jobs.watch(found):
            yield event("end" if now.state in ENDED else "progress", describe(now, request))

    return event_stream(told(), service)


@router.delete("/{job_id}", operation_id="removeJob", responses=refusals(404, *WITH_BODY))
async def remove(job_id: str, service: TheService, request: Request) -> JobInfo:
    """Cancel a job that waits or runs, and forget it with its result."""
    return describe(service.jobs.remove(job_id), request)
