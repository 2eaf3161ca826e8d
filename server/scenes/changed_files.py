"""Files of scenes that somebody looks at, which may change meanwhile, as when a program exports them once more."""

import asyncio
from collections.abc import Callable, Iterable

from gpu.scene.builtin import BUILTIN
from server.refusals import UnknownSceneError
from server.scenes.served import scene_ref
from server.wire.worker import SceneRef

LOOK_SECONDS = 2.0


class ChangedFiles:
    """Looks at files every few seconds, and tells of those that have changed and stayed so until the next look."""

    def __init__(self, viewed: Callable[[], Iterable[SceneRef]]) -> None:
        """viewed: the scenes that are looked at now."""
        self._viewed = viewed
        self.listeners: set[Callable[[SceneRef, SceneRef], None]] = set()  # hear a scene and what its file is now

    async def run(self) -> None:
        """Look until cancelled."""
        before: dict[SceneRef, SceneRef | None] = {}
        while True:
            await asyncio.sleep(LOOK_SECONDS)
            viewed = {scene for scene in self._viewed() if scene.source not in BUILTIN}
            now = await asyncio.to_thread(_now, viewed)
            for scene, newest in now.items():
                if newest is not None and newest != scene and newest == before.get(scene):
                    for listener in tuple(self.listeners):
                        listener(scene, newest)
            before = now


def _now(scenes: Iterable[SceneRef]) -> dict[SceneRef, SceneRef | None]:
    """What files are now; None where one is gone."""
    found: dict[SceneRef, SceneRef | None] = {}
    for scene in scenes:
        try:
            found[scene] = scene_ref(scene.id, scene.source, scene.options)
        except UnknownSceneError:
            found[scene] = None
    return found
