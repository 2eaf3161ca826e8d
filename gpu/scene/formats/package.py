"""Zip files that a scene comes in: .ifczip, .zae, .3mf."""

import io
import lzma
import zipfile
import zlib
from pathlib import Path

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.validate import check_count

MAX_RATIO = 200  # of unpacked to packed bytes: textures and meshes stay far below, bombs do not
_MARKED_UTF8 = 0x800
_BROKEN = (EOFError, NotImplementedError, OSError, RuntimeError, ValueError, lzma.LZMAError, zlib.error)


def entry_name(entry: zipfile.ZipInfo) -> str:
    """The name, in UTF-8 also where it is not marked as that: macOS and USD do not mark it, others mean CP437."""
    if entry.flag_bits & _MARKED_UTF8:
        return entry.filename
    try:
        return entry.filename.encode("cp437").decode()
    except UnicodeError:
        return entry.filename


class Package:
    """The zip file at `path`, which has `content`. What is read of it is no more than one file may have, in all, and no
    more than `MAX_RATIO` times what it is packed in.

    names: of its files, as they stand in it.
    """

    def __init__(self, path: Path, content: bytes, limits: SceneLimits) -> None:
        """Raises SceneError when it is no zip file."""
        self.path, self._limits, self._unpacked = path, limits, 0
        self._most = MAX_RATIO * len(content)
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(content))
        except (zipfile.BadZipFile, *_BROKEN) as error:
            raise self._unreadable(error) from error
        self._entries = {entry_name(entry): entry for entry in self._archive.infolist() if not entry.is_dir()}
        self.names = list(self._entries)

    def read(self, name: str) -> bytes:
        """The content of the file called `name`. Raises SceneError when it is broken or too much is unpacked."""
        entry = self._entries[name]
        self._unpacked += entry.file_size
        source, limit = str(self.path), self._limits.max_file_bytes
        check_count(source, "bytes unpacked", self._unpacked, limit, "max_file_bytes")
        if self._unpacked > self._most:
            raise ForbiddenError(source, "", f"unpacks to more than {MAX_RATIO} times its size, as no scene does")
        try:
            return self._archive.read(entry)
        except (zipfile.BadZipFile, *_BROKEN) as error:
            raise self._unreadable(error) from error

    def find(self, name: str) -> str | None:
        """The file called `name`, a path from the package's root in any case of letters; None when there is none."""
        wanted = name.replace("\\", "/").strip("/")
        alike = (known for known in self.names if known.strip("/").casefold() == wanted.casefold())
        return wanted if wanted in self._entries else next(alike, None)

    def _unreadable(self, error: BaseException) -> SceneError:
        kind = self.path.suffix.lower()
        return SceneError(str(self.path), "", f"not a {kind} file that can be unpacked: {error}")
