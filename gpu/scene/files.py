"""Files that a scene refers to: read only from the scene's own folder, and only up to a size."""

import base64
import binascii
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, unquote_to_bytes, urlsplit

from gpu.errors import SceneError
from gpu.scene.limits import SceneLimits
from gpu.scene.validate import check_count


def read_bytes(path: Path, limits: SceneLimits) -> bytes:
    """The content of a scene file. Raises SceneError when it is missing, not readable or larger than allowed."""
    try:
        check_count(str(path), "bytes", path.stat().st_size, limits.max_file_bytes, "max_file_bytes")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        problem = getattr(error, "strerror", None) or str(error)
        raise SceneError(str(path), "", f"cannot be read: {problem}") from error


def confined_file(scene: Path, name: str, field: str) -> Path | None:
    """The file called `name`, relative to the folder of `scene` and inside it; None when there is none.

    field: where the scene names it. Raises SceneError for an absolute path, a "..", or a link out of the folder.
    """
    relative = PurePosixPath(name.replace("\\", "/"))
    folder = scene.parent.resolve()
    try:
        path = (folder / relative).resolve()
        inside = not relative.is_absolute() and ".." not in relative.parts and path.is_relative_to(folder)
        if inside:
            return path if path.is_file() else None
    except (OSError, ValueError, RuntimeError):  # a name too long or with a NUL, or a loop of links
        return None
    raise SceneError(str(scene), field, f"{name!r} is outside the scene's folder; put the file beside the scene")


def read_uri(scene: Path, uri: str, field: str, limits: SceneLimits) -> bytes:
    """What `uri` holds: a data URI's bytes, or those of a file in the scene's folder. Raises SceneError otherwise."""
    if uri[:5].lower() == "data:":
        return _data_uri(scene, uri, field)
    try:
        scheme = urlsplit(uri).scheme
    except ValueError:
        scheme = "?"
    if scheme:
        raise SceneError(str(scene), field, f"{uri[:60]!r} is not a data URI or a file beside the scene; put it there")
    path = confined_file(scene, unquote(uri), field)
    if path is None:
        raise SceneError(str(scene), field, f"{uri[:60]!r} does not exist beside the scene")
    return read_bytes(path, limits)


def _data_uri(scene: Path, uri: str, field: str) -> bytes:
    head, comma, data = uri[5:].partition(",")
    try:
        if comma and head.lower().endswith(";base64"):
            return base64.b64decode(unquote(data), validate=True)
        if comma:
            return unquote_to_bytes(data)
    except (binascii.Error, ValueError) as error:
        raise SceneError(str(scene), field, f"broken base64 in a data URI: {error}") from error
    raise SceneError(str(scene), field, "a data URI without a comma")
