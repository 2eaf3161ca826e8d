"""Scenes that all replicas share: a folder that all nodes see, or a store of objects, copied to each node."""

import logging
from pathlib import Path, PurePosixPath
from typing import Any

import fsspec

from gpu.errors import UserError

PART = ".part"  # of a file that is being fetched; no scene is called so
log = logging.getLogger("lumenwalk.storage")


class Mirror:
    """A folder of this node that holds what is at a URL of fsspec, such as s3://bucket/scenes."""

    def __init__(self, url: str, folder: Path) -> None:
        """UserError where there is no such kind of store, or what speaks to it is not installed."""
        try:
            self._store, self._root = fsspec.core.url_to_fs(url)
        except (ImportError, ValueError) as error:
            raise UserError(f"storage: {url}: {error}") from None
        self._folder = folder
        self._held: dict[str, Any] = {}  # what is here, with what tells its versions apart

    def update(self) -> None:
        """Fetch what is new or has changed, and delete what is gone; what goes wrong with a file is logged, and it is
        tried again the next time. Raises the store's errors when it cannot be read at all.
        """
        self._store.invalidate_cache()
        found = self._store.find(self._root, detail=True)
        there = {name: it for path, it in found.items() if (name := self._name(path)) is not None}
        for name in self._held.keys() - there.keys():
            (self._folder / name).unlink(missing_ok=True)
            del self._held[name]
        for name, entry in there.items():
            version = _version(entry)
            if self._held.get(name) == version:
                continue
            try:
                self._fetch(entry["name"], self._folder / name)
                self._held[name] = version
            except Exception as error:  # each kind of store has errors of its own
                log.warning("%s cannot be fetched: %s", name, error)

    def _name(self, path: str) -> str | None:
        """The path of a file below the URL; None where it would lead out of the folder."""
        name = PurePosixPath(path.removeprefix(self._root).lstrip("/"))
        return str(name) if name.parts and ".." not in name.parts and name.suffix != PART else None

    def _fetch(self, source: str, target: Path) -> None:
        """In the place of an older version at once, so that nobody reads half a file."""
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(target.name + PART)
        self._store.get_file(source, str(part))
        part.replace(target)


def _version(entry: dict[str, Any]) -> tuple[Any, ...]:
    """What stores say of a file that changes with it."""
    return tuple(entry.get(key) for key in ("ETag", "etag", "mtime", "LastModified", "created", "size"))
