"""lumenwalk on Ray Serve: a replica is a whole service with a GPU of its own. docs/scale.md says how it is run.

Ray starts, watches and ends replicas, as many as `scale` asks for; its proxies pass requests on to them (PathRouter).
"""

import asyncio
import logging
from collections.abc import Mapping, Sequence
from time import monotonic
from typing import Any

from ray import serve
from ray.serve.config import AutoscalingConfig, AutoscalingPolicy, RequestRouterConfig
from starlette.types import ASGIApp

from gpu.errors import UserError
from server.addresses import is_loopback
from server.app import create_app
from server.cluster.own_path import OwnPath, ToOwnPath
from server.cluster.router import PathRouter
from server.cluster.scaling import scale
from server.cluster.storage import Mirror
from server.engines import make_engines
from server.folders import TemporaryFolder
from server.render.activity import EngineState
from server.render.busy_meter import BusyMeter
from server.render.worker_process import WORKER
from server.service import Service
from server.settings import ServerSettings, load_settings

STATISTICS_SECONDS = 1.0  # between two words of a replica to routers
MIRROR_SECONDS = 30.0  # between two looks at a store of scenes
DRAIN_SECONDS = 3600.0  # for the viewers of a replica that is to go to leave
MOST_REQUESTS = 20_000  # at once, of a replica: it has limits of its own
NAME = "lumenwalk"
log = logging.getLogger("lumenwalk.cluster")


class Replica:
    """One service. Ray calls its methods in the event loop in which the service runs."""

    def __init__(self, settings: Mapping[str, Any], storage: str | None, worker: Sequence[str]) -> None:
        """settings: fields of ServerSettings; storage: URL of a store of scenes; worker: as of `make_engines`."""
        self._mirror: Mirror | None = None
        self._folder = TemporaryFolder() if storage is not None else None
        if storage is not None and self._folder is not None:
            self._mirror = Mirror(storage, self._folder.path)
            self._mirror.update()
            settings = {**settings, "scenes_dir": self._folder.path}
        self._prefix = f"/r/{serve.get_replica_context().replica_id.unique_id}"
        chosen = ServerSettings(**settings)
        self._app = create_app(chosen, make_engines(chosen, worker))
        self._service: Service = self._app.state.service
        self._service.replicas = Handles(self._service)
        self._app.router.default = ToOwnPath(self._app.router.default, self._prefix)
        self._busy = BusyMeter()
        self._mirroring: asyncio.Task[None] | None = None

    def __serve_build_asgi_app__(self) -> ASGIApp:
        if self._mirror is not None:
            self._mirroring = asyncio.get_running_loop().create_task(self._keep_mirroring(self._mirror))
        return OwnPath(self._app)

    async def path(self) -> str:
        """Where clients find this replica; whom the router sends here to ask."""
        return self._prefix

    async def record_routing_stats(self) -> dict[str, Any]:
        """What routers go by."""
        engines = self._service.engines
        loaded = [scene.id for scene in engines.scenes]
        return {"at": monotonic(), "ready": engines.ready, "loaded": loaded, "viewers": len(self._service.viewers)}

    async def record_autoscaling_stats(self) -> dict[str, float]:
        """What `scale` goes by."""
        return {"busy": self._busy.share(self._service.engines.busy_seconds), "viewers": len(self._service.viewers)}

    async def check_health(self) -> None:
        """An error where this replica can render no more; then Ray starts another one."""
        activity = self._service.engines.activity
        if activity.state is EngineState.FAILED:
            raise RuntimeError(activity.text)

    async def _keep_mirroring(self, mirror: Mirror) -> None:
        while True:
            await asyncio.sleep(MIRROR_SECONDS)
            try:
                await asyncio.to_thread(mirror.update)
            except Exception as error:  # each kind of store has errors of its own
                log.warning("the store of scenes cannot be read: %s", error)

    def __del__(self) -> None:
        if self._folder is not None:
            self._folder.remove()


class Handles:
    """Assigns viewers to replicas: Ray's router sends a question where a viewer of the scene would go."""

    def __init__(self, service: Service) -> None:
        self._service = service

    async def choose(self, scene: str) -> str:
        """The path of a replica; UnknownSceneError where there is no such scene here, as at all but for uploads."""
        await self._service.catalogue.look_up(scene)
        handle = serve.get_deployment_handle(NAME, serve.get_replica_context().app_name)
        return str(await handle.options(session_id=scene).path.remote())


def application(
    settings: ServerSettings,
    storage: str | None = None,
    fewest: int = 1,
    most: int = 1,
    worker: Sequence[str] = WORKER,
) -> serve.Application:
    """What `serve.run` takes: `fewest` to `most` replicas; the others as of Replica."""
    if settings.token is None and not is_loopback(settings.host):
        raise UserError("token: a service on Ray needs one, since others can reach its proxies")
    if settings.device not in (None, "cpu"):
        raise UserError("device: Ray gives each replica a GPU; only cpu can be asked for")
    policy = AutoscalingPolicy(policy_function=scale)
    scaling = AutoscalingConfig(min_replicas=fewest, max_replicas=most, policy=policy)
    routing = RequestRouterConfig(request_router_class=PathRouter, request_routing_stats_period_s=STATISTICS_SECONDS)
    deployment = serve.deployment(
        serve.ingress()(Replica),
        name=NAME,
        autoscaling_config=scaling,
        request_router_config=routing,
        max_ongoing_requests=MOST_REQUESTS,
        graceful_shutdown_timeout_s=DRAIN_SECONDS,
        ray_actor_options={"num_cpus": 1, "num_gpus": 0 if settings.device == "cpu" else 1},
    )
    return deployment.bind(settings.model_dump(exclude_unset=True), storage, worker)


def build(arguments: dict[str, str]) -> serve.Application:
    """For Ray's command line: `storage`, `min_replicas` and `max_replicas`, and whatever ServerSettings has."""
    given = {"host": "0.0.0.0", **arguments}
    fewest, most = (int(given.pop(name, "1")) for name in ("min_replicas", "max_replicas"))
    storage = given.pop("storage", None)
    return application(load_settings(flags=given), storage, fewest, most)
