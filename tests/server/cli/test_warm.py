from dataclasses import replace

import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.scene.builtin import BUILTIN
from gpu.settings import Method, RenderSettings
from server.cli import warm
from server.cli.main import main

Warmed = tuple[str, Method, bool, int | None]


@pytest.fixture
def warmed(monkeypatch: pytest.MonkeyPatch) -> list[Warmed]:
    """Scenes, methods and for what they were warmed, without the work."""
    found: list[Warmed] = []

    def note(
        device_scene: DeviceScene, settings: RenderSettings, *, general: bool, architecture: int | None = None
    ) -> None:
        found.append((device_scene.scene.name, settings.method, general, architecture))

    monkeypatch.setattr(warm, "compile_ahead", note)
    return found


def test_scenes_are_warmed_one_after_the_other(warmed: list[Warmed], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["warm", "cornell-box", "--device=cpu", "--method=path"]) == 0
    assert warmed == [("cornell-box", Method.PATH, False, None)]
    assert capsys.readouterr().out.startswith("cornell-box: 0.")


def test_all_built_in_scenes_are_warmed_where_none_is_named(
    warmed: list[Warmed], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm, "read_scene", lambda source, _: replace(BUILTIN["cornell-box"](), name=source))
    assert main(["warm", "--device=cpu"]) == 0
    assert [name for name, *_ in warmed] == list(BUILTIN)


def test_scenes_are_warmed_for_gpus_that_are_not_here(warmed: list[Warmed]) -> None:
    assert main(["warm", "cornell-box", "--architecture=90", "--architecture=89", "--general"]) == 0
    assert warmed == [("cornell-box", Method.FUZZY_VPL, True, number) for number in (90, 89)]


@pytest.mark.parametrize(
    "arguments",
    [["missing.glb"], ["cornell-box", "--device=cuda:99"], ["--method=none"], ["cornell-box", "--architecture=91"]],
)
def test_what_is_not_there_is_said_in_a_line(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["warm", *arguments]) == 2
    assert capsys.readouterr().err.count("\n") == 1
