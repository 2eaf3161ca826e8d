"""The scene files of a folder that others fill: each entry is judged alone, and the walk is bounded in every way."""

import logging
import os
from collections import deque
from pathlib import Path, PurePosixPath
from stat import S_ISREG
from time import monotonic

from gpu.errors import brief
from gpu.scene.load import SUFFIXES
from server.scenes.clutter import is_clutter
from server.wire.browser import MAX_SCENE_ID

MAX_LISTED = 10_000  # scene files
MAX_LOOKED_AT = 200_000  # entries of all folders
MAX_DEPTH = 16
MAX_SECONDS = 5.0
log = logging.getLogger("lumenwalk.scenes")


def scene_files(folder: Path) -> dict[str, str]:
    """Whole paths of the scene files in `folder` by their path inside it, in the order of that.

    Left out are links that lead out of the folder, what is no plain file, what cannot be read, and names that cannot be
    shown (not UTF-8, with control characters, or with turns of the direction of writing) or asked for (longer than
    MAX_SCENE_ID); where there is too much, what is deepest. Folders that are links are not entered.
    """
    root = os.path.realpath(folder)
    found: dict[str, str] = {}
    looked, until = 0, monotonic() + MAX_SECONDS
    waiting = deque([(root, 0)])
    while waiting:
        directory, depth = waiting.popleft()
        try:
            with os.scandir(directory) as entries:
                for entry in entries:
                    looked += 1
                    if len(found) >= MAX_LISTED or looked > MAX_LOOKED_AT or monotonic() > until:
                        log.warning("%s has more than is looked at: %d scenes of it are listed", folder, len(found))
                        return dict(sorted(found.items()))
                    if entry.is_dir(follow_symlinks=False):
                        if depth < MAX_DEPTH:
                            waiting.append((entry.path, depth + 1))
                    elif entry.name.lower().endswith(SUFFIXES):
                        inside = entry.path[len(root) :].lstrip("/")
                        if _is_scene(entry, inside, root):
                            found[inside] = entry.path
        except OSError as error:
            log.debug("%r is not listed: %s", directory, error.strerror)
    return dict(sorted(found.items()))


def _is_scene(entry: "os.DirEntry[str]", inside: str, root: str) -> bool:
    try:
        if len(inside) > MAX_SCENE_ID or brief(inside, len(inside)) != inside:  # what would be shown is another name
            return False
        path = PurePosixPath(inside)
        if is_clutter(path) or path.suffix.lower() not in SUFFIXES or not S_ISREG(entry.stat().st_mode):
            return False
        return not entry.is_symlink() or Path(entry.path).resolve().is_relative_to(root)
    except (OSError, ValueError, RuntimeError):  # gone, not ours to see, or a link to itself
        return False
