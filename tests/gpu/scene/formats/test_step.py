from pathlib import Path

import numpy as np
import pytest
from step_file import METRE, MILLIMETRE, Box, step

from gpu.errors import SceneError
from gpu.scene.formats.step import load_step, metres_per_unit
from gpu.scene.import_options import ImportOptions
from gpu.scene.limits import DEFAULT_LIMITS, SceneLimits
from gpu.scene.types import AlphaMode, Scene

pytest.importorskip("cascadio", reason="the extra step is not installed")


def load(folder: Path, content: bytes, options: ImportOptions | None = None) -> Scene:
    path = folder / "scene.step"
    path.write_bytes(content)
    return load_step(path, DEFAULT_LIMITS, options or ImportOptions())


def bounds(scene: Scene) -> list[list[float]]:
    world = scene.vertices / scene.placement.scale + np.array(scene.placement.centre)
    return [[round(float(value), 4) for value in bound] for bound in (world.min(axis=0), world.max(axis=0))]


@pytest.mark.parametrize(
    ("unit", "inch", "size"), [(METRE, False, 1.0), (MILLIMETRE, False, 1e-3), (MILLIMETRE, True, 0.0254)]
)
def test_lengths_become_metres_and_z_is_up(tmp_path: Path, unit: str, inch: bool, size: float) -> None:
    content = step(Box(high=(100, 200, 300)), unit=unit, inch=inch)
    scene = load(tmp_path, content)
    corners = scene.vertices[scene.triangles]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert metres_per_unit(content) == size
    assert bounds(scene) == [[0, 0, round(-200 * size, 4)], [round(100 * size, 4), round(300 * size, 4), 0]]
    assert len(scene.triangles) == 12
    assert (np.einsum("tc,tc->t", outwards, scene.normals[scene.triangles[:, 0]]) > 0).all()
    assert (np.einsum("tc,tc->t", outwards, corners.mean(axis=1)) > 0).all()


def test_the_unit_and_origin_of_a_user_count(tmp_path: Path) -> None:
    content = step(Box(high=(100, 200, 300)), unit=MILLIMETRE)
    assert bounds(load(tmp_path, content, ImportOptions(unit="m", origin=(100, 0, 0)))) == [
        [-100, 0, -200],
        [0, 300, 0],
    ]


def test_colours_and_transparency(tmp_path: Path) -> None:
    boxes = Box(color=(0.5, 0.0, 1.0)), Box((2, 0, 0), (3, 1, 1), (1.0, 1.0, 1.0), 0.75), Box((4, 0, 0), (5, 1, 1))
    scene = load(tmp_path, step(*boxes))
    assert [np.round(material.base_color, 3).tolist() for material in scene.materials] == [
        [0.214, 0, 1, 1], [1, 1, 1, 0.25], [0.8, 0.8, 0.8, 1]
    ]  # fmt: skip
    assert [material.alpha_mode for material in scene.materials] == [
        AlphaMode.OPAQUE,
        AlphaMode.BLEND,
        AlphaMode.OPAQUE,
    ]
    assert all(material.metallic == 0.0 and material.double_sided for material in scene.materials[:2])
    assert "bodies without a colour, which are grey: 1" in scene.report.notes


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not a STEP file that can be read"),
        (b"solid", "not a STEP file that can be read: ERR StepFile"),
        (step(Box())[:3000], "unexpected end of file"),
        (step(), "no triangles"),
        (step(Box()).replace(b"=PLANE(", b"=PLANT("), "no triangles"),
    ],
)
def test_what_is_broken_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], content: bytes, says: str
) -> None:
    with pytest.raises(SceneError, match=says):
        load(tmp_path, content)
    assert capfd.readouterr().out == ""


def test_a_broken_face_is_left_out_and_said(tmp_path: Path) -> None:
    content = step(Box(), Box((4, 0, 0), (5, 1, 1)))
    start = content.rindex(b"CLOSED_SHELL")
    scene = load(tmp_path, content[:start] + content[start:].replace(b"(#", b"(#9999", 1))
    assert len(scene.triangles) == 22
    assert any("were left out; Open CASCADE says: " in sentence for sentence in scene.report.ignored)


def test_limits_count(tmp_path: Path) -> None:
    (tmp_path / "a.stp").write_bytes(step(Box()))
    with pytest.raises(SceneError, match="max_triangles"):
        load_step(tmp_path / "a.stp", SceneLimits(max_triangles=11))
