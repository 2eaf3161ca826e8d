"""Uploads as they lie in their folder: each has a folder of its own, and beside that its record, which tells all that
is known of it, so that another service finds it again.
"""

import logging
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gpu.scene.import_options import ImportOptions
from server.plain_files import read_plain
from server.scenes.checked import Checked

RECORD, UNFINISHED = ".upload.json", ".upload-"
MAX_RECORD_BYTES = 2**22  # far more than what a scene may say of itself
MAX_RECORDS = 20_000  # that are looked at: twice as many as uploads can be kept
_FOLDER = r"\d{20}"  # of an upload: the time that it came, so that names sort by age
log = logging.getLogger("lumenwalk.uploads")


class Upload(BaseModel):
    """A scene that was uploaded and is sound. folder: its own, by name; bytes: what that holds."""

    model_config = ConfigDict(frozen=True)

    id: str = Field(pattern=r"^uploads/[^/\x00]+$", max_length=300)
    folder: str = Field(pattern=f"^{_FOLDER}$")
    bytes: int = Field(ge=0)
    checked: Checked

    @property
    def options(self) -> ImportOptions:
        """How it is read unless told otherwise."""
        return self.checked.info.options


def record_of(folder: Path, upload: Upload) -> Path:
    """The file that is the record of an upload of a folder."""
    return folder / f"{upload.folder}{RECORD}"


def keep_upload(folder: Path, upload: Upload, files: Path) -> None:
    """Have an upload in a folder, its `files` moved there; nothing is kept where OSError says that it cannot be."""
    record = record_of(folder, upload)
    try:  # a record without a folder is nothing, a folder without a record goes at the next start
        record.write_text(upload.model_dump_json())
        files.rename(folder / upload.folder)
    except OSError:
        record.unlink(missing_ok=True)
        raise


def size_of(folder: Path) -> int:
    """Of all files in a folder [bytes]."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def kept_uploads(folder: Path) -> list[Upload]:
    """What earlier services left in a folder, the oldest first; what they did not finish is deleted."""
    for left in folder.glob(f"{UNFINISHED}*"):
        shutil.rmtree(left, ignore_errors=True)
    names = sorted(path.name for path in folder.iterdir())
    records = {name for name in names if name.endswith(RECORD)}
    for name in names:
        if re.fullmatch(_FOLDER, name) and f"{name}{RECORD}" not in records:
            shutil.rmtree(folder / name, ignore_errors=True)
    return list(_recorded(folder, sorted(records)[:MAX_RECORDS]))


def _recorded(folder: Path, names: list[str]) -> Iterator[Upload]:
    """The uploads of the records of these names; each is judged alone, and what is wrong with one is logged."""
    known = set[str]()
    for name in names:
        record = folder / name
        try:
            upload = Upload.model_validate_json(read_plain(record, MAX_RECORD_BYTES))
            if record != record_of(folder, upload) or upload.id in known:
                raise ValueError("of another upload")
            home = folder / upload.folder
            if not home.exists():
                record.unlink(missing_ok=True)
                continue
            scene = (home / upload.checked.source).resolve()
            if not (scene.is_file() and scene.is_relative_to(home)):
                raise ValueError("of a file that is not in its folder")
        except (OSError, ValueError, RuntimeError) as error:
            why = "not valid" if isinstance(error, ValidationError) else getattr(error, "strerror", None) or error
            log.warning("%r is not the record of an upload and is left alone: %s", str(record), why)
            continue
        known.add(upload.id)
        yield upload.model_copy(update={"bytes": size_of(home)})  # whatever the record says, by which others make room
