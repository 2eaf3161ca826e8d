from dataclasses import replace

import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.scene.builtin import BUILTIN
from gpu.settings import Method, RenderSettings
from server.cli import warm
from server.cli.main import main


@pytest.fixture
def warmed(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, RenderSettings]]:
    """Scenes and settings that were warmed, without the work."""
    found: list[tuple[str, RenderSettings]] = []

    def note(device_scene: DeviceScene, settings: RenderSettings) -> None:
        found.append((device_scene.scene.name, settings))

    monkeypatch.setattr(warm, "warm_up", note)
    return found


def test_scenes_are_warmed_one_after_the_other(
    warmed: list[tuple[str, RenderSettings]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["warm", "cornell-box", "--device=cpu", "--method=path"]) == 0
    assert [(name, settings.method) for name, settings in warmed] == [("cornell-box", Method.PATH)]
    assert capsys.readouterr().out.startswith("cornell-box: 0.")


def test_all_built_in_scenes_are_warmed_where_none_is_named(
    warmed: list[tuple[str, RenderSettings]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm, "read_scene", lambda source, _: replace(BUILTIN["cornell-box"](), name=source))
    assert main(["warm", "--device=cpu"]) == 0
    assert [name for name, _ in warmed] == list(BUILTIN)


def test_scenes_are_warmed_for_gpus_that_are_not_here(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found: list[tuple[int, str, Method]] = []

    def note(architecture: int, device_scene: DeviceScene, settings: RenderSettings) -> None:
        found.append((architecture, device_scene.scene.name, settings.method))

    monkeypatch.setattr(warm, "warm_up_for", note)
    assert main(["warm", "cornell-box", "--architecture=90", "--architecture=89", "--method=path"]) == 0
    assert found == [(90, "cornell-box", Method.PATH), (89, "cornell-box", Method.PATH)]
    assert capsys.readouterr().out.startswith("cornell-box: ")


@pytest.mark.parametrize(("where", "how"), [("--device=cpu", "warm_up"), ("--architecture=90", "warm_up_for")])
def test_general_kernels_are_compiled_where_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, where: str, how: str
) -> None:
    found: list[bool] = []
    monkeypatch.setattr(warm, how, lambda *given: found.append(given[-2].general))
    for wanted in ([], ["--general"]):
        assert main(["warm", "cornell-box", where, *wanted]) == 0
    assert found == [False, False, True]


@pytest.mark.parametrize(
    "arguments",
    [["missing.glb"], ["cornell-box", "--device=cuda:99"], ["--method=none"], ["cornell-box", "--architecture=91"]],
)
def test_what_is_not_there_is_said_in_a_line(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["warm", *arguments]) == 2
    assert capsys.readouterr().err.count("\n") == 1
