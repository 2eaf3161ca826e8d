"""Scenes that clients bring: taken in piece by piece, checked in a child process, kept in a folder of their own each.

A client's name for a file becomes an id, never a path: each upload has a folder named by the server, and what its
scene refers to is looked for in there only (server.scenes.upload_records).
"""

import asyncio
import logging
import os
import secrets
import shutil
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import cached_property
from pathlib import Path, PurePosixPath
from time import monotonic, time_ns
from unicodedata import normalize
from weakref import WeakValueDictionary

from gpu.errors import SceneError, UserError
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from gpu.scene.load import SUFFIXES
from server.folders import TemporaryFolder, hold
from server.places import asker
from server.refusals import NoRoomError, TooBusyError, TooLargeError, TooSlowError, UnknownSceneError
from server.scenes.archives import UnpackedError
from server.scenes.checked import Checked
from server.scenes.checker import Checker
from server.scenes.upload_records import UNFINISHED, Upload, keep_upload, kept_uploads, record_of, size_of
from server.settings import ServerSettings

PREFIX = "uploads/"
ARCHIVE = ".zip"
EXPORT = "/export.glb"  # below a scene's address is the file that it is downloaded as: no id ends so
MAX_AT_ONCE = 16
CHUNK_BYTES = 2**20
STALL_SECONDS = 30.0
MIN_RATE = 32_768  # bytes a second from then on: a place that drips is kept from others
USUAL_RATIO = 4  # of unpacked to packed bytes, that few archives exceed
MAX_STEM = 64
log = logging.getLogger("lumenwalk.uploads")

Claim = Callable[[int], Awaitable[None]]  # of more bytes, before they are written


