"""Files that systems leave beside a scene's own, by their names: no part of it, whatever they end in."""

from pathlib import PurePath

_FOLDERS = frozenset(
    {"__macosx", ".appledouble", ".trashes", ".spotlight-v100", ".fseventsd", "@eadir", "$recycle.bin"}
)
_FILES = frozenset({".ds_store", "thumbs.db", "ehthumbs.db", "desktop.ini"})
_APPLE_DOUBLE = "._"  # how names begin of what macOS keeps besides a file's content


def is_clutter(path: PurePath) -> bool:
    """Whether a file at `path`, below a scene's folder or in its archive, is none that a person put there."""
    names = [part.lower() for part in path.parts]
    return not _FOLDERS.isdisjoint(names) or any(name in _FILES or name.startswith(_APPLE_DOUBLE) for name in names)
