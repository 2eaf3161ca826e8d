"""Which scenes are on the devices, what they take there, and whether one more fits before it is tried."""

import asyncio
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from weakref import WeakValueDictionary

from gpu.scene.builtin import BUILTIN
from server.places import asker
from server.refusals import NoRoomError
from server.render.engine import Engine
from server.render.engine_pool import EnginePool
from server.render.schedule import Urgency
from server.render.worker_link import TurnedAwayError
from server.scenes.checked import Checked, SceneSize
from server.scenes.checker import Checker
from server.wire.browser import SceneInfo
from server.wire.worker import STILLS, Opened, SceneRef

# Bytes on the device (gpu.device_scene.upload): positions and normals are 3 floats; triangles have 3 indices, a
# material, in the tree (gpu.device_scene.bvh) 3 corners of 4 floats, a number and a third of a node of 128 bytes, and,
# while that is made, indices once more, a box of 2 × 3 floats, and 2 nodes of 32 bytes with links of 8.
VERTEX_BYTES, UV_BYTES, COLOR_BYTES = 24, 8, 16
TRIANGLE_BYTES = 16 + 52 + 43 + 12 + 24 + 2 * 40
MATERIAL_BYTES = 512
TEXEL_BYTES = 4
MOST_READINGS = 8  # of a file, with other options each, that are remembered
LIGHTING_BYTES = 64 * 2**20  # virtual point lights, their clusters and a renderer


def device_bytes(size: SceneSize) -> int:
    """What a scene is expected to take on the device, with its light [bytes]."""
    vertex = VERTEX_BYTES + UV_BYTES * size.uv_sets + COLOR_BYTES * size.colored
    geometry = size.vertices * vertex + size.triangles * TRIANGLE_BYTES
    return geometry + size.materials * MATERIAL_BYTES + size.texels * TEXEL_BYTES + LIGHTING_BYTES


