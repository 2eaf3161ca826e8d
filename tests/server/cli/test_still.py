import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from server.cli.main import main
from server.images import read_image

SMALL = ["--size=48x32", "--vpls=2000", "--vpl-clusters=64", "--sp-clusters=64", "--device=cpu"]


def test_render_writes_the_picture_and_its_statistics(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "box.png"
    assert main(["render", "cornell-box", str(path), *SMALL, "--json"]) == 0
    with Image.open(path) as image:
        assert image.size == (48, 32)
        assert np.asarray(image).std() > 10.0
    report = json.loads(capsys.readouterr().out)
    assert report["size"] == [48, 32]
    assert report["device"] == "cpu"
    assert report["settings"]["vpl_clusters"] == 64
    assert report["counts"]["nonfinite"] == report["counts"]["unassigned"] == 0
    assert report["stage_ms"]
    assert all(ms >= 0.0 for ms in report["stage_ms"].values())


def test_components_add_up(tmp_path: Path) -> None:
    images = {}
    for component in ("full", "direct", "indirect"):
        path = tmp_path / f"{component}.npy"
        assert main(["render", "cornell-box", str(path), *SMALL, "--component", component]) == 0
        images[component] = read_image(path)
    assert images["full"].shape == (32, 48, 3)
    assert images["indirect"].mean() > 0.0
    assert np.allclose(images["direct"] + images["indirect"], images["full"], rtol=1e-4, atol=1e-6)


def test_the_camera_is_the_one_asked_for(tmp_path: Path) -> None:
    paths = [tmp_path / "a.exr", tmp_path / "b.exr"]
    for path, camera in zip(paths, ("0", "1"), strict=True):
        assert main(["render", "cornell-box", str(path), *SMALL, "--component=direct", "--camera", camera]) == 0
    assert not np.allclose(read_image(paths[0]), read_image(paths[1]))


def test_frames_are_averaged_and_smooth_its_edges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    images = {}
    for frames in ("1", "8"):
        path = tmp_path / f"{frames}.npy"
        options = [*SMALL, "--component=indirect", "--frames", frames, "--json"]
        assert main(["render", "cornell-box", str(path), *options]) == 0
        assert json.loads(capsys.readouterr().out)["counts"]["frames"] == int(frames)
        images[frames] = read_image(path)
    assert not np.allclose(images["1"], images["8"])
    assert images["1"].mean() == pytest.approx(images["8"].mean(), rel=0.1)


@pytest.mark.parametrize(("option", "word"), [("--camera=attic", "attic"), ("--device=cuda:99", "cuda:99")])
def test_what_the_scene_or_machine_lacks_is_said(
    option: str, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.png"
    assert main(["render", "cornell-box", str(path), *SMALL, option]) == 2
    assert word in capsys.readouterr().err
    assert not path.exists()


def sky(folder: Path) -> Path:
    """A picture of light from all around, of radiance 1, 0.5 and 0.25."""
    path = folder / "sky.hdr"
    path.write_bytes(b"#?RADIANCE\n\n-Y 2 +X 4\n" + bytes((128, 64, 32, 129)) * 8)
    return path


def test_an_environment_lights_a_scene_and_is_seen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    floor, out = tmp_path / "floor.obj", tmp_path / "floor.npy"
    floor.write_text("v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 4 3 2 1\n")
    command = ["render", str(floor), str(out), "--size=16x12", "--method=path", "--samples=16", "--device=cpu"]
    around = ["--environment", str(sky(tmp_path)), "--environment-strength=2", "--lambertian"]
    assert main([*command, *around, "--camera=0,2,3:0,0,0"]) == 0
    picture = read_image(out)
    assert np.allclose(picture[0], [2.0, 1.0, 0.5], rtol=1e-5)
    assert np.allclose(picture[6, 8], picture[6, 8, 0] * np.array([1.0, 0.5, 0.25]), rtol=1e-3)
    assert 0.1 < picture[6, 8, 0] < 1.9
    assert "no light" not in capsys.readouterr().err
    assert main([*command, "--environment", str(tmp_path / "none.hdr")]) == 2
    assert "none.hdr: cannot be read" in capsys.readouterr().err


def test_a_file_of_edits_changes_lights_and_materials(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edits, out = tmp_path / "edits.json", tmp_path / "a.npy"
    command = ["render", "cornell-box", str(out), *SMALL, "--component=direct", "--edit", str(edits)]
    assert main(["info", "cornell-box"]) == 0
    assert "light: area" in capsys.readouterr().out
    edits.write_text('{"lights": {"light": {"color": [0, 1, 0]}}}')
    assert main(command) == 0
    assert (read_image(out).max(axis=(0, 1)) > 0.0).tolist() == [False, True, False]
    edits.write_text('{"lights": {"moon": {"on": true}}}')
    assert main(command) == 2
    assert f"--edit: {edits}: lights.moon: the scene has no such light; it has" in capsys.readouterr().err
    edits.write_text("{}")
    assert main([*command, "--time=1"]) == 2
    assert "error: time: the scene has no animations" in capsys.readouterr().err
