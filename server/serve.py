"""Runs the service: its workers first, which take longest to be there, then all that serves."""

import logging
import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Protocol, TextIO

from gpu.errors import UserError
from server.engines import make_engines
from server.http.accepting import listen
from server.importing import kept_imports
from server.logs import configure, has_room
from server.render.activity import Activity, EngineState
from server.render.engine_pool import EnginePool
from server.render.worker_process import WORKER, WorkerProcess
from server.settings import ServerSettings, unknown_names

log = logging.getLogger("lumenwalk.server")
WILDCARDS = {"0.0.0.0": "127.0.0.1", "::": "::1"}  # listened on for all addresses, which none is


class Ending(Protocol):
    """A server of uvicorn's, which is imported later."""

    should_exit: bool


def serve(settings: ServerSettings, worker: Sequence[str] = WORKER, first: WorkerProcess | None = None) -> None:
    """Run the service until SIGINT, SIGTERM or SIGHUP; prints its URL on stdout once a frame can be had.

    worker: the command that starts one; first: one that runs already. Raises UserError when it cannot listen, or when
    the served scene or the device cannot be used.
    """
    configure(settings.log_format)
    for name in unknown_names(os.environ):
        log.warning("%s of the environment is no setting; check its name", name)
    with listen(settings.host, settings.port) as listener:
        engines = make_engines(settings, worker)
        with engines.early(first):
            with kept_imports():
                from server.app import create_app, create_server, prepare
                from server.http.connections import raise_file_limit
                from server.http.security import with_token
                from server.http.sparse_log import make_sparse

            make_sparse()
            raise_file_limit()
            made = settings.token is None
            settings = with_token(settings)
            app = create_app(settings, engines)
            prepare(app)
            url = _url(settings, listener.getsockname()[1], with_token=made)
            server = create_server(app, settings)
            if signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:  # which `nohup` has changed
                signal.signal(signal.SIGHUP, server.handle_exit)  # a terminal is closed
            engines.listeners.add(_announcer(engines, server, url))
            with suppress(KeyboardInterrupt):
                server.run(sockets=[listener])
    if engines.activity.state is EngineState.FAILED:
        raise UserError(engines.activity.text)


def _announcer(engines: EnginePool, server: Ending, url: str) -> Callable[[], None]:
    told = Activity(EngineState.STARTING)
    announced = False

    def announce() -> None:
        nonlocal told, announced
        activity = engines.activity
        if activity.state is EngineState.FAILED:
            server.should_exit = True
        elif server.should_exit:
            pass  # the worker goes because the service does
        elif activity.state is EngineState.READY and not announced:
            announced = True
            _say(url, sys.stdout)
        elif activity.text and (activity.state, activity.text) != (told.state, told.text) and not engines.ready:
            _say(f"lumenwalk: {activity.text}", sys.stderr)
        told = activity

    return announce


def _say(text: str, to: TextIO) -> None:
    """Print a line, unless nobody reads it, or its file has no room: that is no fault of the engine that is heard."""
    if has_room(to):
        with suppress(OSError):
            print(text, file=to, flush=True)


def _url(settings: ServerSettings, port: int, *, with_token: bool) -> str:
    """Where a browser of this machine finds the page."""
    host = WILDCARDS.get(settings.host, settings.host)
    url = f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"
    url += f"{settings.root_path}/" if settings.root_path else ""
    if with_token and settings.token is not None:  # said here, once, and nowhere else
        url = f"{url.rstrip('/')}/?token={settings.token.get_secret_value()}"
    return url
