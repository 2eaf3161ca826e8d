"""The service: puts the endpoints, the page and the engines together."""

import asyncio
import gc
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from functools import partial
from importlib.metadata import version
from typing import Any

import uvicorn
from fastapi import FastAPI

from gpu.scene.lighting.environment import read_environment
from server import errors
from server.engines import make_engines
from server.http.answers import Answers
from server.http.connections import Connections
from server.http.cors import Cors
from server.http.delivery import Delivery
from server.http.forwarded import Forwarded
from server.http.metered import Meter
from server.http.middleware import BodyLimit, RequestLimit
from server.http.security import HEADERS, Guard, with_token
from server.http.shutdown import CLOSE_SECONDS, Server
from server.http.websocket import WebSocket
from server.jobs import Jobs
from server.render.engine_pool import EnginePool
from server.rest import assign as assign_api
from server.rest import docs, health
from server.rest import export as export_api
from server.rest import films as film_api
from server.rest import jobs as job_api
from server.rest import metrics as monitor
from server.rest import picking as pick_api
from server.rest import render as render_api
from server.rest import scenes as scene_api
from server.rest.joined import PLACE
from server.rest.openapi import describe
from server.rest.pages import FOLDER, Pages
from server.results import FOLDER as RESULTS
from server.scenes.catalogue import Catalogue
from server.scenes.changed_files import ChangedFiles
from server.scenes.checker import CHECK, Checker
from server.scenes.kept_edits import KeptEdits
from server.scenes.uploads import Uploads
from server.service import Service
from server.settings import ServerSettings
from server.walk import stream
from server.walk.viewer import settings_schema

# At the top of the service: the page's files, and what is beside them.
NAMES = {"", "api", "healthz", "readyz", "metrics", PLACE, *(path.name for path in FOLDER.iterdir())}
EXPOSED = ("Location", "Retry-After", "WWW-Authenticate", *render_api.STATISTICS)


def create_app(settings: ServerSettings, engines: EnginePool | None = None, check: Sequence[str] = CHECK) -> FastAPI:
    """The ASGI application; its lifespan runs `engines`, which are those of the settings where none are given.

    check: the command that reads a scene before the worker does.
    Where others than this machine's users can come, it needs a token: a new one if the settings have none. Raises
    UserError when the served scene or the scenes folder does not exist, or the environment cannot be read.
    """
    settings = with_token(settings)
    if settings.environment is not None:
        read_environment(settings.environment)
    checker = Checker(settings, check)
    uploads = Uploads(settings, checker) if settings.uploads else None
    catalogue = Catalogue(settings.scene, settings.scenes_dir, uploads, settings.scene_options)
    engines = engines or make_engines(settings)
    service = Service(settings, catalogue, engines, checker)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        folder = settings.uploads_dir if settings.uploads else None
        results = None if folder is None else folder / RESULTS
        parts: list[EnginePool | Jobs | ChangedFiles | KeptEdits] = [engines, service.jobs, service.changed_files]
        if folder is not None and results is not None:
            service.jobs.restore(results)
            parts.append(KeptEdits(folder, service.edited, catalogue.find))
        tasks = [asyncio.create_task(it.run(), name=type(it).__name__.lower()) for it in parts]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.wait(tasks)
            service.jobs.save(results)
            if uploads is not None:
                uploads.close()

    app = FastAPI(
        title="lumenwalk",
        version=version("lumenwalk"),
        description="Global-illumination walkthroughs: stills over REST, walks over a WebSocket (/api/v1/stream).",
        openapi_url="/api/openapi.json",
        redirect_slashes=False,
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
    )
    app.state.service = service
    service.metrics.registry.register(monitor.State(service))
    _add_middleware(app, service)
    errors.install(app)
    _add_routes(app)
    app.openapi = partial(describe, app, settings)  # type: ignore[method-assign]
    return app


def _add_middleware(app: FastAPI, service: Service) -> None:
    """What each request goes through, from the inside out."""
    settings = service.settings
    app.add_middleware(BodyLimit, max_bytes=settings.max_message_bytes, streamed=(scene_api.router.prefix,))
    app.add_middleware(RequestLimit, service=service)
    app.add_middleware(Guard, settings=settings, metrics=service.metrics)
    if settings.allowed_origins:
        app.add_middleware(Cors, origins=settings.allowed_origins, exposed=EXPOSED)
    app.add_middleware(Answers)
    app.add_middleware(Meter, service=service)
    app.add_middleware(
        Forwarded, root_path=settings.root_path, trusted=settings.trusted_proxies, names=frozenset(NAMES)
    )
    app.add_middleware(Delivery)


def _add_routes(app: FastAPI) -> None:
    stills = (render_api, pick_api, export_api)
    app.router.routes.append(stream.ROUTE)  # the first: others are not asked whether it is them that a crowd wants
    for part in (docs, health, monitor, *stills, scene_api, job_api, film_api, assign_api, stream):
        app.include_router(part.router)
    app.mount("/api/docs/files", docs.swagger)
    app.router.default = Pages()


def server_config(app: FastAPI, settings: ServerSettings) -> uvicorn.Config:
    """How uvicorn runs the application: frames are JPEGs already, so compressing messages would only cost time."""
    connections: Any = Connections(settings, app.state.service.metrics)  # for uvicorn the class of a protocol
    return uvicorn.Config(
        app,
        http=connections,
        host=settings.host,
        port=settings.port,
        log_level="warning",
        log_config=None,
        access_log=False,
        server_header=False,
        headers=list(HEADERS.items()),
        lifespan="on",
        proxy_headers=False,  # Forwarded reads them
        ws=WebSocket,
        ws_ping_interval=settings.keepalive_seconds,
        ws_max_size=settings.max_message_bytes,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=CLOSE_SECONDS,
    )


def create_server(app: FastAPI, settings: ServerSettings) -> Server:
    """The server that runs the application, as of `server_config`."""
    return Server(server_config(app, settings), app.state.service)


def prepare(app: FastAPI) -> None:
    """Do before anybody comes what would hold all up then: FastAPI makes its routes when the first request looks for
    one, a third of a second of a core, and a full collection of garbage looks at all that was imported, a tenth.
    """
    for route in app.routes:
        route.matches({"type": "http", "method": "GET", "path": "/", "root_path": "", "headers": []})
    settings_schema()
    gc.collect()
    gc.freeze()
