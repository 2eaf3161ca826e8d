from math import cos, radians, tan
from pathlib import Path

import pytest
from dae_file import dae, use

from gpu.scene.formats.collada import load_collada
from gpu.scene.types import LightKind, Scene


def load(folder: Path, kind: str, inside: str) -> Scene:
    """A scene with a light or camera that looks down at 3 m above the floor."""
    wrapped = f"<technique_common>{inside}</technique_common>"
    wrapped = f"<optics>{wrapped}</optics>" if kind == "camera" else wrapped
    library = f'<library_{kind}s><{kind} id="l">{wrapped}</{kind}></library_{kind}s>'
    node = f'<node name="n"><translate>0 0 300</translate><instance_{kind} url="#l"/></node>'
    (folder / "a.dae").write_bytes(dae([f"<node>{use()}</node>", node], libraries=library))
    return load_collada(folder / "a.dae")


def test_a_spot_light(tmp_path: Path) -> None:
    inside = "<spot><color>1 2 3</color><falloff_angle>60</falloff_angle></spot>"
    scene = load(tmp_path, "light", inside)
    (light,) = scene.lights
    assert (light.kind, light.direction) == (LightKind.SPOT, pytest.approx((0, -1, 0)))
    assert light.cos_outer == light.cos_inner == pytest.approx(cos(radians(30)))
    assert light.intensity == pytest.approx([value * scene.placement.scale**2 for value in (1, 2, 3)])


def test_light_fades_with_the_square_of_the_distance(tmp_path: Path) -> None:
    inside = "<point><color>1 1 1</color><linear_attenuation>1</linear_attenuation></point>"
    scene = load(tmp_path, "light", inside)
    assert [light.kind for light in scene.lights] == [LightKind.POINT]
    assert "n: lights fade with the square of the distance, whatever their attenuation" in scene.report.ignored


def test_the_sun_and_what_is_no_light(tmp_path: Path) -> None:
    assert load(tmp_path, "light", "<directional><color>5 5 5</color></directional>").lights[0].intensity == (5, 5, 5)
    scene = load(tmp_path, "light", "<ambient><color>1 1 1</color></ambient>")
    assert "n: lights of kind ambient are not shown" in scene.report.ignored
    assert load(tmp_path, "light", "<point/>").lights[0].kind is LightKind.POINT


@pytest.mark.parametrize(
    ("optics", "half_height", "aspect"),
    [
        ("<perspective><yfov>60</yfov><aspect_ratio>2</aspect_ratio></perspective>", tan(radians(30)), 2.0),
        ("<perspective><xfov>90</xfov><aspect_ratio>2</aspect_ratio></perspective>", 0.5, 2.0),
        ("<perspective><xfov>90</xfov><yfov>90</yfov></perspective>", 1.0, 1.0),
        ("<orthographic><xmag>200</xmag><ymag>100</ymag></orthographic>", 1.0, 2.0),
    ],
)
def test_cameras(tmp_path: Path, optics: str, half_height: float, aspect: float) -> None:
    (camera,) = load(tmp_path, "camera", optics).cameras
    assert (camera.half_height, camera.aspect) == (pytest.approx(half_height), pytest.approx(aspect))
    assert camera.orthographic == optics.startswith("<ortho")
    assert camera.to_world[:3, 3] == pytest.approx([0, 3, 0])
    assert -camera.to_world[:3, 2] == pytest.approx([0, -1, 0])


@pytest.mark.parametrize("optics", ["", "<perspective/>", "<perspective><yfov>180</yfov></perspective>"])
def test_a_camera_without_an_extent_is_left_out(tmp_path: Path, optics: str) -> None:
    assert "n: a camera without a field of view was left out" in load(tmp_path, "camera", optics).report.ignored
