"""The scenes that can be chosen: the served one, the built-in ones, files of the scenes folder and uploads, by id.

An id is looked up in a list that the server makes; it never becomes a path, so none leaves the folder.
"""

import asyncio
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from time import monotonic

from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from server.refusals import UnknownSceneError
from server.scenes.listing import scene_files
from server.scenes.served import check_served, served_id
from server.scenes.uploads import Uploads
from server.scenes.versions import Versions
from server.wire.browser import SceneName
from server.wire.worker import SceneRef

LISTED_SECONDS = 2.0  # so that a burst of requests walks a large folder once
SHARE = 10.0  # and one that takes long is walked a tenth of the time at most
NAMED = 4  # to who asks for a scene that is not there


class Catalogue:
    """Ids of scenes. `uploads` is None where clients may not bring any."""

    def __init__(
        self,
        served: str,
        folder: Path | None,
        uploads: Uploads | None = None,
        options: ImportOptions = DEFAULT_OPTIONS,
    ) -> None:
        """options: how the served file is read. UserError when the served scene or the folder does not exist."""
        if folder is not None and not folder.is_dir():
            raise UserError(f"{folder}: there is no such folder of scenes; make it, or name another")
        check_served(served)
        self.uploads = uploads
        self.versions = Versions()
        self._folder = folder
        self._served = served
        self._options = options
        self._files: dict[str, str] = {}
        self._file_names: tuple[SceneName, ...] = ()
        self._files_until = 0.0
        self._listing = asyncio.Lock()
        if folder is not None:
            self._take(*_timed_files(folder))

    @property
    def served(self) -> SceneRef:
        """The scene that is meant when none is named."""
        return self.find(None)

    def uploaded(self, scene_id: str) -> bool:
        """Whether a client brought this scene."""
        return self.uploads is not None and self.uploads.get(scene_id) is not None

    def touch(self, scene_id: str) -> None:
        """Note that a scene is used."""
        if self.uploads is not None:
            self.uploads.touch(scene_id)

    def file_bytes(self, scene: SceneRef) -> int | None:
        """Size of a scene's file, or of all files of an upload; None for a built-in scene, or when it is gone."""
        if self.uploads is not None and (upload := self.uploads.get(scene.id)) is not None:
            return upload.bytes
        path = Path(scene.source)
        return path.stat().st_size if scene.source not in BUILTIN and path.is_file() else None

    async def refresh(self) -> None:
        """Look through the folder again, in a thread, unless that was done a moment ago."""
        if self._folder is None or monotonic() < self._files_until:
            return
        async with self._listing:
            if monotonic() >= self._files_until:
                self._take(*await asyncio.to_thread(_timed_files, self._folder))

    async def look_up(self, scene_id: str | None, options: ImportOptions | None = None) -> SceneRef:
        """As `find`, of what the folder holds now."""
        await self.refresh()
        return self.find(scene_id, options)

    def names(self) -> tuple[SceneName, ...]:
        """All scenes that can be chosen, the served one first."""
        served = self._served_id
        before = [served, *(name for name in BUILTIN if name != served)]
        known = {*before}
        uploads = self.uploads.all if self.uploads is not None else {}
        files = tuple(name for name in self._file_names if name.id not in known and name.id not in uploads)
        return (*map(self._name, before), *files, *map(self._name, uploads))

    def found(self) -> Iterator[tuple[SceneName, SceneRef]]:
        """`names` of those whose files are there now, and what they mean."""
        for name in self.names():
            with suppress(UnknownSceneError):
                yield name, self.find(name.id)

    def name(self, scene_id: str) -> SceneName | None:
        """How the scene with this id is listed; None when there is none."""
        return self._name(scene_id) if self._source(scene_id) is not None else None

    def find(self, scene_id: str | None, options: ImportOptions | None = None) -> SceneRef:
        """The scene with this id, or the served one, read as `options` say, or as it is when nobody says.

        UnknownSceneError when there is none.
        """
        if scene_id is None:
            scene_id = self._served_id
        source = self._source(scene_id)
        if source is None:
            raise UnknownSceneError(f"scene: there is no {scene_id!r} here, but {self._some()}")
        return self._ref(scene_id, source, options)

    def _some(self) -> str:
        """Scenes that there are, in words."""
        ids = [name.id for name in self.names()]
        return ", ".join(ids[:NAMED]) + (f" and {len(ids) - NAMED} more" if len(ids) > NAMED else "")

    def _ref(self, scene_id: str, source: str, options: ImportOptions | None) -> SceneRef:
        if options is None:
            options = self._usual_options(scene_id, source)
        return self.versions.now(scene_id, source, options)

    def _usual_options(self, scene_id: str, source: str) -> ImportOptions:
        if self.uploads is not None and (upload := self.uploads.get(scene_id)) is not None:
            return upload.options
        return self._options if source == self._served else DEFAULT_OPTIONS

    @property
    def _served_id(self) -> str:
        return served_id(self._served)

    def _source(self, scene_id: str) -> str | None:
        """What an id means: a folder in the scenes folder may be called as uploads are, a file as the served one."""
        if self.uploads is not None and (upload := self.uploads.get(scene_id)) is not None:
            return str(self.uploads.path(upload))
        if scene_id == self._served_id:
            return self._served
        return scene_id if scene_id in BUILTIN else self._files.get(scene_id)

    def _name(self, scene_id: str) -> SceneName:
        builtin = self._source(scene_id) in BUILTIN
        return SceneName(id=scene_id, name=Path(scene_id).stem, builtin=builtin, served=scene_id == self._served_id)

    def _take(self, files: dict[str, str], seconds: float) -> None:
        """Know these files now, and for longer where it took long to find them."""
        if files != self._files:
            self._file_names = tuple(
                SceneName(id=id_, name=Path(id_).stem, builtin=False, served=False) for id_ in files
            )
        self._files = files
        self._files_until = monotonic() + max(LISTED_SECONDS, SHARE * seconds)


def _timed_files(folder: Path) -> tuple[dict[str, str], float]:
    """The scene files of a folder, and how long it took to find them [s]."""
    began = monotonic()
    return scene_files(folder), monotonic() - began
