import numpy as np
import pytest

from gpu.scene.camera import rotated
from gpu.settings import RenderSettings
from server.cli.studio import ChosenScene, PictureOptions, Progress, Studio, warn_of_faults


def test_a_picture_owes_nothing_to_those_before_it() -> None:
    scene = ChosenScene("cornell-box").read()
    settings = RenderSettings(vpls=2000, vpl_clusters=64, sp_clusters=64, frames=2)
    studio = Studio(scene, PictureOptions((48, 32), "cpu", settings))
    camera = scene.cameras[0]
    first = studio.picture(camera).pixels()
    other = studio.picture(rotated(camera, 30.0), (1, 3))
    assert not np.array_equal(other.pixels(), first)
    again = studio.picture(camera, (2, 3))
    assert np.array_equal(again.pixels(), first)
    assert again.stats.counts["frames"] == 2
    assert studio.report("a.png", 1.0)["seconds"]["load"] == 1.0


def test_kernels_of_pictures_are_compiled_side_by_side_before_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[RenderSettings, int]] = []
    monkeypatch.setattr("server.cli.studio.warm_up_still", lambda _, *asked_for: asked.append(asked_for))
    settings = RenderSettings(frames=3)
    Studio(ChosenScene("cornell-box").read(), PictureOptions((48, 32), "cpu", settings))
    assert asked == [(settings, 3)]


def test_faults_are_warned_of(capsys: pytest.CaptureFixture[str]) -> None:
    warn_of_faults({"nonfinite": 0, "unassigned": 3})
    assert capsys.readouterr().err == "lumenwalk: warning: 3 unassigned pixels\n"


def test_progress_is_for_terminals_only(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    Progress()("VPLs", 0.5)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    progress = Progress()
    progress("VPLs", 0.5)
    assert "VPLs  50%" in capsys.readouterr().err
    progress.end()
    assert capsys.readouterr().err == "\r\x1b[K"