class Uploads:
    """The uploads of one folder, the longest unused first."""

    def __init__(self, settings: ServerSettings, checker: Checker) -> None:
        """Take up what the folder keeps from an earlier service. UserError when it cannot be used."""
        self._checker = checker
        self._max_bytes = settings.max_upload_bytes
        self._max_count = settings.max_uploads
        self._max_total_bytes = settings.max_uploads_bytes
        self._taking = 0
        self.kept = 0  # since the service began
        self._reading = WeakValueDictionary[str, asyncio.Lock]()  # by client
        self._keeping = asyncio.Lock()
        self._claims: dict[Path, int] = {}  # what unfinished uploads take, by their folders [bytes]
        self._uploads: dict[str, Upload] = {}
        self._brought: dict[tuple[str, str], str] = {}  # the newest upload of a client and a name, by id
        self._before: dict[str, str] = {}  # ids of uploads, and what was that until they came
        self._temporary: TemporaryFolder | None = None
        self._lock: int | None = None
        if settings.uploads_dir is not None:
            try:
                settings.uploads_dir.mkdir(parents=True, exist_ok=True)
                self._lock = hold(settings.uploads_dir)
                if self._lock is None:
                    raise UserError(f"{settings.uploads_dir}: another service keeps its uploads there; choose another")
                self._uploads = {upload.id: upload for upload in kept_uploads(settings.uploads_dir.resolve())}
            except OSError as error:
                problem = f"cannot keep uploads there: {error.strerror or error}"
                raise UserError(f"{settings.uploads_dir}: {problem}") from None
        self._given = settings.uploads_dir

    @cached_property
    def _folder(self) -> Path:
        if self._given is not None:
            return self._given.resolve()
        self._temporary = TemporaryFolder()
        folder = self._temporary.path / "uploads"
        folder.mkdir()
        return folder

    def close(self) -> None:
        """Delete the uploads, unless their folder was given, which another service may have now."""
        if self._temporary is not None:
            self._temporary.remove()
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    @property
    def all(self) -> dict[str, Upload]:
        """By id, the longest unused first."""
        return dict(self._uploads)

    def get(self, scene_id: str) -> Upload | None:
        """The upload of that id."""
        return self._uploads.get(scene_id)

    def before(self, scene_id: str) -> Upload | None:
        """What who brought this upload had brought by the same name before, since the service began."""
        return self._uploads.get(self._before.get(scene_id, ""))

    def touch(self, scene_id: str) -> None:
        """Note that a scene is used: it goes last when room is made."""
        if scene_id in self._uploads:
            self._uploads[scene_id] = self._uploads.pop(scene_id)

    async def add(
        self,
        name: str,
        length: int | None,
        body: AsyncIterator[bytes],
        in_use: Callable[[str], bool],
        options: ImportOptions = DEFAULT_OPTIONS,
    ) -> Upload:
        """Take in the file that a client calls `name`, of `length` bytes if that is known, and check it as it is read.

        Of one client's files one is read at a time, so that those of others, and of the folder, have turns.

        Older uploads that are not `in_use` (asked by id) make room. Raises SceneError (name or content are wrong),
        TooLargeError, TooSlowError, NoRoomError or TooBusyError; nothing is kept then.
        """
        stem, suffix = clean_name(name)
        if length is not None and length > self._max_bytes:
            raise self._too_large()
        if self._taking >= MAX_AT_ONCE:
            raise TooBusyError(f"{self._taking} uploads are on their way already; try again later")
        self._taking += 1
        work: Path | None = None
        try:
            work = self._folder / f"{UNFINISHED}{secrets.token_hex(8)}"
            (work / "scene").mkdir(parents=True)
            file = work / ("archive.zip" if suffix == ARCHIVE else f"scene/{stem}{suffix}")
            self._claims[work] = 0
            await self._receive(file, body, lambda more: self._claim(work, more, in_use))
            async with self._reading.setdefault(asker.get(), asyncio.Lock()):
                if suffix == ARCHIVE:
                    checked = await self._check_archive(file, f"{stem}{suffix}", options, in_use)
                else:
                    checked = await self._check(file, f"{stem}{suffix}", options)
            return await self._keep(stem, work, checked, in_use)
        except OSError as error:
            log.warning("an upload cannot be kept in %s: %s", self._folder, error.strerror or error)
            raise NoRoomError(f"{stem}{suffix}: cannot be kept: {error.strerror or error}") from None
        finally:
            self._taking -= 1
            if work is not None:
                try:
                    await asyncio.to_thread(shutil.rmtree, work, ignore_errors=True)
                finally:  # the client may leave this instant
                    self._claims.pop(work, None)

    async def remove(self, scene_id: str, why: str = "it was asked for") -> None:
        """Delete an upload; UnknownSceneError when there is none of that id. why: for the log."""
        upload = self._uploads.pop(scene_id, None)
        if upload is None:
            raise UnknownSceneError(f"scene: there is no upload {scene_id!r}; /api/v1/scenes lists what there is")
        log.info("upload deleted: %s", why, extra={"scene": scene_id, "bytes": upload.bytes, "address": asker.get()})
        self._brought = {what: id_ for what, id_ in self._brought.items() if id_ != scene_id}
        self._before = {id_: before for id_, before in self._before.items() if scene_id not in (id_, before)}
        record_of(self._folder, upload).unlink(missing_ok=True)
        await asyncio.to_thread(shutil.rmtree, self._folder / upload.folder, ignore_errors=True)

    async def _receive(self, file: Path, body: AsyncIterator[bytes], claim: Claim) -> None:
        received, pending, began = 0, bytearray(), monotonic()
        pieces = aiter(body)
        with file.open("xb") as target:
            while True:
                try:
                    async with asyncio.timeout(STALL_SECONDS):
                        piece = await anext(pieces, None)
                except TimeoutError:
                    raise TooSlowError(f"nothing of the file came for {STALL_SECONDS:g} s; upload it again") from None
                received += len(piece or b"")
                if received < MIN_RATE * (monotonic() - began - STALL_SECONDS):
                    raise TooSlowError(f"the file comes with less than {MIN_RATE} bytes a second; upload it again")
                if received > self._max_bytes:
                    raise self._too_large()
                pending += piece or b""
                if piece is None or len(pending) >= CHUNK_BYTES:
                    await claim(len(pending))
                    await asyncio.to_thread(target.write, pending)
                    pending = bytearray()
                if piece is None:
                    return

    async def _check(self, file: Path, name: str, options: ImportOptions) -> Checked:
        try:
            return await self._checker.check(str(file), name, None, options)
        except SceneError as error:
            if not error.field.endswith(".uri"):
                raise
            hint = "upload a .glb, a .zip with the files that it refers to, or all of them at once in the page"
            raise SceneError(name, error.field, f"{error.problem}; {hint}") from None

    async def _check_archive(
        self, file: Path, name: str, options: ImportOptions, in_use: Callable[[str], bool]
    ) -> Checked:
        """As `_check`; what an archive needs is not known before: it may have what most need, or else what it says."""
        work, archive = file.parent, file.stat().st_size
        most = max(min(self._max_total_bytes - self._taken, USUAL_RATIO * archive), 0)
        self._claims[work] += most
        try:
            checked = await self._checker.check(str(file), name, str(work / "scene"), options, most)
        except UnpackedError as error:
            self._claims[work] -= most
            if error.size > self._max_total_bytes - archive:
                raise UnpackedError(name, error.size, self._max_total_bytes - archive) from None
            await self._claim(work, error.size, in_use)
            return await self._checker.check(str(file), name, str(work / "scene"), options, error.size)
        self._claims[work] += await asyncio.to_thread(size_of, work / "scene") - most
        return checked

    async def _keep(self, stem: str, work: Path, checked: Checked, in_use: Callable[[str], bool]) -> Upload:
        async with self._keeping:
            return await self._keep_alone(stem, work, checked, in_use)

    async def _keep_alone(self, stem: str, work: Path, checked: Checked, in_use: Callable[[str], bool]) -> Upload:
        folder = work / "scene"
        scene = PurePosixPath(Path(checked.source).relative_to(folder))
        size = await asyncio.to_thread(size_of, folder)
        await self._make_room(0, in_use, places=1)
        id_ = self._free_id(stem, scene.suffix.lower())
        upload = Upload(
            id=id_,
            folder=f"{time_ns():020d}",
            bytes=size,
            checked=checked.model_copy(
                update={"source": str(scene), "info": checked.info.model_copy(update={"id": id_, "name": stem})}
            ),
        )
        keep_upload(self._folder, upload, folder)
        self._claims[work] -= size
        self._uploads[id_] = upload
        what = asker.get(), f"{stem}{scene.suffix.lower()}"
        if what in self._brought:
            self._before[id_] = self._brought[what]
        self._brought[what] = id_
        self.kept += 1
        log.info("upload kept", extra={"scene": id_, "bytes": size, "address": asker.get()})
        return upload

    async def _claim(self, work: Path, more: int, in_use: Callable[[str], bool]) -> None:
        """Count `more` bytes that an unfinished upload is about to take; NoRoomError when they are not to be had."""
        async with self._keeping:
            await self._make_room(more, in_use)
            self._claims[work] += more

    @property
    def _taken(self) -> int:
        """By uploads and by those that are not finished [bytes]."""
        return sum(upload.bytes for upload in self._uploads.values()) + sum(self._claims.values())

    async def _make_room(self, size: int, in_use: Callable[[str], bool], places: int = 0) -> None:
        while len(self._uploads) + places > self._max_count or self._taken + size > self._max_total_bytes:
            # Asked each time: while one is deleted, somebody may come to look at the next.
            idle = next((id_ for id_ in self._uploads if not in_use(id_)), None)
            if idle is None:
                raise NoRoomError(
                    f"uploads take up to {self._max_total_bytes} bytes and {self._max_count} scenes here, and those in "
                    "use or on their way leave no room for this one; delete some, or try again when they are left"
                )
            await self.remove(idle, "another one needs its room")

    def _free_id(self, stem: str, suffix: str) -> str:
        number, id_ = 1, f"{PREFIX}{stem}{suffix}"
        while id_ in self._uploads or id_.endswith(EXPORT):
            number += 1
            id_ = f"{PREFIX}{stem}-{number}{suffix}"
        return id_

    def path(self, upload: Upload) -> Path:
        """Where the scene's file is."""
        return self._folder / upload.folder / upload.checked.source

    def _too_large(self) -> TooLargeError:
        return TooLargeError(f"the file is larger than the {self._max_bytes} bytes that this server takes")


def clean_name(name: str) -> tuple[str, str]:
    """A client's file name as a stem safe in ids, paths and pages, and a known suffix; SceneError without one."""
    given = PurePosixPath(normalize("NFC", name).replace("\\", "/"))
    suffix = given.suffix.lower()
    if suffix not in (*SUFFIXES, ARCHIVE):
        known = ", ".join((*SUFFIXES, ARCHIVE))
        raise SceneError(given.name[:60] or "name", "", f"is not a scene by its name; upload one of {known}")
    stem = "".join(letter if letter.isalnum() or letter in "-_. " else "-" for letter in given.stem)
    stem = stem.strip(". ")[:MAX_STEM].encode()[:200].decode(errors="ignore").strip(". ")
    return stem or "scene", suffix
