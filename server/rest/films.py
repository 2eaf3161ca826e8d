"""Films along camera paths, rendered as jobs."""

import asyncio

from fastapi import APIRouter, Request, Response
from pydantic import ConfigDict, Field

from server.errors import WITH_BODY, refusals
from server.render.films import Film
from server.rest.jobs import JobInfo, describe
from server.rest.requests import PictureRequest
from server.rest.scene_parts import check_info, info_of
from server.service import TheService
from server.video.film_file import check_film
from server.video.film_settings import FILM_TYPE, FilmSettings
from server.wire.camera_path import CameraPathSpec
from server.wire.worker import Render

router = APIRouter(prefix="/api/v1/films", responses=refusals())


class FilmRequest(PictureRequest):
    """A film to be rendered in the background; each picture is as a still with the same settings."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "path": {"keyframes": [{"time": 0, "camera": 0}, {"time": 2, "camera": 1}]},
                    "size": [64, 36],
                    "settings": {"frames": 4},
                }
            ]
        }
    )

    path: CameraPathSpec = Field(description="the way of the camera")
    film: FilmSettings = FilmSettings()


@router.post("", operation_id="addFilm", status_code=202, responses=refusals(404, *WITH_BODY))
async def add(wanted: FilmRequest, service: TheService, request: Request, response: Response) -> JobInfo:
    """Queue a film, which is a job like others: /api/v1/jobs tells how far it is and has the MP4 when it is done."""
    await asyncio.to_thread(check_film, wanted.size, wanted.film.codec)
    views = wanted.path.views(wanted.film.fps)
    scene = await service.catalogue.look_up(wanted.scene, wanted.scene_options)
    service.settings.check_render(wanted.size, wanted.settings, service.settings.max_pixels)
    frames, settings = wanted.frames()
    edits = await service.edits_of(scene, wanted.edits)
    render = Render(service.number(), scene, views[0], wanted.size, settings, "rgb", edits=edits)
    service.check_cost(render, frames, len(views))
    info = await info_of(service, scene)
    check_info(info, views[0], wanted.edits)
    animations = {animation.id: animation.seconds for animation in info.animations}
    film = Film(views, wanted.film, service.settings.job_results_bytes, animations)
    told = describe(service.jobs.add(render, frames, FILM_TYPE, film), request)
    response.headers["Location"] = told.url
    return told
