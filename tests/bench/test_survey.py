from pathlib import Path

import pytest

from gpu.errors import UserError
from tests.bench import __main__ as command
from tests.bench import growth, still, survey, temporal
from tests.bench.page import SECTIONS
from tests.bench.suite import Suite
from tests.bench.survey import STEPS, Step, suite_of
from tests.bench.sweep import groups


def suite(tmp_path: Path, **options: object) -> Suite:
    return Suite(**{"out": tmp_path, "cache": tmp_path, "device": "cpu", "quick": True, "size": (24, 16), **options})  # type: ignore[arg-type]


def test_the_survey_has_every_section_of_the_page_and_every_group() -> None:
    assert {step.part for step in STEPS} == {section.part for section in SECTIONS}
    assert {group for step in STEPS for group in step.groups} == {group for group, _ in groups()}


def test_a_step_has_those_of_its_scenes_that_there_are(tmp_path: Path) -> None:
    whole = suite(tmp_path)
    assert suite_of(whole, Step("sweep", 9.0, ("conference",), ("path",))).names == ("conference-room",)
    assert suite_of(whole, Step("sweep", 9.0, ("conference",), ("path",))).groups == ("path",)
    assert set(suite_of(whole, Step("still", 9.0)).names) == set(whole.scene_names())
    one = suite(tmp_path, names=("atrium",))
    assert suite_of(one, Step("temporal", 9.0, ("conference",))).names == ("atrium",)


def test_steps_share_their_scenes_but_walk_has_the_built_in_ones(tmp_path: Path) -> None:
    whole = suite(tmp_path, names=("cornell-box",))
    subject = whole.subject("cornell-box")
    assert suite_of(whole, Step("still", 9.0)).subject("cornell-box") is subject
    assert suite_of(whole, Step("walk", 9.0)).subject("cornell-box") is not subject


def test_a_failing_step_is_told_and_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: Suite) -> None:
        raise RuntimeError("lost the device")

    done: list[str] = []
    monkeypatch.setattr(still, "run", fail)
    monkeypatch.setattr(temporal, "run", lambda _: done.append("temporal"))
    monkeypatch.setattr(growth, "run", lambda _: done.append("growth"))
    monkeypatch.setattr(survey, "STEPS", (Step("growth", 9.0), Step("still", 9.0), Step("temporal", 9.0)))
    monkeypatch.setattr("sys.argv", ["bench", "survey", "--device", "cpu", "--out", str(tmp_path)])
    assert command.main() == 1
    told = capsys.readouterr().err
    assert "survey: still failed" in told
    assert "lost the device" in told
    assert done == ["growth", "temporal"]
    with pytest.raises(UserError, match="still failed"):
        survey.run(suite(tmp_path))
