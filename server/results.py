"""Pictures of finished jobs, kept in a folder from one run of the service to the next.

What is found there is taken for what it says only as far as it is a regular file of a job's name and of limited size.
"""

import logging
import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from server.plain_files import read_plain

FOLDER = "results"
RECORD, PICTURE = ".job.json", ".picture"
MAX_RECORD_BYTES = 65_536
_RECORD, _PICTURE = (re.compile(r"([0-9a-f]{16})" + re.escape(it)) for it in (RECORD, PICTURE))
log = logging.getLogger("lumenwalk.jobs")


class Result(BaseModel):
    """A finished job, without its picture."""

    model_config = ConfigDict(frozen=True)

    id: str = Field(pattern="^[0-9a-f]{16}$")
    scene: str = Field(max_length=1024)
    size: tuple[int, int]
    frames: int = Field(ge=1)
    pictures: int = Field(default=1, ge=1)
    media_type: str = Field(max_length=100, pattern=r"^[\w/.+-]+$")


def save(folder: Path, results: Iterable[tuple[Result, bytes]]) -> int:
    """Write results into a folder; how many. What cannot be written is lost, and the log says why."""
    count = 0
    try:
        folder.mkdir(exist_ok=True)
        for result, picture in results:
            (folder / f"{result.id}{PICTURE}").write_bytes(picture)
            (folder / f"{result.id}{RECORD}").write_text(result.model_dump_json())  # the last: now it is whole
            count += 1
    except OSError as error:
        log.warning("%s: results of jobs cannot be kept: %s", folder, error.strerror or error)
    return count


def take(folder: Path, most_bytes: int) -> list[tuple[Result, bytes]]:
    """The results in a folder, of so many bytes at most, the oldest first; they are taken from it, and pictures that
    were not written to their end go.
    """
    found: list[tuple[float, Result, bytes]] = []
    names = {it.name for it in folder.iterdir()} if folder.is_dir() and not folder.is_symlink() else set()
    for name in names:
        if (picture := _PICTURE.fullmatch(name)) and f"{picture[1]}{RECORD}" not in names:
            with suppress(OSError):
                (folder / name).unlink()
    for record in map(folder.joinpath, sorted(names)):
        known = _RECORD.fullmatch(record.name)
        if known is None:
            continue
        file = record.with_name(f"{known[1]}{PICTURE}")
        try:
            result = Result.model_validate_json(read_plain(record, MAX_RECORD_BYTES))
            data = read_plain(file, most_bytes)
            if result.id != known[1]:
                raise ValueError(f"is the record of {result.id}")
            found.append((record.stat().st_mtime, result, data))
            most_bytes -= len(data)
        except (OSError, ValueError, ValidationError) as error:
            log.warning("%s is not the result of a job: %s", record, " ".join(str(error).split())[:200])
            continue
        record.unlink(missing_ok=True)
        file.unlink(missing_ok=True)
    return [(result, data) for _, result, data in sorted(found, key=lambda it: it[0])]
