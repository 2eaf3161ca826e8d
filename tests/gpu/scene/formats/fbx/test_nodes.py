import numpy as np
import pytest
from fbx_file import FbxFile

from gpu.scene.formats.fbx import load_fbx
from gpu.scene.types import LightKind, Scene

pytest.importorskip("ufbx")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """A file with one of each, in centimetres with +Z up."""
    fbx = FbxFile(tmp_path_factory.mktemp("fbx"), up=2)
    floor = fbx.node("Floor", "Mesh", Lcl_Translation=(0.0, 0.0, 50.0))
    fbx.mesh(floor, (0, 0, 0, 100, 0, 0, 100, 100, 0, 0, 100, 0, 200, 0, 0), "0,1,2,-4,1,4,-3", (0, 1), uv=False)
    for name, color in (("Red", (0.5, 0.0, 0.0)), ("Green", (0.0, 0.5, 0.0))):
        fbx.material(floor, name, DiffuseColor=color)
    fbx.mesh(fbx.node("Hidden", "Mesh", Visibility=0.0))
    lamp = fbx.node("Lamp", "Light", Lcl_Translation=(100.0, 200.0, 300.0))
    fbx.attribute(lamp, "Light", LightType=0, Color=(1.0, 0.5, 0.25), Intensity=200.0, DecayType=2)
    spot = fbx.node("Spot", "Light")
    fbx.attribute(spot, "Light", LightType=2, Intensity=100.0, InnerAngle=60.0, OuterAngle=120.0)
    sun = fbx.node("Sun", "Light", Lcl_Rotation=(90.0, 0.0, 0.0))
    fbx.attribute(sun, "Light", LightType=1, Intensity=300.0)
    view = fbx.node("View", "Camera", Lcl_Translation=(0.0, -300.0, 100.0), Lcl_Rotation=(90.0, 0.0, 90.0))
    fbx.attribute(view, "Camera", FieldOfView=60.0, AspectWidth=320.0, AspectHeight=240.0, ApertureMode=2)
    return load_fbx(fbx.write())


def world(scene: Scene) -> np.ndarray:
    return (scene.vertices / scene.placement.scale + scene.placement.centre)[scene.triangles]


def test_meshes_are_in_metres_with_y_up(room: Scene) -> None:
    corners = world(room)
    assert np.allclose(corners.reshape(-1, 3).min(axis=0), (0.0, 0.5, -1.0), atol=1e-5)
    assert np.allclose(corners.reshape(-1, 3).max(axis=0), (2.0, 0.5, 0.0), atol=1e-5)
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 1] > 0.0).all()
    assert room.frame.up == "z"
    assert room.frame.metres_per_unit == pytest.approx(0.01)


def test_polygons_have_materials_of_their_own(room: Scene) -> None:
    names = [room.materials[number].name for number in room.triangle_material]
    assert sorted(names) == ["Green", "Red", "Red"]


def test_lights(room: Scene) -> None:
    lamp, spot, sun = room.lights
    assert [light.kind for light in room.lights] == [LightKind.POINT, LightKind.SPOT, LightKind.DIRECTIONAL]
    position = np.array(lamp.position) / room.placement.scale + room.placement.centre
    assert np.allclose(position, (1.0, 3.0, -2.0), atol=1e-6)
    assert np.array(lamp.intensity) / room.placement.scale**2 == pytest.approx((2.0, 1.0, 0.5))
    assert (spot.cos_inner, spot.cos_outer) == pytest.approx((np.cos(np.pi / 6), np.cos(np.pi / 3)))
    assert sun.intensity == pytest.approx((3.0, 3.0, 3.0))
    assert sun.direction == pytest.approx((0.0, -1.0, 0.0), abs=1e-6)


def test_cameras(room: Scene) -> None:
    (view,) = room.cameras
    assert view.name == "View"
    assert view.half_height == pytest.approx(np.tan(np.pi / 6))
    assert view.aspect == pytest.approx(4.0 / 3.0)
    assert np.allclose(view.to_world[:3, 3], (0.0, 1.0, 3.0), atol=1e-6)
    assert np.allclose(-view.to_world[:3, 2], (0.0, 0.0, -1.0), atol=1e-6)


def test_what_is_not_shown_is_said(room: Scene) -> None:
    assert "Hidden: invisible nodes were left out" in room.report.ignored
    assert any(s.startswith("Spot: lights fade with the square of the distance") for s in room.report.ignored)
