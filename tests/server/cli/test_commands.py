import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gpu.scene.edits import NO_EDITS, SceneEdits
from server.cli.main import main


def lumenwalk(*arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run the console script as a user does."""
    script = Path(sys.executable).with_name("lumenwalk")
    return subprocess.run([script, *arguments], capture_output=True, text=True, timeout=60, check=False)


@pytest.fixture
def pair(tmp_path: Path) -> tuple[str, str]:
    """A reference of random light and a render that is 10 % too bright, as .npy files."""
    reference = np.random.default_rng(4).random((16, 16, 3)).astype(np.float32)
    names = str(tmp_path / "render.npy"), str(tmp_path / "reference.npy")
    np.save(names[0], reference * np.float32(1.1))
    np.save(names[1], reference)
    return names


def test_help_lists_the_commands() -> None:
    result = lumenwalk("--help")
    assert result.returncode == 0
    assert all(command in result.stdout for command in ("serve", "render", "compare", "info"))


def test_light_commands_do_not_import_warp(pair: tuple[str, str]) -> None:
    program = "import sys, server.cli.main; sys.exit(server.cli.main.main(sys.argv[1:]) or 9 * ('warp' in sys.modules))"
    command = [sys.executable, "-c", program, "compare", *pair]
    assert subprocess.run(command, capture_output=True, timeout=60, check=False).returncode == 0


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ([], "give a command: serve, render, compare, info or warm"),
        (["fly"], "fly"),
        (["info"], "SCENE"),
        (["info", "no-such.glb"], "no-such.glb"),
        (["compare", "a.npy", "b.npy"], "a.npy"),
        (["render", "cornell-box", "out.tiff"], "out.tiff: .tiff: not an image format"),
        (["render", "cornell-box", "out.png", "--camera", "-1,0,0:0,0,0"], "a minus is written --camera=-1"),
        (["render", "cornell-box", "out.png", "--origin", "1,2"], '--origin: needs three numbers "x,y,z"'),
        (["render", "cornell-box", "no/out.png"], "folder no"),
        (["render", "cornell-box", "out.png", "--size", "big"], "--size"),
        (["render", "cornell-box", "out.png", "--vpls", "0"], "--vpls"),
        (["render", "cornell-box", "out.png", "--method", "magic"], "--method"),
        (
            ["render", "cornell-box", "out.png", "--target-ms", "9", "--sp-clusters", "9"],
            "--target-ms: needs sp_clusters",
        ),
        (["render", "cornell-box", "out.png", "--target-ms", "9", "--target-error", "0.1"], "--target-error: needs"),
        (["render", "no-such.glb", "out.png"], "no-such.glb"),
        (["serve", "--config", "x" * 300], "File name too long"),
        (["serve", "--port", "99999"], "port"),
        (["serve", "--config", "no-such.toml"], "no-such.toml"),
    ],
)
def test_mistakes_are_one_line_and_status_2(
    arguments: list[str], word: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("lumenwalk: error: ")
    assert printed.err.count("\n") == 1
    assert word in printed.err


def test_compare_prints_every_error(pair: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", *pair]) == 0
    lines = dict(line.split() for line in capsys.readouterr().out.splitlines())
    assert list(lines) == ["non-finite", "MSE", "relMSE", "HDR-FLIP", "energy"]
    assert float(lines["energy"]) == pytest.approx(1.1)
    assert main(["compare", *pair, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["rel_mse"] == pytest.approx(float(lines["relMSE"]), rel=1e-3)


def test_compare_fails_on_nonfinite_values(pair: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    image = np.load(pair[0])
    image[0, 0, 0] = np.nan
    np.save(pair[0], image)
    assert main(["compare", *pair, "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["nonfinite"] == 1
    assert report["mse"] is None


def test_compare_takes_a_component_of_a_reference(shared: Path, tmp_path: Path) -> None:
    # Of one pixel in 64, as HDR-FLIP takes seconds for the whole picture.
    with np.load(shared / "references" / "cornell-box.npz") as arrays:
        small = {name: arrays[name][::8, ::8] for name in ("full", "direct")}
    np.savez(tmp_path / "reference.npz", **small)
    np.save(tmp_path / "a.npy", small["full"].astype(np.float32) - small["direct"])
    files = str(tmp_path / "a.npy"), str(tmp_path / "reference.npz")
    energy = [float(lumenwalk("compare", *files, *more).stdout.split()[-1]) for more in ([], ["--component=indirect"])]
    assert energy[0] < 0.9
    assert energy[1] == pytest.approx(1.0)


def test_info_as_text_and_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "cornell-box"]) == 0
    text = capsys.readouterr().out
    assert main(["info", "cornell-box", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert f"{report['triangles']:,} triangles" in text
    assert report["lights"][0]["kind"] == "area"


def test_a_reader_that_leaves_is_no_error() -> None:
    script = Path(sys.executable).with_name("lumenwalk")
    with subprocess.Popen([script, "info", "cornell-box"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(60) == 0


def test_an_interrupt_is_quiet(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("server.cli.reports.report_errors", interrupted)
    assert main(["compare", "a.npy", "b.npy"]) == 130
    assert capsys.readouterr().err == ""


def test_a_moment_is_an_edit(monkeypatch: pytest.MonkeyPatch) -> None:
    rendered = []
    monkeypatch.setattr("server.cli.still.render_file", lambda chosen, *_, **__: rendered.append(chosen.edits))
    assert main(["render", "house.glb", "out.png", "--time", "2.5", "--animation=walk"]) == 0
    assert main(["render", "house.glb", "out.png"]) == 0
    assert rendered == [SceneEdits(time=2.5, animation="walk"), NO_EDITS]


def test_a_moment_that_a_scene_has_not_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "cornell-box", str(tmp_path / "out.png"), "--time=1"]) == 2
    assert "time: the scene has no animations" in capsys.readouterr().err
