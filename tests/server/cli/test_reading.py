"""What a command says when its scene's reader, a process of its own, answers, crashes or is killed."""

import re
import sys
from pathlib import Path

import pytest

from gpu.errors import UserError
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions
from server.cli import reading
from server.cli.main import main
from server.cli.reading import read_scene

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.fixture
def file(tmp_path: Path) -> str:
    (tmp_path / "wall.obj").write_text(TRIANGLE)
    return str(tmp_path / "wall.obj")


def test_a_file_is_read_by_another_process_as_told(file: str) -> None:
    scene = read_scene(file, ImportOptions(unit="cm"))
    assert scene.triangles.tolist() == [[0, 1, 2]]
    assert scene.frame.metres_per_unit == 0.01


def test_what_is_wrong_with_a_file_is_said_as_if_read_here(tmp_path: Path) -> None:
    (tmp_path / "wall.obj").write_text(TRIANGLE + "f 1 2 9\n")
    with pytest.raises(UserError, match=r"^\S*wall\.obj: line 5: .*9"):
        read_scene(str(tmp_path / "wall.obj"), DEFAULT_OPTIONS)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import os; os.abort()", "cannot be read: its reader ended with SIGABRT; the file is broken"),
        ("import ctypes; ctypes.string_at(0)", "cannot be read: its reader ended with SIGSEGV; the file is broken"),
        ("import os; os.write(1, b'\\x80\\x05'); os._exit(3)", "cannot be read: its reader ended with status 3"),
        ("print('not a pickle'); raise SystemExit('bad unit')", r"status 1; the file is broken \(bad unit\)"),
        ("import os; os.kill(os.getpid(), 9)", "killed by the system, which ran out of memory"),
    ],
)
@pytest.mark.parametrize("command", ["info", "render"])
def test_a_reader_that_crashes_is_told_in_one_sentence(
    file: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
    code: str,
    said: str,
) -> None:
    monkeypatch.setattr(reading, "_READ", (sys.executable, "-I", "-c", code))
    assert main([command, file, *([str(tmp_path / "out.png")] if command == "render" else [])]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"lumenwalk: error: {file}: ")
    assert re.search(said, line)