class Residency:
    """Loads scenes into workers and frees them."""

    def __init__(
        self,
        engines: EnginePool,
        checker: Checker,
        reserve_bytes: int,
        used: Callable[[], Iterable[SceneRef]],
        touch: Callable[[str], None],
        learned: Callable[[SceneRef, Opened], None],
    ) -> None:
        """reserve_bytes: of the device's memory, stay free; used: what somebody looks at, or a job is to render; touch:
        hears the ids of scenes that are used; learned: hears what is in one that was opened.
        """
        self._engines = engines
        engines.fits = self._fits
        self._checker = checker
        self._reserve_bytes = reserve_bytes
        self._used = used
        self._touch = touch
        self._learned = learned
        self._checked: dict[SceneRef, Checked] = {}  # in the order of their last use
        self._opened: dict[SceneRef, Opened] = {}
        self._loading = {engine: asyncio.Lock() for engine in engines.engines}
        self._reading = WeakValueDictionary[str, asyncio.Lock]()  # by client
        self._of_client = WeakValueDictionary[tuple[Engine, str], asyncio.Lock]()
        self._opening: Counter[str] = Counter()  # ids of scenes that are on their way to the device
        self._checking = WeakValueDictionary[SceneRef, asyncio.Lock]()  # scenes that are being read now

    @property
    def loaded(self) -> tuple[SceneRef, ...]:
        """The scenes on a device."""
        return self._engines.scenes

    def holds(self, scene: SceneRef) -> bool:
        """Whether a scene is on a device, however its file was read."""
        return any((other.id, other.stamp) == (scene.id, scene.stamp) for other in self.loaded)

    def bytes_of(self, scene: SceneRef) -> int | None:
        """What a scene takes on the device, as far as its file was checked [bytes]."""
        known = self._checked.get(scene)
        return device_bytes(known.size) if known is not None else None

    def learn(self, scene: SceneRef, checked: Checked) -> None:
        """A scene was checked already, such as an upload."""
        alike = [other for other in self._checked if other.id == scene.id and other != scene]
        outdated = {other for other in alike if other.stamp != scene.stamp}
        for other in outdated | {*alike[: max(len(alike) - MOST_READINGS + 1, 0)]}:
            del self._checked[other]
        self._checked[scene] = checked

    async def inspect(self, scene: SceneRef) -> Checked:
        """What is in a scene, read in a child process the first time, of one client one at a time; errors as of
        `Checker.check`.
        """
        if scene in self._checked:
            self.learn(scene, self._checked.pop(scene))
            return self._checked[scene]
        # Many may come for one scene at the same time, as when a service was restarted: it is read once.
        lock = self._checking.setdefault(scene, asyncio.Lock())
        one = self._reading.setdefault(asker.get(), asyncio.Lock())  # first, so that nobody waits for what waits itself
        async with one, lock:
            checked = self._checked.pop(scene, None)
            if checked is None:
                checked = await self._checker.check(scene.source, scene.id, options=scene.options)
            self.learn(scene, checked)
            return checked

    async def open(self, scene: SceneRef, client: int = STILLS) -> SceneInfo:
        """Make sure that a scene is on the device that renders for a client, and say what is in it.

        Raises NoRoomError when it would not leave the reserve free, else as `inspect` and `Engine.open`.
        """
        self._touch(scene.id)
        self._opening[scene.id] += 1
        try:
            if scene not in self.loaded and scene.source not in BUILTIN:  # those that come with the program are small
                await self.inspect(scene)
            while True:
                try:
                    opened = await self._open(scene, self._engines.place(client, scene, Urgency.STILL))
                except TurnedAwayError:
                    continue
                self._learned(scene, opened)
                return opened.info
        finally:
            self._opening[scene.id] -= 1
            self._opening += Counter()  # forgets what has come

    def opening(self, scene_id: str) -> bool:
        """Whether a scene is on its way to the device."""
        return self._opening[scene_id] > 0

    def _in_use(self, scene_id: str) -> bool:
        return self.opening(scene_id) or any(scene.id == scene_id for scene in self._used())

    async def _open(self, scene: SceneRef, engine: Engine) -> Opened:
        """What is there already waits for nothing; of what one client wants one scene waits for its turn at a time."""
        if scene in self._opened and scene in engine.scenes:
            return self._opened[scene]
        one = self._of_client.setdefault((engine, asker.get()), asyncio.Lock())
        async with one, self._loading[engine]:
            self._opened = {known: info for known, info in self._opened.items() if known in self.loaded}
            if scene not in self._opened or scene not in engine.scenes:
                await self._free_outdated(scene, engine)
                self._check_room(scene, engine)
                kept = self._checker.kept.take(scene.source, scene.options)
                self._opened[scene] = await engine.open(scene, kept.path if kept is not None else "")
            return self._opened[scene]

    async def _free_outdated(self, scene: SceneRef, engine: Engine) -> None:
        """Free what the file of a scene was before, where nobody looks at that any more."""
        used = {*self._used()}
        for other in engine.scenes:
            if other.id == scene.id and other.stamp != scene.stamp and other not in used:
                await engine.close(other)

    async def close(self, scene: SceneRef) -> None:
        """Free what is on any device of a scene, however its file was read."""
        for engine in self._engines.engines:
            for other in engine.scenes:
                if other.id == scene.id:
                    await engine.close(other)

    async def free_lost(self) -> None:
        """Free scenes whose file is gone and that nobody looks at, and forget what was in them."""
        self._checked = {scene: known for scene, known in self._checked.items() if not _gone(scene)}
        for scene in self.loaded:
            if _gone(scene) and self._engines.ready and not self._in_use(scene.id):
                await self.close(scene)

    def _fits(self, engine: Engine, scene: SceneRef) -> bool:
        needed, free = self._needed_and_free(engine, scene)
        return engine.memory[1] == 0 or needed <= free

    def _needed_and_free(self, engine: Engine, scene: SceneRef) -> tuple[int, int]:
        used, total = engine.memory
        return self.bytes_of(scene) or LIGHTING_BYTES, max(total - used - self._reserve_bytes, 0)

    def _check_room(self, scene: SceneRef, engine: Engine) -> None:
        if scene in engine.scenes or self._fits(engine, scene):
            return
        needed, free = self._needed_and_free(engine, scene)
        idle = [other.id for other in engine.scenes if not self._in_use(other.id)]
        advice = f"unload what nobody looks at: {', '.join(idle)}" if idle else "nothing is loaded that nobody looks at"
        raise NoRoomError(
            f"{scene.id}: needs about {_megabytes(needed)} on the device, which has {_megabytes(free)} to give "
            f"({_megabytes(self._reserve_bytes)} of it stay free); {advice}"
        )


def _gone(scene: SceneRef) -> bool:
    return scene.source not in BUILTIN and not Path(scene.source).exists()


def _megabytes(count: int) -> str:
    return f"{count / 1e6:,.0f} MB"
