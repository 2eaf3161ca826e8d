"""The service: puts the endpoints, the page and the engine together, and runs them."""

import asyncio
import logging
import socket
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from errno import EADDRINUSE
from importlib.metadata import version

import uvicorn
from fastapi import FastAPI

from gpu.errors import UserError
from server import errors, health, monitor, rest, stream
from server.engine import WORKER, Activity, Engine, EngineState
from server.middleware import BodyLimit
from server.pages import Pages
from server.scenes import Catalogue
from server.service import Service, start_message
from server.settings import ServerSettings

STOP_SECONDS = 5


def create_app(settings: ServerSettings, worker: Sequence[str] = WORKER) -> FastAPI:
    """The ASGI application; its lifespan runs the worker process, started by the command `worker`.

    Raises UserError when the served scene or the scenes folder does not exist.
    """
    catalogue = Catalogue(settings.scene, settings.scenes_dir)
    service = Service(settings, catalogue, Engine(start_message(settings, catalogue), worker))

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        engine = asyncio.create_task(service.engine.run(), name="engine")
        try:
            yield
        finally:
            engine.cancel()
            with suppress(asyncio.CancelledError):
                await engine

    app = FastAPI(
        title="lumenwalk",
        version=version("lumenwalk"),
        description="Global-illumination walkthroughs: stills over REST, walks over a WebSocket (/api/v1/stream).",
        openapi_url="/api/openapi.json",
        docs_url="/api/docs",
        redoc_url=None,
        lifespan=lifespan,
    )
    app.state.service = service
    service.metrics.registry.register(monitor.State(service))
    app.add_middleware(BodyLimit, max_bytes=settings.max_message_bytes)
    errors.install(app)
    for router in (health.router, monitor.router, rest.router, stream.router):
        app.include_router(router)
    app.mount("/", Pages())
    return app


def server_config(app: FastAPI, settings: ServerSettings) -> uvicorn.Config:
    """How uvicorn runs the application: frames are JPEGs already, so compressing messages would only cost time."""
    return uvicorn.Config(
        app,
        host=settings.host,
        port=settings.port,
        log_level="warning",
        access_log=False,
        lifespan="on",
        ws="websockets-sansio",
        ws_max_size=settings.max_message_bytes,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=STOP_SECONDS,
    )


def serve(settings: ServerSettings, worker: Sequence[str] = WORKER) -> None:
    """Run the service until SIGINT or SIGTERM; prints its URL on stdout once a frame can be had.

    Raises UserError when it cannot listen, or when the served scene or the device cannot be used.
    """
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    app = create_app(settings, worker)
    engine = app.state.service.engine
    with _listen(settings.host, settings.port) as listener:
        host = f"[{settings.host}]" if ":" in settings.host else settings.host
        url = f"http://{host}:{listener.getsockname()[1]}"
        server = uvicorn.Server(server_config(app, settings))
        engine.listeners.add(_announcer(engine, server, url))
        with suppress(KeyboardInterrupt):
            server.run(sockets=[listener])
    if engine.activity.state is EngineState.FAILED:
        raise UserError(engine.activity.text)


def _announcer(engine: Engine, server: uvicorn.Server, url: str) -> Callable[[], None]:
    told = Activity(EngineState.STARTING)
    announced = False

    def announce() -> None:
        nonlocal told, announced
        activity = engine.activity
        if activity.state is EngineState.FAILED:
            server.should_exit = True
        elif server.should_exit:
            pass  # the worker goes because the service does
        elif activity.state is EngineState.READY and not announced:
            announced = True
            print(url, flush=True)
        elif activity.text and (activity.state, activity.text) != (told.state, told.text) and not engine.ready:
            print(f"lumenwalk: {activity.text}", file=sys.stderr, flush=True)
        told = activity

    return announce


def _listen(host: str, port: int) -> socket.socket:
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        return socket.create_server(address[:2], family=family, backlog=2048)
    except OSError as error:
        if error.errno == EADDRINUSE:
            raise UserError(f"port {port} of {host} is in use: stop what uses it, or choose another port") from None
        raise UserError(f"cannot listen on {host}, port {port}: {error.strerror or error}") from None
