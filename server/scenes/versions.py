"""Versions of scenes' files: that of a file, which has a time, with those beside it that it was read with."""

from collections.abc import Mapping
from pathlib import Path
from zlib import crc32

from gpu.scene.formats.files import written_at
from gpu.scene.import_options import ImportOptions
from server.scenes.served import scene_ref
from server.wire.worker import SceneRef

MOST = 1000  # scenes whose files are remembered


class Versions:
    """Knows which files belong to a scene once it was opened, and by them when it is another version."""

    def __init__(self) -> None:
        # By the scene's own file: where others are, and when they were written as they were read for the first time.
        self._beside: dict[str, dict[Path, int]] = {}

    def learn(self, scene: SceneRef, beside: Mapping[str, int]) -> None:
        """A scene was opened; beside: as of gpu.scene.types.LoadReport."""
        if not beside:
            return
        folder = Path(scene.source).parent
        known = {folder / name: written for name, written in beside.items()} | self._beside.pop(scene.source, {})
        self._beside[scene.source] = known
        if len(self._beside) > MOST:
            del self._beside[next(iter(self._beside))]

    def now(self, scene_id: str, source: str, options: ImportOptions) -> SceneRef:
        """A scene as its files are now; UnknownSceneError where its own cannot be read.

        Its stamp is the time of its own file as long as those beside it are as they were first read.
        """
        scene = scene_ref(scene_id, source, options)
        changed = [
            f"{path} {now}" for path, then in self._beside.get(source, {}).items() if (now := written_at(path)) != then
        ]
        if not changed:
            return scene
        return SceneRef(scene_id, source, scene.stamp + 1 + crc32("\n".join(sorted(changed)).encode()), options)
