from pathlib import Path
from subprocess import CalledProcessError

import pytest

from tests.bench import first_picture
from tests.bench.first_picture import main, seconds


def test_a_command_that_fails_is_no_time(tmp_path: Path) -> None:
    with pytest.raises(CalledProcessError):
        seconds(tmp_path, "warm", "--no-such-option")


def test_each_scene_has_a_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    ran: list[tuple[str, ...]] = []

    def note(_: Path, *arguments: str) -> float:
        ran.append(arguments)
        return 1.0

    monkeypatch.setattr(first_picture, "seconds", note)
    monkeypatch.setattr(first_picture, "seconds_to_ready", lambda *_: 2.0)
    main("cpu", ("one", "two"))
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["scene", "one", "two"]
    assert [arguments[:1] for arguments in ran] == [("warm",), ("render",), ("warm",), ("render",), ("warm",)]
