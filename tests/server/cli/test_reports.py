import json
from pathlib import Path

import numpy as np
import pytest

from gpu.errors import ImageError, UserError
from gpu.settings import Component
from server.cli.reports import report_errors, report_scene

LIGHT = np.random.default_rng(4).random((16, 16, 3)).astype(np.float32)


def file(folder: Path, name: str, image: np.ndarray) -> str:
    np.save(folder / name, image)
    return str(folder / name)


def test_errors_are_printed_for_people_and_for_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    render, reference = file(tmp_path, "render.npy", 1.1 * LIGHT), file(tmp_path, "reference.npy", LIGHT)
    assert report_errors(render, reference, Component.FULL, as_json=False) == 0
    lines = dict(line.rsplit(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert report_errors(render, reference, Component.FULL, as_json=True) == 0
    values = json.loads(capsys.readouterr().out)
    assert (values["render"], values["reference"], values["component"]) == (render, reference, "full")
    assert values["energy"] == pytest.approx(1.1, rel=1e-5)
    assert float(lines["energy"]) == pytest.approx(1.1, rel=1e-3)
    assert float(lines["relMSE"]) == pytest.approx(values["rel_mse"], rel=1e-3)


def test_non_finite_values_are_a_failure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = LIGHT.copy()
    broken[0, 0, 0] = np.nan
    names = file(tmp_path, "render.npy", broken), file(tmp_path, "reference.npy", LIGHT)
    assert report_errors(*names, Component.FULL, as_json=True) == 1
    assert json.loads(capsys.readouterr().out)["nonfinite"] == 1


def test_images_that_cannot_be_compared_are_named(tmp_path: Path) -> None:
    names = file(tmp_path, "render.npy", LIGHT[:8]), file(tmp_path, "reference.npy", LIGHT)
    with pytest.raises(ImageError, match=r"render\.npy.*reference\.npy"):
        report_errors(*names, Component.FULL, as_json=False)


def test_a_scene_is_described_for_people_and_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    report_scene("cornell-box", as_json=True)
    summary = json.loads(capsys.readouterr().out)
    assert isinstance(summary, dict)
    report_scene("cornell-box", as_json=False)
    text = capsys.readouterr().out
    assert "triangles" in text
    with pytest.raises(UserError):
        report_scene("no-such.glb", as_json=False)
