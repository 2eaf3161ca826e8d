import os
from pathlib import Path

import pytest

from server.results import PICTURE, RECORD, Result, save, take

ONE = Result(id="0123456789abcdef", scene="room", size=(8, 4), frames=1, media_type="image/png")
TWO = ONE.model_copy(update={"id": "fedcba9876543210"})


def test_results_are_taken_once(tmp_path: Path) -> None:
    assert save(tmp_path / "results", [(ONE, b"one"), (TWO, b"two")]) == 2
    assert take(tmp_path / "results", 100) == [(ONE, b"one"), (TWO, b"two")]
    assert take(tmp_path / "results", 100) == []


def test_no_more_is_taken_than_may_be_kept(tmp_path: Path) -> None:
    save(tmp_path, [(ONE, b"one"), (TWO, b"two")])
    assert len(take(tmp_path, 5)) == 1


def test_a_picture_that_was_not_written_to_its_end_goes(tmp_path: Path) -> None:
    for each in (ONE, TWO):
        save(tmp_path, [(each, b"picture")])
    (tmp_path / f"{ONE.id}{RECORD}").unlink()  # which is written last
    (tmp_path / f"holiday{PICTURE}").write_bytes(b"of somebody")
    assert take(tmp_path, 100) == [(TWO, b"picture")]
    assert [it.name for it in tmp_path.iterdir()] == [f"holiday{PICTURE}"]


def test_there_may_be_nothing(tmp_path: Path) -> None:
    assert take(tmp_path / "nowhere", 100) == []


def test_what_cannot_be_written_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "results").write_bytes(b"")
    assert save(tmp_path / "results", [(ONE, b"one")]) == 0
    assert "cannot be kept" in caplog.text


@pytest.mark.parametrize("way", ["link", "fifo", "folder", "nonsense", "another's", "no picture", "linked picture"])
def test_other_things_are_left_alone(tmp_path: Path, way: str, caplog: pytest.LogCaptureFixture) -> None:
    secret = tmp_path / "secret"
    secret.write_text(ONE.model_dump_json())
    folder = tmp_path / "results"
    save(folder, [(ONE, b"one")])
    record, picture = folder / f"{ONE.id}{RECORD}", folder / f"{ONE.id}{PICTURE}"
    (picture if "picture" in way else record).unlink()
    match way:
        case "link":
            record.symlink_to(secret)
        case "fifo":
            os.mkfifo(record)
        case "folder":
            record.mkdir()
        case "nonsense":
            record.write_bytes(b"\xff{")
        case "another's":
            record.write_text(TWO.model_copy(update={"id": "0" * 16}).model_dump_json())
        case "linked picture":
            picture.symlink_to(secret)
    assert take(folder, 10_000) == []
    assert secret.exists()
    assert "is not the result of a job" in caplog.text
