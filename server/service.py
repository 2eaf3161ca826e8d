"""What the endpoints share: settings, scenes, the engine, and who is there."""

import asyncio
from dataclasses import dataclass, field
from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from server.engine import Engine
from server.messages import Start
from server.metrics import Metrics
from server.scenes import Catalogue
from server.settings import ServerSettings


@dataclass
class Service:
    """One running service."""

    settings: ServerSettings
    catalogue: Catalogue
    engine: Engine
    viewers: set[int] = field(default_factory=set)
    last_viewer: int = 0
    still_turn: asyncio.Lock = field(default_factory=asyncio.Lock)  # stills share one place in the engine's queue
    stills_waiting: int = 0
    metrics: Metrics = field(default_factory=Metrics)
    stopping: asyncio.Event = field(default_factory=asyncio.Event)  # set once: the service ends

    def admit(self) -> int | None:
        """A number for one more viewer, never used before; None when as many are here as may be."""
        if len(self.viewers) >= self.settings.max_viewers:
            return None
        self.last_viewer += 1
        self.viewers.add(self.last_viewer)
        return self.last_viewer

    def dismiss(self, viewer: int) -> None:
        """A viewer has left."""
        self.viewers.discard(viewer)
        self.metrics.windows.pop(viewer, None)
        self.engine.leave(viewer)


def start_message(settings: ServerSettings, catalogue: Catalogue) -> Start:
    """What a worker is told first."""
    return Start(
        scene=catalogue.served,
        device=settings.device,
        max_scenes=settings.max_scenes,
        scene_limits=settings.scene_limits,
    )


def _service(connection: HTTPConnection) -> Service:
    service = connection.app.state.service
    assert isinstance(service, Service)
    return service


TheService = Annotated[Service, Depends(_service)]
