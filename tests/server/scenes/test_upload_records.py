import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from server.scenes.checked import Checked, SceneSize
from server.scenes.upload_records import (
    MAX_RECORD_BYTES,
    RECORD,
    UNFINISHED,
    Upload,
    keep_upload,
    kept_uploads,
    record_of,
)
from server.wire.browser import Bounds, SceneInfo

CONTENT = "content"
CHECKED = Checked(
    source="a.glb",
    info=SceneInfo(id="uploads/a.glb", name="a", cameras=(), bounds=Bounds(min=(0, 0, 0), max=(1, 1, 1)), triangles=1),
    size=SceneSize(vertices=3, triangles=1, uv_sets=0, colored=False, materials=1, texels=0),
)
UPLOAD = Upload(id="uploads/a.glb", folder="1" * 20, bytes=len(CONTENT), checked=CHECKED)


def keep(folder: Path, upload: Upload = UPLOAD) -> None:
    """Have an upload in a folder, as a service does."""
    files = folder / f"{UNFINISHED}7"
    files.mkdir(parents=True)
    (files / upload.checked.source).write_text(CONTENT)
    keep_upload(folder, upload, files)


def test_uploads_are_found_again_the_oldest_first(tmp_path: Path) -> None:
    newer = UPLOAD.model_copy(update={"id": "uploads/b.glb", "folder": "2" * 20})
    keep(tmp_path, newer)
    keep(tmp_path)
    assert kept_uploads(tmp_path) == [UPLOAD, newer]


def test_an_upload_that_cannot_be_kept_leaves_no_record(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        keep_upload(tmp_path, UPLOAD, tmp_path / "nowhere")
    assert list(tmp_path.iterdir()) == []


def test_what_a_service_did_not_finish_goes(tmp_path: Path) -> None:
    keep(tmp_path)
    record_of(tmp_path, UPLOAD).unlink()  # as an interrupted deletion does
    (tmp_path / f"{UNFINISHED}8").mkdir()
    assert kept_uploads(tmp_path) == []
    assert list(tmp_path.iterdir()) == []


def _folder(path: Path) -> None:
    path.mkdir()


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _link(path: Path) -> None:
    path.symlink_to("/nonexistent")


def _huge(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(MAX_RECORD_BYTES + 1)


@pytest.mark.parametrize("kind", [_folder, _pipe, _link, _huge])
def test_what_is_called_as_records_are_and_is_none_is_left_alone(
    tmp_path: Path, kind: Callable[[Path], None], caplog: pytest.LogCaptureFixture
) -> None:
    keep(tmp_path)
    odd = tmp_path / f"{7:020d}{RECORD}"
    kind(odd)
    assert kept_uploads(tmp_path) == [UPLOAD]
    assert odd.is_symlink() or odd.exists()
    assert "is not the record of an upload" in caplog.text


@pytest.mark.parametrize(
    "change",
    [
        {"folder": "../victim"},
        {"folder": "/etc"},
        {"folder": "a\0b"},
        {"folder": "00000000000000000001"},
        {"id": "cornell-box"},
        {"id": "uploads/../x.glb"},
        {"bytes": -1},
        {"source": "../../victim/a.glb"},
        {"source": "{victim}"},
        {"source": "link.glb"},
        {"source": "a\0.glb"},
    ],
)
def test_a_record_reaches_nothing_outside_its_folder(tmp_path: Path, change: dict[str, Any]) -> None:
    victim = tmp_path / "victim" / "a.glb"
    victim.parent.mkdir()
    victim.write_text("kept")
    uploads = tmp_path / "uploads"
    keep(uploads)
    home, record = uploads / UPLOAD.folder, record_of(uploads, UPLOAD)
    (home / "link.glb").symlink_to(victim)
    told = json.loads(record.read_text())
    if "source" in change:
        told["checked"]["source"] = change["source"].replace("{victim}", str(victim))
    else:
        told |= change
    record.write_text(json.dumps(told))
    assert kept_uploads(uploads) == []
    assert victim.read_text() == "kept"
    assert home.exists()


def test_of_two_records_of_one_id_the_first_counts(tmp_path: Path) -> None:
    keep(tmp_path)
    keep(tmp_path, UPLOAD.model_copy(update={"folder": "9" * 20}))
    assert kept_uploads(tmp_path) == [UPLOAD]


def test_an_upload_is_as_large_as_it_is_whatever_its_record_says(tmp_path: Path) -> None:
    keep(tmp_path, UPLOAD.model_copy(update={"bytes": 2**40}))
    assert kept_uploads(tmp_path) == [UPLOAD]
