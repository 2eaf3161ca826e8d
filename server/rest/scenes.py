"""Scenes: listed, described, uploaded, loaded, edited, unloaded, deleted."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import suppress
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import APIRouter, Header, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from gpu.errors import UserError
from gpu.scene.edits import SceneEdits
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.load import SUFFIXES
from gpu.settings import RenderSettings
from server.errors import EXPECTED, WITH_BODY, error_body, refusals
from server.places import asker
from server.refusals import ForbiddenError, InUseError, UnknownSceneError
from server.render.worker_link import WorkerLostError
from server.rest.scene_paths import ABOVE, SCENE
from server.rest.server_sent_events import MEDIA_TYPE, event, event_stream, wants_events
from server.scenes.checked import SceneSize
from server.scenes.uploads import ARCHIVE, Uploads
from server.service import Service, TheService
from server.wire.browser import SceneId, SceneInfo, SceneName, ScenePatch
from server.wire.worker import SceneRef

router = APIRouter(prefix="/api/v1/scenes", responses=refusals())
LISTED_AT_ONCE = 100  # scenes, of which each is looked at on the disk
EXAMPLE = ", ".join((*SUFFIXES, ARCHIVE))


class Reading(ImportOptions):
    """How a file is read, as parameters of an address, which may have others."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    @property
    def options(self) -> ImportOptions | None:
        """What is said of it; None where nothing is."""
        said = self.model_fields_set & set(ImportOptions.model_fields)
        return ImportOptions(**self.model_dump(include=said)) if said else None


class UploadQuery(Reading):
    """What is said of an upload."""

    name: str = Field(max_length=1024, description=f"what the file is called: one of {EXAMPLE}")


class SceneListing(SceneName):
    """A scene that can be chosen, and where it stands."""

    uploaded: bool = Field(description="by a client; can be deleted")
    loaded: bool = Field(description="is on the device")
    viewed: bool = Field(description="somebody looks at it, or a job renders it: it cannot be unloaded or deleted")
    bytes: int | None = Field(description="of its file, or of all files of an upload; null for a built-in scene")
    device_bytes: int | None = Field(description="that it is expected to take on the device, once its file was read")


_listings = TypeAdapter(list[SceneListing])


class SceneDetails(SceneListing):
    """What is in a scene, and what can be chosen of its renders."""

    scene: SceneInfo
    edits: SceneEdits = Field(description="what differs from its file now")
    size: SceneSize
    settings_schema: dict[str, Any] = Field(description="JSON schema of `settings` in a render request")


class Progress(BaseModel):
    """What the service is doing, and how far it is, from 0 to 1."""

    text: str
    fraction: float


class Loaded(SceneListing):
    """A scene on the device, and the device's memory [bytes]; memory_total is 0 where it is not known."""

    scene: SceneInfo
    memory_used: int
    memory_total: int


def _listing(service: Service, name: SceneName, ref: SceneRef) -> SceneListing:
    return SceneListing(
        **name.model_dump(),
        uploaded=service.catalogue.uploaded(name.id),
        loaded=service.residency.holds(ref),
        viewed=service.in_use(ref.id),
        bytes=service.catalogue.file_bytes(ref),
        device_bytes=service.residency.bytes_of(ref),
    )


def _named(service: Service, ref: SceneRef) -> SceneListing:
    name = service.catalogue.name(ref.id)
    if name is not None:
        return _listing(service, name, ref)
    raise UnknownSceneError(f"scene: {ref.id!r} has gone meanwhile; uploads make room for newer ones")


async def _details(service: Service, ref: SceneRef) -> SceneDetails:
    checked = await service.residency.inspect(ref)
    return SceneDetails(
        **_named(service, ref).model_dump(),
        scene=checked.info,
        edits=service.edited.of(ref),
        size=checked.size,
        settings_schema=RenderSettings.model_json_schema(),
    )


@router.get("", operation_id="listScenes", response_model=list[SceneListing])
async def scenes(service: TheService) -> Response:
    """The scenes that can be chosen, the served one first."""
    await service.catalogue.refresh()
    listed = []
    for name, ref in service.catalogue.found():
        listed.append(_listing(service, name, ref))
        if len(listed) % LISTED_AT_ONCE == 0:
            await asyncio.sleep(0)  # others have a turn
    return Response(await asyncio.to_thread(_listings.dump_json, listed), media_type="application/json")


