"""Files of scenes that somebody looks at, and those beside them, which may change meanwhile, as when a program exports
them once more.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterable

from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from server.refusals import TooBusyError, UnknownSceneError
from server.scenes.versions import Versions
from server.wire.worker import SceneRef

LOOK_SECONDS = 2.0

Listener = Callable[[SceneRef, SceneRef, UserError | None], None]


class ChangedFiles:
    """Looks at files every few seconds, reads those that have changed and stayed so until the next look, and tells."""

    def __init__(
        self,
        viewed: Callable[[], Iterable[SceneRef]],
        versions: Versions,
        read: Callable[[SceneRef], Awaitable[object]],
    ) -> None:
        """viewed: the scenes that are looked at now; read: raises UserError for a scene that cannot be shown, or
        TooBusyError where it may be later.
        """
        self._viewed = viewed
        self._versions = versions
        self._read = read
        self.listeners: set[Listener] = set()  # hear a scene, what its file is now, and why that cannot be shown, once

    async def run(self) -> None:
        """Look until cancelled."""
        before: dict[SceneRef, SceneRef | None] = {}
        broken = set[SceneRef]()
        while True:
            await asyncio.sleep(LOOK_SECONDS)
            viewed = {scene for scene in self._viewed() if scene.source not in BUILTIN}
            now = await asyncio.to_thread(self._now, viewed)
            broken &= {*now.values()}
            for scene, newest in now.items():
                if newest is None or newest == scene or newest != before.get(scene) or newest in broken:
                    continue
                problem: UserError | None = None
                try:
                    await self._read(newest)
                except TooBusyError:
                    continue
                except UserError as error:
                    problem = error
                    broken.add(newest)
                for listener in tuple(self.listeners):
                    listener(scene, newest, problem)
            before = now

    def _now(self, scenes: Iterable[SceneRef]) -> dict[SceneRef, SceneRef | None]:
        """What files are now; None where one is gone."""
        found: dict[SceneRef, SceneRef | None] = {}
        for scene in scenes:
            try:
                found[scene] = self._versions.now(scene.id, scene.source, scene.options)
            except UnknownSceneError:
                found[scene] = None
        return found
