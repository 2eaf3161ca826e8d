import sys
from pathlib import Path

import pytest

from tests.bench import answers as module
from tests.bench.answers import answers, main

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_each_file_has_its_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.obj").write_text(TRIANGLE + "l 1 2\n")
    (tmp_path / "sub" / "b.obj").write_text("f 1 2 3\n")
    (tmp_path / "c.txt").write_text("no scene")
    read, refused = answers(tmp_path)
    assert (read.file, read.kind, read.triangles) == ("a.obj", "read", 1)
    assert any("no camera" in sentence for sentence in read.said)
    assert (refused.file, refused.kind) == ("sub/b.obj", "refused")
    assert refused.said[0].startswith("line 1: ")
    monkeypatch.setattr(sys, "argv", ["answers", str(tmp_path), "--json", str(tmp_path / "out.json")])
    assert main() == 0
    assert capsys.readouterr().out.splitlines()[-1] == "read 1, refused 1"


def test_what_users_would_meet_as_a_traceback_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: str) -> None:
        raise KeyError("corners")

    (tmp_path / "a.obj").write_text(TRIANGLE)
    monkeypatch.setattr(module, "load_scene", fail)
    monkeypatch.setattr(sys, "argv", ["answers", str(tmp_path)])
    assert answers(tmp_path)[0].said == ("KeyError: 'corners'",)
    assert main() == 1