@router.post(
    "",
    operation_id="uploadScene",
    status_code=201,
    responses=refusals(404, 507, *WITH_BODY),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def upload(
    request: Request,
    service: TheService,
    response: Response,
    query: Annotated[UploadQuery, Query()],
) -> SceneDetails:
    """Bring a scene: the file as the request's body. It is read and checked before this is answered.

    A .zip holds one scene and the files that it refers to. The other parameters say how it is read from now on. What
    a client brings again by the same name is another scene, with those edits of the one before that fit it.
    """
    if request.headers.get("content-type", "").lower().startswith("multipart/"):
        raise UserError("body: is a form; send the file itself, as curl does with --data-binary @house.glb")
    length = request.headers.get("content-length", "")
    known_length = int(length) if length.isdecimal() else None
    with service.uploading.taken(asker.get()):  # one client must not take all places
        added = await _uploads(service).add(
            query.name, known_length, request.stream(), service.in_use, query.options or DEFAULT_OPTIONS
        )
    ref = service.catalogue.find(added.id)
    service.residency.learn(ref, added.checked)
    before = _uploads(service).before(added.id)
    if before is not None and before.options == added.options:
        with suppress(UnknownSceneError):  # whose file somebody may have taken away
            service.edited.take_over(service.catalogue.find(before.id), ref)
    await service.residency.free_lost()
    response.headers["Location"] = f"{request.scope['root_path']}{router.prefix}/{quote(ref.id)}"
    return await _details(service, ref)


@router.post(
    f"{ABOVE}/load",
    operation_id="loadScene",
    responses=refusals(404, 507, *WITH_BODY) | {200: {"content": {MEDIA_TYPE: {}}}},
    response_model=Loaded,
)
async def load(
    scene_id: SceneId, service: TheService, accept: Annotated[str | None, Header(include_in_schema=False)] = None
) -> Any:
    """Put a scene on the device, if there is room.

    With `Accept: text/event-stream` it is answered by events: `progress` with text and fraction, then either `end`
    with what is otherwise the answer, or `error` with code and message.
    """
    ref = await service.catalogue.look_up(scene_id)
    _check_ready(service)
    if wants_events(accept):
        return event_stream(_load_events(service, ref), service)
    return await _load(service, ref)


@router.post(f"{ABOVE}/unload", operation_id="unloadScene", responses=refusals(404, 409, *WITH_BODY))
async def unload(scene_id: SceneId, service: TheService) -> SceneListing:
    """Free what a scene takes on the device; 409 while somebody looks at it."""
    ref = await service.catalogue.look_up(scene_id)
    _check_ready(service)
    _check_idle(service, ref)
    await service.residency.close(ref)
    return _named(service, ref)


@router.get(SCENE, operation_id="describeScene", responses=refusals(404, 422))
async def scene(scene_id: SceneId, service: TheService, reading: Annotated[Reading, Query()]) -> SceneDetails:
    """A scene's cameras, bounds, sizes and notes; it is read for that, in a process of its own, but not loaded.

    The parameters say how it is read; without any, it is as the service does.
    """
    return await _details(service, await service.catalogue.look_up(scene_id, reading.options))


@router.patch(SCENE, operation_id="editScene", responses=refusals(404, 507, *WITH_BODY))
async def edit(
    scene_id: SceneId, patch: ScenePatch, request: Request, service: TheService, reading: Annotated[Reading, Query()]
) -> SceneEdits:
    """Change a scene for all who look at it, from the next frame on: its lights, materials and objects, and the moment
    of its animations; it is loaded for that.

    The body is a JSON Merge Patch (RFC 7396) of the scene's `edits`: what it names changes, null takes an edit back.
    The answer is all that differs from the file then. A patch with a mistake changes nothing. The parameters say how
    the file is read, as for GET.
    """
    service.check_edits(asker.get())
    ref = await service.catalogue.look_up(scene_id, reading.options)
    _check_ready(service)
    return service.edited.change(ref, await service.residency.open(ref), patch)


@router.delete(SCENE, operation_id="deleteScene", status_code=204, responses=refusals(404, 409, *WITH_BODY))
async def delete(scene_id: SceneId, service: TheService) -> None:
    """Delete an uploaded scene; 403 for others, 409 while somebody looks at it."""
    ref = await service.catalogue.look_up(scene_id)
    if not service.catalogue.uploaded(scene_id):
        raise ForbiddenError(f"{scene_id}: was not uploaded, so it is not for clients to delete")
    _check_idle(service, ref)
    await _uploads(service).remove(scene_id)
    await service.residency.free_lost()


async def _load(service: Service, ref: SceneRef) -> Loaded:
    info = await service.residency.open(ref)
    used, total = service.engines.memory
    return Loaded(**_named(service, ref).model_dump(), scene=info, memory_used=used, memory_total=total)


async def _load_events(service: Service, ref: SceneRef) -> AsyncGenerator[str]:
    news = asyncio.Event()
    service.engines.listeners.add(news.set)
    task = asyncio.create_task(_load(service, ref))
    task.add_done_callback(lambda _: news.set())
    try:
        yield event("progress", Progress(text=f"checking {ref.id}", fraction=0.0))
        while not task.done():
            await news.wait()
            news.clear()
            activity = service.engines.activity
            if activity.text:
                yield event("progress", Progress(text=activity.text, fraction=activity.fraction))
        try:
            yield event("end", task.result())
        except EXPECTED as error:
            yield event("error", error_body(error))
    finally:
        service.engines.listeners.discard(news.set)
        task.cancel()


def _uploads(service: Service) -> Uploads:
    if service.catalogue.uploads is None:
        raise ForbiddenError("this server takes no uploads; put the file into its scenes folder")
    return service.catalogue.uploads


def _check_ready(service: Service) -> None:
    if not service.engines.ready:
        raise WorkerLostError(f"the renderer is not ready: {service.engines.activity.text}")


def _check_idle(service: Service, ref: SceneRef) -> None:
    if service.in_use(ref.id):
        raise InUseError(f"{ref.id}: somebody looks at it, or a job renders it; try again when they have left")
