"""The engines of a service as its settings say: made, and their workers started, before all that serves is imported."""

from collections.abc import Sequence

from server.render.devices import chosen_devices
from server.render.engine_pool import EnginePool
from server.render.worker_process import WORKER
from server.scenes.served import served_scene
from server.settings import ServerSettings
from server.wire.worker import Start


def make_engines(settings: ServerSettings, worker: Sequence[str] = WORKER) -> EnginePool:
    """An engine a device, whose workers are started by the command `worker`.

    UserError when there is no such scene, or a device is named as none can be.
    """
    start = Start(
        scene=served_scene(settings.scene, settings.scene_options),
        max_scenes=settings.max_scenes,
        scene_limits=settings.scene_limits,
        check_seconds=settings.check_seconds,
        check_memory_bytes=settings.check_memory_bytes,
        environment=settings.surroundings,
        log_format=settings.log_format,
    )
    return EnginePool.of(start, chosen_devices(settings.device), worker, settings.hang_seconds)
