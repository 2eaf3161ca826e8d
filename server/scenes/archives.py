"""A .zip with one scene and the files that it refers to, unpacked so that nothing lands outside its folder."""

import stat
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from shutil import copyfileobj

from gpu.errors import SceneError
from gpu.scene.formats.package import MAX_RATIO, entry_name
from gpu.scene.formats.usd.layers import LAYERS
from gpu.scene.load import SUFFIXES
from server.scenes.clutter import is_clutter

MAX_FILES = 2000
MAX_DEPTH = 16
MAX_NAMED = 10  # scenes of an archive that has more than one
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 0x1


class UnpackedError(SceneError):
    """An archive would take more than it may. size: what it would take [bytes]."""

    def __init__(self, source: str, size: int, most: int) -> None:
        super().__init__(source, "", f"{size} bytes unpacked, more than the {most} allowed")
        self.size = size


def unpack(archive: Path, folder: Path, max_bytes: int) -> Path:
    """Unpack `archive` into `folder` and return its one scene file.

    Raises SceneError (source: the archive's name) when it is broken, would take more than `max_bytes`, has a name
    that is absolute or has "..", a link, an encrypted file, or not exactly one scene.
    """
    try:
        with zipfile.ZipFile(archive) as opened:
            entries = _checked(archive, opened, max_bytes)
            for path, entry in entries.items():
                target = folder / path
                target.parent.mkdir(parents=True, exist_ok=True)
                with opened.open(entry) as source, target.open("xb") as file:
                    copyfileobj(source, file)
    except (zipfile.BadZipFile, EOFError, ValueError, NotImplementedError) as error:
        raise SceneError(archive.name, "", f"not a .zip file that can be unpacked: {error}") from None
    except OSError as error:  # whose text would name a path of ours
        raise SceneError(archive.name, "", f"the .zip file cannot be unpacked: {error.strerror or 'broken'}") from None
    except zlib.error as error:
        raise SceneError(archive.name, "", f"broken data in the .zip file: {error}") from None
    return folder / _one_scene(archive, list(entries))


def _one_scene(archive: Path, paths: list[PurePosixPath]) -> PurePosixPath:
    """The scene among `paths`; layers deeper than another are what that one is made of. Raises SceneError."""
    scenes = [path for path in paths if path.suffix.lower() in SUFFIXES]
    if all(path.suffix.lower() in LAYERS for path in scenes):
        scenes = [path for path in scenes if len(path.parts) == min(len(scene.parts) for scene in scenes)]
    if len(scenes) == 1:
        return scenes[0]
    inner = [path for path in paths if path.suffix.lower() == ".zip"]
    if scenes:
        more = f" and {len(scenes) - MAX_NAMED} more" if len(scenes) > MAX_NAMED else ""
        problem = f"{len(scenes)} scenes ({', '.join(map(str, scenes[:MAX_NAMED]))}{more}); give one of them"
    elif inner:
        problem = f"no scene but another archive ({inner[0]}); put that one's files in"
    else:
        problem = f"no scene; put one of {', '.join(SUFFIXES)} in it"
    raise SceneError(archive.name, "", f"{problem}, with its side files")


def _checked(archive: Path, opened: zipfile.ZipFile, max_bytes: int) -> dict[PurePosixPath, zipfile.ZipInfo]:
    """The files by their path inside the archive, before any is unpacked."""
    entries: dict[PurePosixPath, zipfile.ZipInfo] = {}
    total = 0
    for entry in opened.infolist():
        name = entry_name(entry).replace("\\", "/")
        if name.endswith("/") or is_clutter(PurePosixPath(name)):
            continue
        path = _inside(archive, name)
        if stat.S_IFMT(entry.external_attr >> 16) not in (0, stat.S_IFREG):
            raise SceneError(archive.name, f"{name!r:.60}", "is a link or a device; put the file itself in")
        if entry.flag_bits & _ENCRYPTED or entry.compress_type not in _METHODS:
            raise SceneError(archive.name, f"{name!r:.60}", "is encrypted or packed unusually; use plain deflate")
        if path in entries:
            raise SceneError(archive.name, f"{name!r:.60}", "is there twice; leave one out")
        entries[path] = entry
        total += entry.file_size
    if len(entries) > MAX_FILES:
        raise SceneError(archive.name, "", f"{len(entries)} files, more than the {MAX_FILES} allowed")
    if total > MAX_RATIO * archive.stat().st_size:
        raise SceneError(archive.name, "", f"unpacks to more than {MAX_RATIO} times its size, as no scene does")
    if total > max_bytes:
        raise UnpackedError(archive.name, total, max_bytes)
    return entries


def _inside(archive: Path, name: str) -> PurePosixPath:
    path = PurePosixPath(name)
    wrong = (
        not path.parts
        or path.is_absolute()
        or ".." in path.parts
        or ":" in path.parts[0]
        or len(path.parts) > MAX_DEPTH
    )
    if wrong or any(len(part.encode()) > 255 or not part.isprintable() for part in path.parts):
        raise SceneError(archive.name, f"{name!r:.60}", "is not a plain name inside the archive; rename it")
    return path
