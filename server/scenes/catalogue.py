"""The scenes that can be chosen: the served one, the built-in ones, files of the scenes folder and uploads, by id.

An id is looked up in a list that the server makes; it never becomes a path, so none leaves the folder.
"""

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from time import monotonic

from gpu.errors import UserError
from gpu.scene.builtin import BUILTIN
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.load import SUFFIXES
from server.refusals import UnknownSceneError
from server.scenes.clutter import is_clutter
from server.scenes.uploads import Uploads
from server.wire.browser import SceneName
from server.wire.worker import SceneRef

MAX_LISTED = 10_000
LISTED_SECONDS = 2.0  # so that a burst of requests walks a large folder once


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
            raise UserError(f"{folder}: the scenes folder does not exist")
        if served not in BUILTIN and not Path(served).is_file():
            raise UserError(
                f"{served}: there is no such file, nor a built-in scene of that name ({', '.join(BUILTIN)})"
            )
        self.uploads = uploads
        self._folder = folder
        self._served = served
        self._options = options
        self._files: list[tuple[str, str]] = []
        self._files_until = 0.0

    @property
    def served(self) -> SceneRef:
        """The scene that is meant when none is named."""
        return self.find(None)

    def uploaded(self, scene_id: str) -> bool:
        """Whether a client brought this scene."""
        return self.uploads is not None and scene_id in self.uploads.all

    def touch(self, scene_id: str) -> None:
        """Note that a scene is used."""
        if self.uploads is not None:
            self.uploads.touch(scene_id)

    def file_bytes(self, scene: SceneRef) -> int | None:
        """Size of a scene's file, or of all files of an upload; None for a built-in scene, or when it is gone."""
        if self.uploads is not None and scene.id in self.uploads.all:
            return self.uploads.all[scene.id].bytes
        path = Path(scene.source)
        return path.stat().st_size if scene.source not in BUILTIN and path.is_file() else None

    def names(self) -> tuple[SceneName, ...]:
        """All scenes that can be chosen, the served one first."""
        return _names(self._sources())

    def found(self) -> list[tuple[SceneName, SceneRef]]:
        """`names` of those whose files are there now, and what they mean."""
        sources, found = self._sources(), []
        for name in _names(sources):
            with suppress(UnknownSceneError):
                found.append((name, self._ref(name.id, sources[name.id], None)))
        return found

    def find(self, scene_id: str | None, options: ImportOptions | None = None) -> SceneRef:
        """The scene with this id, or the served one, read as `options` say, or as it is when nobody says.

        UnknownSceneError when there is none.
        """
        sources = self._sources()
        if scene_id is None:
            scene_id = next(iter(sources))
        if scene_id not in sources:
            raise UnknownSceneError(f"scene: there is no {scene_id!r} here; /api/v1/scenes lists what there is")
        return self._ref(scene_id, sources[scene_id], options)

    def _ref(self, scene_id: str, source: str, options: ImportOptions | None) -> SceneRef:
        if options is None:
            options = self._usual_options(scene_id, source)
        if source in BUILTIN:
            return SceneRef(scene_id, source, options=options)
        try:
            return SceneRef(scene_id, source, Path(source).stat().st_mtime_ns, options)
        except OSError as error:
            raise UnknownSceneError(f"scene: {scene_id!r} cannot be read: {error.strerror}") from None

    def _usual_options(self, scene_id: str, source: str) -> ImportOptions:
        if self.uploads is not None and scene_id in self.uploads.all:
            return self.uploads.all[scene_id].options
        return self._options if source == self._served else DEFAULT_OPTIONS

    def _sources(self) -> dict[str, str]:
        # A built-in scene or a file in the folder that is called as the served file is yields its id to that.
        served_id = self._served if self._served in BUILTIN else Path(self._served).name
        listed = {served_id: self._served}
        for name in BUILTIN:
            listed.setdefault(name, name)
        if self._folder is not None:
            if monotonic() > self._files_until:
                self._files, self._files_until = _scene_files(self._folder), monotonic() + LISTED_SECONDS
            for id_, path in self._files:
                listed.setdefault(id_, path)
        if self.uploads is not None:
            # A folder of the scenes folder may be called as uploads are: the upload is meant then.
            listed.update((id_, str(self.uploads.path(upload))) for id_, upload in self.uploads.all.items())
        return listed


def _names(sources: Mapping[str, str]) -> tuple[SceneName, ...]:
    served = next(iter(sources))
    return tuple(
        SceneName(id=id_, name=Path(id_).stem, builtin=source in BUILTIN, served=id_ == served)
        for id_, source in sources.items()
    )


def _scene_files(folder: Path) -> list[tuple[str, str]]:
    """(path inside the folder, whole path) of its scene files, sorted; links that lead out of it are left out."""
    root = folder.resolve()
    found = []
    for directory, _, names in os.walk(root):
        for name in names:
            path = Path(directory, name)
            inside = path.relative_to(root)
            if path.suffix.lower() in SUFFIXES and not is_clutter(inside) and path.resolve().is_relative_to(root):
                found.append((inside.as_posix(), str(path)))
            if len(found) >= MAX_LISTED:
                return sorted(found)
    return sorted(found)
