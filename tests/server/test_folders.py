import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from server.folders import LOCK, TemporaryFolder, hold, remove_abandoned

ROOT = str(Path(__file__).parents[2])
LEAVES = "from server.folders import TemporaryFolder; print(TemporaryFolder().path, flush=True); input()"


@pytest.fixture(autouse=True)
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_a_folder_has_one_holder_at_a_time(tmp_path: Path) -> None:
    first = hold(tmp_path)
    assert first is not None
    assert hold(tmp_path) is None
    os.close(first)
    second = hold(tmp_path)
    assert second is not None
    os.close(second)


def test_a_temporary_folder_goes_with_what_is_in_it() -> None:
    folder = TemporaryFolder()
    (folder.path / "file").write_text("x")
    folder.remove()
    assert not folder.path.exists()


def test_a_temporary_folder_that_another_process_is_about_to_delete_is_not_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    others: list[int] = []

    def late(folder: Path) -> int | None:
        if not others and (descriptor := hold(folder)) is not None:
            others.append(descriptor)
        return hold(folder)

    monkeypatch.setattr("server.folders.hold", late)
    folder = TemporaryFolder()
    os.close(others[0])
    assert hold(folder.path) is None
    folder.remove()


def test_what_a_killed_process_leaves_goes_at_the_next_start(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": ROOT, "TMPDIR": str(tmp_path)}
    command = [sys.executable, "-c", LEAVES]
    with subprocess.Popen(command, stdin=-1, stdout=-1, text=True, env=environment) as process:
        assert process.stdout is not None
        left = Path(process.stdout.readline().strip())
        remove_abandoned(tmp_path)
        assert left.exists()
        process.send_signal(signal.SIGKILL)
    assert left.exists()
    TemporaryFolder().remove()
    assert not left.exists()


def test_what_is_not_ours_stays(tmp_path: Path) -> None:
    (tmp_path / "other" / "kept").mkdir(parents=True)
    (tmp_path / "other" / LOCK).write_text("")
    (tmp_path / "lumenwalk-link").symlink_to(tmp_path / "other")
    (tmp_path / "lumenwalk-file").write_text("")
    (tmp_path / "lumenwalk-without-lock").mkdir()
    remove_abandoned(tmp_path)
    assert (tmp_path / "other" / "kept").exists()
    assert len(list(tmp_path.iterdir())) == 4
