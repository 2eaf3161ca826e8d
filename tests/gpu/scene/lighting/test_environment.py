from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from scenes import grey, quad, scene_of
from trimesh.creation import icosphere

from gpu.errors import ImageError
from gpu.scene.lighting.environment import read_environment, with_environment
from gpu.scene.lighting.environment_options import EnvironmentOptions
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Environment, Floats, Light, LightKind, Material, Sky

FLOOR = quad([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0])
PICTURE = np.random.default_rng(0).random((4, 8, 3)).astype(np.float32)


def exr(folder: Path, pixels: Floats, names: str = "RGB", name: str = "sky.exr") -> Path:
    channels = {names: pixels} if len(names) == 3 else {names: np.ascontiguousarray(pixels[..., 0])}
    path = folder / name
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))
    return path


def test_both_formats_are_read(tmp_path: Path) -> None:
    assert np.allclose(read_environment(exr(tmp_path, PICTURE)), PICTURE)
    assert np.allclose(read_environment(exr(tmp_path, PICTURE, "Y")), PICTURE[..., :1])
    hdr = tmp_path / "SKY.HDR"
    hdr.write_bytes(b"#?RADIANCE\n\n-Y 1 +X 2\n" + bytes((128, 64, 0, 129)) * 2)
    assert read_environment(hdr).tolist() == [[[1.0, 0.5, 0.0]] * 2]


def test_what_no_light_has_is_mended(tmp_path: Path) -> None:
    odd = PICTURE.copy()
    odd[0, 0], odd[0, 1], odd[0, 2] = np.nan, np.inf, -1.0
    pixels = read_environment(exr(tmp_path, odd))
    assert pixels[0, :3, 0].tolist() == [0.0, 1e6, 0.0]


def test_wide_pictures_become_smaller_and_as_bright(tmp_path: Path) -> None:
    wide = np.tile(np.random.default_rng(0).random((205, 82, 3)).astype(np.float32), (10, 50, 1))
    pixels = read_environment(exr(tmp_path, wide))
    assert pixels.shape == (1025, 2050, 3)
    assert pixels.mean() == pytest.approx(wide.mean(), rel=1e-3)


def test_what_is_no_environment_is_said(tmp_path: Path) -> None:
    broken = tmp_path / "broken.exr"
    broken.write_bytes(b"v/1\x01 and no more")
    cases = [
        (tmp_path / "sky.png", "ends in .hdr or .exr"),
        (tmp_path / "none.hdr", "cannot be read: No such file"),
        (broken, "is no OpenEXR picture that can be read"),
        (exr(tmp_path, PICTURE, "Z", "depth.exr"), "no readable channels R, G and B"),
        (exr(tmp_path, PICTURE[:, :5], name="square.exr"), "is 5 x 4; an equirectangular picture"),
        (exr(tmp_path, 0.0 * PICTURE, name="night.exr"), "all black"),
    ]
    for path, problem in cases:
        with pytest.raises(ImageError, match=problem):
            read_environment(path)


def test_it_is_there_instead_of_light_that_was_added(tmp_path: Path) -> None:
    options = EnvironmentOptions(
        environment=exr(tmp_path, PICTURE), environment_rotation=90.0, environment_strength=2.0
    )
    dark = scene_of([FLOOR], [grey(0.5)])
    assert dark.sky is not None
    scene = with_environment(dark, options)
    assert isinstance(scene.sky, Environment)
    assert (scene.sky.name, scene.sky.turn) == ("sky.exr", 0.25)
    assert np.allclose(scene.sky.pixels, 2.0 * PICTURE)
    assert not any("no light" in note for note in scene.report.notes)
    assert with_environment(dark, EnvironmentOptions()) is dark


def test_it_is_there_instead_of_skies_and_beside_lamps(tmp_path: Path) -> None:
    options = EnvironmentOptions(environment=exr(tmp_path, PICTURE))
    lamp = Light("added lamp", LightKind.POINT, (1.0, 1.0, 1.0), position=(0.0, 0.3, 0.0))
    ball = icosphere(2, 5.0)
    dome = MeshPart(np.asarray(ball.vertices), np.asarray(ball.faces[:, ::-1]), material=1)
    scene = scene_of([FLOOR, dome], [grey(0.5), Material(unlit=True)], [lamp], Sky((1.0, 1.0, 1.0)))
    assert any(material.backdrop for material in scene.materials)
    around = with_environment(scene, options)
    assert isinstance(around.sky, Environment)
    assert [light.name for light in around.lights] == ["added lamp"]
    assert (len(around.triangles), around.triangle_material.tolist()) == (2, [0, 0])
