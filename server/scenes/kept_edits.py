"""Edits that all see, kept in a file from one run of the service to the next: a line of JSON a scene."""

import asyncio
import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import starmap
from pathlib import Path
from threading import Lock

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gpu.scene.edits import SceneEdits
from gpu.scene.import_options import ImportOptions
from server.plain_files import read_plain
from server.refusals import UnknownSceneError
from server.scenes.scene_edits import MOST_EDITED, EditedScenes
from server.scenes.uploads import PREFIX as UPLOADS
from server.wire.worker import SceneRef

FILE = "edits.jsonl"
ASIDE, UNFINISHED = ".unread", ".unfinished"  # what their names end in
MAX_BYTES = 2**26
REST_SECONDS = 2.0  # between two writings, as while somebody drags a light
log = logging.getLogger("lumenwalk.edits")

Find = Callable[[str, ImportOptions], SceneRef]


class _Line(BaseModel):
    """The edits of a scene, by its id, the stamp of its file, and how that is read."""

    model_config = ConfigDict(extra="forbid")

    scene: str = Field(max_length=1024)
    stamp: int
    options: ImportOptions
    edits: SceneEdits


class KeptEdits:
    """Writes the edits of scenes into a folder whenever they have changed."""

    def __init__(self, folder: Path, edited: EditedScenes, find: Find) -> None:
        """Take up what the folder keeps from an earlier service.

        find: the scene of an id, read so; UnknownSceneError where there is none.
        """
        self._file = folder / FILE
        self._edited = edited
        found, self._others = _kept(self._file, find)
        edited.restore(found)
        self._changed = asyncio.Event()
        if (found or self._others) and not self._file.exists():  # set aside, for what else was in it
            self._changed.set()
        self._writing = Lock()  # when the service ends, a thread may still be at it
        self._fails = False

    async def run(self) -> None:
        """Write what changes, until cancelled; then what has changed since."""
        self._edited.listeners.add(self._note)
        try:
            while True:
                await self._changed.wait()
                self._changed.clear()
                await self._write_beside()
                await asyncio.sleep(REST_SECONDS)
        finally:
            self._edited.listeners.discard(self._note)
            if self._changed.is_set():
                self._write(self._edited.all)

    def _note(self, _: SceneRef) -> None:
        self._changed.set()

    async def _write_beside(self) -> None:
        try:
            await asyncio.to_thread(self._write, self._edited.all)
        except asyncio.CancelledError:  # before a thread was free for it, maybe
            self._changed.set()
            raise

    def _write(self, edits: Mapping[SceneRef, SceneEdits]) -> None:
        """All at once or not at all; what cannot be written is lost with the service, and the log says why, once."""
        lines = [*self._others, *starmap(_line, edits.items())][-MOST_EDITED:]
        try:
            with self._writing:
                _write(self._file, lines)
            self._fails = False
        except OSError as error:
            if not self._fails:
                log.warning("%s: edits of scenes cannot be kept: %s", self._file, error.strerror or error)
            self._fails = True


def _line(scene: SceneRef, edits: SceneEdits) -> bytes:
    line = _Line(scene=scene.id, stamp=scene.stamp, options=scene.options, edits=edits)
    return line.model_dump_json(exclude_defaults=True).encode()


def _write(file: Path, lines: Sequence[bytes]) -> None:
    new = file.with_name(f"{file.name}{UNFINISHED}")
    new.unlink(missing_ok=True)
    with new.open("xb") as target:
        target.writelines(line + b"\n" for line in lines)
        target.flush()
        os.fsync(target.fileno())
    new.replace(file)


def _kept(file: Path, find: Find) -> tuple[dict[SceneRef, SceneEdits], list[bytes]]:
    """What a file keeps, the longest unchanged first, and its lines of scenes that this service does not have.

    What means nothing is logged, and the file set aside.
    """
    found, others, problems = dict[SceneRef, SceneEdits](), list[bytes](), list[str]()
    try:
        lines = read_plain(file, MAX_BYTES).splitlines()
    except FileNotFoundError:
        lines = []
    except (OSError, ValueError) as error:
        lines, problems = [], [str(error)]
    for number, line in enumerate(lines, 1):
        try:
            kept = _Line.model_validate_json(line)
            scene = find(kept.scene, kept.options)
        except ValidationError as error:
            problems.append(f"line {number}: {'; '.join(_problems(error))}")
        except UnknownSceneError:
            others.append(line)
        else:
            if scene.stamp == kept.stamp:
                found[scene] = kept.edits
            elif not kept.scene.startswith(UPLOADS):  # where others may be called alike
                found[replace(scene, stamp=kept.stamp)] = kept.edits  # which the file takes over as it is now
            else:
                log.warning("the file of %r is another one now: its edits are not taken up", kept.scene)
    if problems:
        _set_aside(file, " | ".join(problems)[:500])
    return found, others


def _problems(error: ValidationError) -> Iterator[str]:
    for one in error.errors(include_url=False)[:3]:
        where = ".".join(map(str, one["loc"]))
        yield f"{where}: {one['msg']}" if where else one["msg"]


def _set_aside(file: Path, why: str) -> None:
    aside = file.with_name(f"{file.name}{ASIDE}")
    log.warning("%s cannot be read as edits of scenes, and is kept as %s: %s", file, aside.name, why)
    try:
        file.replace(aside)
    except OSError as error:
        log.warning("%s cannot be set aside: %s", file, error.strerror or error)
