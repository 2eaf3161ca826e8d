import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gpu.errors import UserError
from gpu.scene.animation.motion import STILL, Animation, Channel, Interpolation, Motion, Property
from gpu.scene.builtin import BUILTIN
from server.cli.film import PictureFiles, read_path
from server.cli.main import main
from server.images import read_image

SMALL = ["--size=48x32", "--vpls=2000", "--vpl-clusters=64", "--sp-clusters=64", "--device=cpu"]
AWAY = {"position": [0.2, 1.0, 3.2], "target": [0.0, 1.0, 0.0], "yfov_degrees": 45}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A path of half a second."""
    keyframes = [{"time": 0, "camera": 0}, {"time": 0.5, "camera": AWAY, "name": "away"}]
    file = tmp_path / "path.json"
    file.write_text(json.dumps({"keyframes": keyframes}))
    return file


def test_a_film_shows_its_way(path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    av = pytest.importorskip("av", reason="the extra video is not installed")
    film, still = tmp_path / "film.mp4", tmp_path / "still.png"
    assert main(["render", "cornell-box", str(film), *SMALL, f"--path={path}", "--fps=8", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["pictures"], report["fps"], report["frames"]) == (4, 8, 1)
    assert report["counts"] == {"nonfinite": 0, "unassigned": 0}
    assert 0.0 < report["seconds"]["write"] < report["seconds"]["render"]
    with av.open(str(film)) as container:
        frames = [frame.to_ndarray(format="rgb24").astype(int) for frame in container.decode(video=0)]
    assert (len(frames), frames[0].shape) == (4, (32, 48, 3))
    assert main(["render", "cornell-box", str(still), *SMALL]) == 0
    from PIL import Image

    expected = np.asarray(Image.open(still).convert("RGB"), int)
    errors = [np.abs(frame - expected).mean() for frame in frames]
    assert errors[0] < 6.0
    assert errors == sorted(errors)
    assert errors[3] > 2 * errors[0]


def test_a_film_may_be_numbered_pictures(path: Path, tmp_path: Path) -> None:
    pattern = tmp_path / "frame-%03d.npy"
    assert main(["render", "cornell-box", str(pattern), *SMALL, f"--path={path}", "--fps=4"]) == 0
    assert sorted(found.name for found in tmp_path.glob("*.npy")) == ["frame-001.npy", "frame-002.npy"]
    still = tmp_path / "still.npy"
    assert main(["render", "cornell-box", str(still), *SMALL]) == 0
    assert np.array_equal(read_image(tmp_path / "frame-001.npy"), read_image(still))
    assert not np.array_equal(read_image(tmp_path / "frame-002.npy"), read_image(still))


def test_a_film_follows_a_camera_that_an_animation_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    box = BUILTIN["cornell-box"]()
    keys = np.array([[[0.0, 1.0, 3.0]], [[1.0, 1.0, 3.0]]])
    channel = Channel(0, Property.TRANSLATION, Interpolation.LINEAR, np.array([0.0, 1.0]), keys)
    rest = np.array([[0, 0, 0, 0, 0, 0, 1, 1, 1, 1]], np.float64)
    slide = (Animation("slide", 1.0, (channel,)),)
    motion = Motion(np.array([STILL], np.int32), np.eye(4)[None], rest, slide, cameras=(0,))
    monkeypatch.setattr("server.cli.studio.read_scene", lambda *_: replace(box, motion=motion))
    path = tmp_path / "path.json"
    path.write_text(json.dumps({"keyframes": [{"time": time, "camera": 0} for time in (3, 3.5)]}))
    pattern, still = tmp_path / "frame-%d.npy", tmp_path / "still.npy"
    assert main(["render", "box.glb", str(pattern), *SMALL, f"--path={path}", "--fps=4", "--time=0.25"]) == 0
    assert main(["render", "box.glb", str(still), *SMALL, "--time=0.5"]) == 0
    assert np.array_equal(read_image(tmp_path / "frame-2.npy"), read_image(still))
    assert not np.array_equal(read_image(tmp_path / "frame-1.npy"), read_image(still))
    assert main(["render", "box.glb", str(pattern), *SMALL, f"--path={path}", "--animation=run"]) == 2
    assert "animation: the scene has no 'run'; it has slide" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("output", "options", "sentence"),
    [
        ("film.mp4", ["--path", "none.json"], "--path: none.json: cannot be read: No such file"),
        ("film.mp4", [], "film.mp4: is a film; give the way of its camera by --path FILE"),
        ("a-%04d.png", [], "a-%04d.png: numbers a film's pictures; give the way of its camera by --path FILE"),
        ("still.png", ["--fps", "25"], "--fps: is of a film; give the way of its camera by --path FILE"),
        ("still.png", ["--path", "PATH"], "still.png: is one file for the many pictures of --path; number them"),
        ("%d%d.png", ["--path", "PATH"], "%d%d.png: is one file for the many"),
        ("%x%d.png", ["--path", "PATH"], "%x%d.png: is one file for the many"),
        ("%04d.gif", ["--path", "PATH"], "0001.gif: .gif: not an image format"),
        ("none/film.mp4", ["--path", "PATH"], "none/film.mp4: the folder none does not exist"),
        ("film.mp4", ["--path", "PATH", "--camera", "0"], "--camera: is of one picture; leave it out, or --path"),
        ("film.mp4", ["--path", "PATH", "--fps", "0"], "--fps: must be greater than or equal to 1"),
        ("film.mp4", ["--path", "PATH", "--size", "47x32"], "size: a video needs even sides"),
        (
            "film.mp4",
            ["--path", "lost.json"],
            "--path: lost.json: keyframes[1].camera: cornell-box has no camera 'attic'",
        ),
    ],
)
def test_what_is_wrong_is_said_at_once(
    output: str,
    options: list[str],
    sentence: str,
    path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if output.endswith(".mp4"):
        pytest.importorskip("av", reason="the extra video is not installed")
    monkeypatch.chdir(path.parent)
    path.with_name("lost.json").write_text(path.read_text().replace(json.dumps(AWAY), '"attic"'))
    given = [str(path) if option == "PATH" else option for option in options]
    assert main(["render", "cornell-box", output, "--device=cpu", "--size=48x32", *given]) == 2
    assert f"lumenwalk: error: {sentence}" in capsys.readouterr().err
    assert {file.name for file in path.parent.iterdir()} == {"path.json", "lost.json"}


def test_a_film_without_pyav_names_the_extra(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    assert main(["render", "cornell-box", str(path.with_name("film.mp4")), *SMALL, f"--path={path}"]) == 2
    assert capsys.readouterr().err == "lumenwalk: error: video needs the extra video: pip install lumenwalk[video]\n"


def test_a_path_file_is_read_with_care(tmp_path: Path) -> None:
    file = tmp_path / "path.json"
    for content, sentence in (
        ("{", "Invalid JSON"),
        ("[]", "must be an object"),
        ("{}", "keyframes: is missing"),
        (" " * 2**20 + "{}", "is larger than the 1048576 bytes"),
    ):
        file.write_text(content)
        with pytest.raises(UserError, match=rf"^--path: {re.escape(str(file))}: {re.escape(sentence)}"):
            read_path(file)


def test_editors_may_mark_the_encoding_of_a_path(path: Path) -> None:
    plain = read_path(path)
    path.write_text(path.read_text(), encoding="utf-16")
    assert read_path(path) == plain


@pytest.mark.parametrize(
    ("pattern", "name"), [("a-%04d.png", "a-0012.png"), ("%d.exr", "12.exr"), ("x/%02d.b.png", "12.b.png")]
)
def test_pictures_have_their_number_in_their_name(pattern: str, name: str) -> None:
    assert PictureFiles(Path(pattern)).file(12) == Path(pattern).with_name(name)
