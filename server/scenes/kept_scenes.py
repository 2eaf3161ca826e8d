"""Scenes as their files were checked, kept for the worker that is to have them, which need not read the file again."""

import os
import weakref
from contextlib import suppress
from fcntl import F_ADD_SEALS, F_SEAL_GROW, F_SEAL_SHRINK, F_SEAL_WRITE, fcntl
from pathlib import Path

from gpu.scene.import_options import ImportOptions

MOST_BYTES = 512 * 2**20  # of all that are kept; a scene of more is read again
KEPT_SECONDS = 600.0  # at most: nobody may ever look at it

Key = tuple[int, int, int, int, ImportOptions]


class KeptScene:
    """Memory that a reader writes a scene into (server.scenes.packed_scene); it is freed with this object."""

    def __init__(self, source: str, options: ImportOptions) -> None:
        """For the file `source` as it is now; OSError where there is none, or no memory."""
        self.key = _key(source, options)
        self.memory = os.memfd_create("scene", os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC)
        weakref.finalize(self, os.close, self.memory)

    @property
    def bytes(self) -> int:
        """How much has been written."""
        return os.fstat(self.memory).st_size

    @property
    def path(self) -> str:
        """Where another process of this user opens it."""
        return f"/proc/{os.getpid()}/fd/{self.memory}"

    def seal(self) -> None:
        """Nothing that the reader has left behind can change it from now on; OSError where it cannot be had."""
        seal(self.memory)


class KeptScenes:
    """Those that no worker has taken yet; the oldest go first."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._scenes: dict[Key, KeptScene] = {}
        self._most_bytes = most_bytes

    def keep(self, scene: KeptScene) -> None:
        """A reader has written it and ended."""
        with suppress(OSError):
            scene.seal()
            if 0 < scene.bytes <= self._most_bytes:
                self._scenes[scene.key] = scene
        while sum(it.bytes for it in self._scenes.values()) > self._most_bytes:
            del self._scenes[next(iter(self._scenes))]

    def forget(self, key: Key) -> None:
        """It has been kept long enough, if it still is."""
        self._scenes.pop(key, None)

    def take(self, source: str, options: ImportOptions) -> KeptScene | None:
        """The scene of this file as it is now, if it is kept; it is no more. It may be called otherwise than it was."""
        with suppress(OSError):
            return self._scenes.pop(_key(source, options), None)
        return None


def seal(memory: int) -> None:
    """Nobody can change what is in a memory file any more."""
    fcntl(memory, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK)


def _key(source: str, options: ImportOptions) -> Key:
    """What is the same of a file that was moved, and another when it has changed."""
    found = Path(source).stat()
    return found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size, options
