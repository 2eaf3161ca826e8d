"""The commands, against a service with gradients for pictures."""

import json
from pathlib import Path

import pytest

from tests.load.__main__ import main
from tests.load.target import Target

SHORT = ("--size", "96x54", "--seconds", "1", "--warm-up", "0.1")


def command(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr("sys.argv", ["load", *arguments])
    return main()


def test_a_run_that_meets_its_level_ends_with_0_and_one_that_does_not_with_1(
    target: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = ("run", "--url", target.url, "--viewers", "2", *SHORT, "--out", str(tmp_path))
    assert command(monkeypatch, *run, "--age", "10000", "--fps", "0.1", "--rest-rate", "4") == 0
    results = json.loads((tmp_path / "run.json").read_text())
    assert results["options"]["size"] == [96, 54]
    assert "scene" not in results["options"]  # the service's own
    row = results["rows"][0]
    assert row["viewers"] == 2
    assert row["rest"]["statuses"] == {"200": 4}
    assert "bottleneck" in capsys.readouterr().out
    assert command(monkeypatch, *run, "--fps", "1000") == 1
    assert "viewer" in capsys.readouterr().err


def test_a_ramp_says_how_many_get_the_level(
    target: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ramp = ("ramp", "--url", target.url, *SHORT, "--age", "10000", "--fps", "0.1", "--out", str(tmp_path))
    assert command(monkeypatch, *ramp, "--viewers", "2,1", "--require", "2") == 0
    results = json.loads((tmp_path / "ramp.json").read_text())
    assert results["largest"] == 2
    assert [row["viewers"] for row in results["rows"]] == [1, 2]
    assert command(monkeypatch, *ramp, "--viewers", "1,7", "--require", "2") == 1  # six are let in
    assert "1 viewers get the service level" in capsys.readouterr().out


def test_stills_that_fail_end_with_1(target: Target, monkeypatch: pytest.MonkeyPatch) -> None:
    rest = ("rest", "--url", target.url, "--rate", "8", "--seconds", "0.5")
    assert command(monkeypatch, *rest) == 0
    assert command(monkeypatch, *rest, "--size", "16000x16000") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "--url", "http://example.org"), "--remote"),
        (("run", "--url", "http://127.0.0.1:9"), "error"),
        (("run", "--url", "http://127.0.0.1:9", "--path", "nowhere.jsonl"), "nowhere.jsonl"),
        (("faults",), "--serve"),
        (("faults", "--serve", "nothing"), "nothing"),
        (("plots", "--out", "nowhere"), "nowhere"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(
    arguments: tuple[str, ...], words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if arguments[0] == "plots":
        pytest.importorskip("matplotlib")
    assert command(monkeypatch, *arguments) == 2
    assert words in capsys.readouterr().err
