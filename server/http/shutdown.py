"""How the service ends: viewers are told, what is being rendered for REST finishes, and in any case it is soon over."""

import asyncio
import logging
import os
import socket
import threading
from contextlib import suppress
from functools import partial
from typing import Any

import uvicorn

from server.http.accepting import accept_all
from server.service import Service

# With the time that the worker gets (server.render.worker_link) these stay below the ten seconds that most supervisors
# wait.
DRAIN_SECONDS = 4.0  # for viewers to be told and stills to finish
CLOSE_SECONDS = 1  # for what is left to be sent
END_SECONDS = 9.5  # then the process ends, whatever holds it
log = logging.getLogger("lumenwalk.server")


class Server(uvicorn.Server):
    """uvicorn's server with an end in order. Until it is drained it still answers, so that supervisors see it stop."""

    def __init__(self, config: uvicorn.Config, service: Service) -> None:
        super().__init__(config)
        self._service = service
        self._accepting: list[asyncio.Task[None]] = []

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Take in connections of these sockets. uvicorn is told of none of them: it would take in many at once, each of
        which has a descriptor before it is counted.
        """
        await super().startup([])
        make: Any = self.config.http_protocol_class
        protocol = partial(make, self.config, self.server_state, self.lifespan.state)
        self._accepting = [asyncio.create_task(accept_all(it, protocol)) for it in sockets or ()]

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Tell everyone, wait a little, then close what is left. A second signal ends the waiting."""
        if threading.current_thread() is threading.main_thread():  # else the process is not ours to end
            _end_process_after(END_SECONDS)
        log.info("the service ends")
        self._service.stop()
        with suppress(TimeoutError):
            async with asyncio.timeout(DRAIN_SECONDS):
                while self.server_state.tasks and not self.force_exit:
                    await asyncio.sleep(0.05)
        for task in self._accepting:
            task.cancel()
        await super().shutdown(sockets)


def _end_process_after(seconds: float) -> None:
    timer = threading.Timer(seconds, os._exit, (1,))
    timer.daemon = True
    timer.start()
