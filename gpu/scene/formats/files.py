"""Files that a scene refers to: read only from the scene's own folder, and only up to a size."""

import base64
import binascii
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path, PurePosixPath, PureWindowsPath
from stat import S_ISREG
from unicodedata import normalize
from urllib.parse import unquote, unquote_to_bytes, urlsplit

from gpu.errors import ForbiddenError, SceneError
from gpu.scene.limits import MOST_BESIDE, SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.validate import check_count

_noted: ContextVar[dict[Path, int] | None] = ContextVar("files that a scene is read with", default=None)
_LFS_POINTER = b"version https://git-lfs"


def read_bytes(path: Path, limits: SceneLimits) -> bytes:
    """The content of a scene file. Raises SceneError when it is missing, not readable or larger than allowed."""
    try:
        # A pipe would be waited for, and one may take a file's place between two looks.
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            status = os.fstat(file.fileno())
            if not S_ISREG(status.st_mode):
                raise ValueError("it is no plain file")
            check_count(str(path), "bytes", status.st_size, limits.max_file_bytes, "max_file_bytes")
            content = file.read(status.st_size)
    except (OSError, ValueError) as error:
        problem = getattr(error, "strerror", None) or str(error)
        raise SceneError(str(path), "", f"cannot be read: {problem}") from error
    if content.startswith(_LFS_POINTER):
        raise SceneError(str(path), "", "is a pointer of Git LFS, not the file itself; fetch that with `git lfs pull`")
    return content


@contextmanager
def noting_files() -> Iterator[dict[Path, int]]:
    """What is looked for beside scenes meanwhile, up to MOST_BESIDE: where, and when it was written [ns], 0 where it is
    not there.
    """
    found: dict[Path, int] = {}
    before = _noted.set(found)
    try:
        yield found
    finally:
        _noted.reset(before)


def written_at(path: Path) -> int:
    """When a file was written [ns], 0 where there is none."""
    try:
        return path.stat().st_mtime_ns
    except (OSError, ValueError):
        return 0


def confined_file(scene: Path, name: str, field: str) -> Path | None:
    """The file called `name`, relative to the folder of `scene` and inside it; None when there is none.

    A name that differs in the case of letters, or in how accents are composed, is found where no other is exact.
    field: where the scene names it. Raises ForbiddenError for an absolute path, a ".." or a link out of the folder.
    """
    relative = PurePosixPath(name.replace("\\", "/"))
    folder = scene.parent.resolve()
    inside = Path(os.path.normpath(folder / relative))
    if relative.is_absolute() or not inside.is_relative_to(folder):
        raise _outside(scene, name, field)
    try:
        path = folder
        for part in inside.relative_to(folder).parts:
            path = _alike(path, part)
            if not path.resolve().is_relative_to(folder):
                raise _outside(scene, name, field)
        if (noted := _noted.get()) is not None and len(noted) < MOST_BESIDE:
            noted.setdefault(path, written_at(path))
        return path if path.is_file() else None
    except (OSError, ValueError, RuntimeError):  # a name too long or with a NUL, or a loop of links
        return None


def file_beside(scene: Path, name: str, field: str, remarks: Remarks) -> Path | None:
    """As `confined_file`, for names that come from another machine too; what was found otherwise than named is said.

    Of an absolute path, of Windows or not, or a file: URI, as much of the end is taken as is in the folder of `scene`.
    """
    path = re.sub(r"^file:(//[^/]*)?", "", name, flags=re.IGNORECASE)
    elsewhere = path != name or PureWindowsPath(path).anchor != ""
    found, wanted = None, name
    for wanted in ends_in(scene.parent, path) if elsewhere else [name]:
        found = confined_file(scene, wanted, field)
        if found is not None:
            break
    if found is not None:
        shown = found.relative_to(scene.parent.resolve()).as_posix()
        if elsewhere or shown != PurePosixPath(wanted.replace("\\", "/")).as_posix():
            remarks.add(f"{name[-60:]!r} was read from {shown!r} beside the scene", field)
    return found


def ends_in(folder: Path, path: str) -> list[str]:
    """The ends of another machine's absolute path that begin with what is in `folder`, the longest first; of a path
    without any, its name.
    """
    there = set[str]()
    with suppress(OSError):
        there.update(_folded(one.name) for one in folder.iterdir())
    pure = PureWindowsPath(path)
    parts = pure.relative_to(pure.anchor).parts
    ends = [parts[begin:] for begin, part in enumerate(parts) if _folded(part) in there]
    return ["/".join(end) for end in ends if ".." not in end] or [pure.name]


def read_uri(scene: Path, uri: str, field: str, limits: SceneLimits, remarks: Remarks) -> bytes:
    """What `uri` holds: a data URI's bytes, or those of a file in the scene's folder. Raises SceneError otherwise."""
    if uri[:5].lower() == "data:":
        return _data_uri(scene, uri, field)
    if _remote(uri):
        raise SceneError(str(scene), field, f"{uri[:60]!r} is not fetched from the network; put it beside the scene")
    for name in dict.fromkeys((unquote(uri), uri, unquote(re.split("[?#]", uri, maxsplit=1)[0]))):
        path = file_beside(scene, name, field, remarks)
        if path is not None:
            return read_bytes(path, limits)
    raise SceneError(str(scene), field, f"{uri[-60:]!r} does not exist beside the scene")


def _outside(scene: Path, name: str, field: str) -> ForbiddenError:
    problem = f"{name[:60]!r} is outside the scene's folder; put the file in it, or the scene where both are below it"
    return ForbiddenError(str(scene), field, problem)


def _alike(folder: Path, name: str) -> Path:
    """The path in `folder` that is `name`, or else is it but for case and composition; if there is none, `name`."""
    if folder.is_dir() and not (folder / name).exists():
        for path in sorted(folder.iterdir()):
            if _folded(path.name) == _folded(name):
                return path
    return folder / name


def _folded(name: str) -> str:
    return normalize("NFC", name).casefold()


def _remote(uri: str) -> bool:
    try:
        parts = urlsplit(uri)
    except ValueError:
        return False
    return parts.scheme not in ("", "file") and (parts.netloc != "" or parts.scheme == "blob")


def _data_uri(scene: Path, uri: str, field: str) -> bytes:
    head, comma, data = uri[5:].partition(",")
    try:
        if comma and head.lower().endswith(";base64"):
            packed = "".join(unquote(data).split())
            return base64.b64decode(packed + "=" * (-len(packed) % 4), validate=True)
        if comma:
            return unquote_to_bytes(data)
    except (binascii.Error, ValueError) as error:
        raise SceneError(str(scene), field, f"broken base64 in a data URI: {error}") from error
    raise SceneError(str(scene), field, "a data URI without a comma")
