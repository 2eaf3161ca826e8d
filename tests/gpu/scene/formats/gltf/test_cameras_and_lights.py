from math import cos, pi, radians, tan
from typing import Any

import numpy as np
import pytest
from gltf_file import GltfFile

from gpu.scene.types import LightKind

HALF = float(np.sqrt(0.5))
DOWN = [-HALF, 0, 0, HALF]  # turns −Z to −Y


def lit(gltf: GltfFile, light: Any, **node: object) -> None:
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    gltf.add("nodes", extensions={"KHR_lights_punctual": {"light": 0}}, **node)
    gltf.mesh_node(scale=[10, 10, 10])


def test_a_point_lights_intensity_shrinks_with_the_square_of_the_scene(gltf: GltfFile) -> None:
    lit(gltf, {"type": "point", "intensity": 200, "color": [1, 0.5, 0]}, translation=[5, 5, 10], scale=[3, 3, 3])
    (light,) = gltf.load().lights
    assert light.kind is LightKind.POINT
    assert np.allclose(light.intensity, (2, 1, 0))  # 10 units become 1
    assert np.allclose(light.position, (0, 0, 1))


def test_a_directional_light_goes_along_its_nodes_minus_z(gltf: GltfFile) -> None:
    lit(gltf, {"type": "directional", "intensity": 3}, rotation=DOWN, scale=[2, 2, 2])
    (light,) = gltf.load().lights
    assert light.kind is LightKind.DIRECTIONAL
    assert np.allclose(light.direction, (0, -1, 0))
    assert np.allclose(light.intensity, (3, 3, 3))  # irradiance does not depend on the scene's size


def test_a_spot_lights_cones(gltf: GltfFile) -> None:
    lit(gltf, {"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}})
    (light,) = gltf.load().lights
    assert light.kind is LightKind.SPOT
    assert np.allclose((light.cos_inner, light.cos_outer), (cos(0.2), cos(0.5)))


def test_a_spot_lights_default_cones(gltf: GltfFile) -> None:
    lit(gltf, {"type": "spot", "spot": {}})
    (light,) = gltf.load().lights
    assert np.allclose((light.cos_inner, light.cos_outer), (1.0, HALF))


@pytest.mark.parametrize(
    ("light", "says"),
    [
        ({}, "lights[0]: 'type' is missing; the light was left out"),
        ({"type": "sun"}, "lights[0].type: must be one of point, spot, directional"),
        (None, "lights[0]: must be an object; the light was left out"),
    ],
)
def test_a_broken_light_is_left_out(gltf: GltfFile, light: Any, says: str) -> None:
    lit(gltf, light)
    scene = gltf.load()
    assert scene.lights == ()
    assert says in scene.report.ignored[0]


def test_a_light_that_does_not_exist_is_left_out_and_the_others_stay(gltf: GltfFile) -> None:
    lit(gltf, {"type": "point"})
    gltf.add("nodes", extensions={"KHR_lights_punctual": {"light": 1}})
    scene = gltf.load()
    assert len(scene.lights) == 1
    assert "KHR_lights_punctual.light: 1 does not exist, there are 1; the light" in scene.report.ignored[0]


@pytest.mark.parametrize(
    ("light", "attribute", "value", "says"),
    [
        ({"type": "point", "intensity": -1}, "intensity", (0, 0, 0), "lights[0].intensity: must be between 0"),
        ({"type": "point", "intensity": "1"}, "intensity", (0.01,) * 3, "lights[0].intensity: must be a number"),
        (
            {"type": "point", "color": [1, -1]},
            "intensity",
            (0.01, 0, 0.01),
            "lights[0].color: must have 3 numbers, not 2",
        ),
        (
            {"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.5}},
            "cos_inner",
            cos(0.5),
            "innerConeAngle",
        ),
        (
            {"type": "spot", "spot": {"outerConeAngle": 3}},
            "cos_outer",
            0.0,
            "outerConeAngle: must be between 0 and 1.5708",
        ),
        ({"type": "spot", "spot": {"outerConeAngle": float(np.float32(pi / 2))}}, "cos_outer", 0.0, ""),
    ],
)
def test_what_is_odd_of_a_light_is_mended(gltf: GltfFile, light: dict, attribute: str, value: Any, says: str) -> None:
    lit(gltf, light)
    scene = gltf.load()
    assert np.allclose(getattr(scene.lights[0], attribute), value)
    assert any(says in note for note in scene.report.notes) if says else "Angle" not in str(scene.report)


def test_ranges_of_lights_are_ignored_and_said_once(gltf: GltfFile) -> None:
    lit(gltf, {"type": "point", "range": 3, "name": "lamp"})
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"].append({"type": "point", "range": 5})
    gltf.add("nodes", extensions={"KHR_lights_punctual": {"light": 1}})
    (sentence,) = gltf.load().report.ignored
    assert sentence.startswith("lamp: its range was ignored")
    assert sentence.endswith("(likewise extensions.KHR_lights_punctual.lights[1])")


def test_a_perspective_camera_under_a_scaled_node(gltf: GltfFile) -> None:
    gltf.add("cameras", type="perspective", perspective={"yfov": radians(90), "aspectRatio": 2.0, "znear": 0.1})
    child = gltf.add("nodes", camera=0, rotation=DOWN, name="eye")
    gltf.add("nodes", children=[child], translation=[0, 7, 0], scale=[2, 2, 2])
    gltf.mesh_node()
    (camera,) = gltf.load().cameras
    assert camera.name == "eye"
    assert np.allclose(camera.half_height, tan(radians(45)))
    assert (camera.aspect, camera.near) == (2.0, 0.1)
    assert np.allclose(camera.to_world[:3, 3], (0, 7, 0))
    assert np.allclose(-camera.to_world[:3, 2], (0, -1, 0))
    assert np.allclose(np.linalg.det(camera.to_world), 1.0)


def test_an_orthographic_camera(gltf: GltfFile) -> None:
    gltf.add("cameras", type="orthographic", orthographic={"xmag": 6, "ymag": 3, "znear": 2, "zfar": 9}, name="plan")
    gltf.add("nodes", camera=0)
    gltf.mesh_node()
    (camera,) = gltf.load().cameras
    assert (camera.name, camera.orthographic, camera.half_height, camera.aspect) == ("plan", True, 3.0, 2.0)
    assert camera.near == 2.0


def test_what_has_no_name_is_told_by_its_number(gltf: GltfFile) -> None:
    """As materials are: a page lists them, and a path in the file says nothing there."""
    lit(gltf, {"type": "point"})
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0, "znear": 0.1})
    gltf.add("nodes", camera=0)
    scene = gltf.load()
    assert (scene.lights[0].name, scene.cameras[0].name) == ("light 0", "camera 0")


@pytest.mark.parametrize(
    ("camera", "says"),
    [
        ({"type": "fisheye"}, "cameras[0].type"),
        ({"type": "perspective"}, "'perspective' is missing"),
        ({"type": "perspective", "perspective": {"yfov": 4}}, "cameras[0].perspective.yfov"),
        ({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}}, "must not be 0"),
    ],
)
def test_a_broken_camera_is_left_out(gltf: GltfFile, camera: dict, says: str) -> None:
    gltf.add("cameras", **camera)
    gltf.add("nodes", camera=0)
    gltf.mesh_node()
    report = gltf.load().report
    assert says in report.ignored[0]
    assert report.ignored[0].endswith("the camera was left out")
    assert "the scene has no camera: a view was chosen" in report.notes


@pytest.mark.parametrize(("far", "said"), [(7.5, 0), (6.5, 1), (None, 0)])
def test_a_far_plane_in_front_of_the_scenes_end_is_said(gltf: GltfFile, far: float | None, said: int) -> None:
    lens = {"xmag": 1, "ymag": 1, "znear": 0, **({"zfar": far} if far else {})}
    gltf.add("cameras", type="orthographic", orthographic=lens, name="plan")
    gltf.add("nodes", camera=0, translation=[0, 7, 0], rotation=DOWN, scale=[2, 2, 2])
    gltf.mesh_node()
    notes = [note for note in gltf.load().report.notes if "zfar" in note]
    assert notes == ["plan: what lies beyond its far plane (zfar) is shown all the same"] * said


def test_an_odd_aspect_ratio_is_mended(gltf: GltfFile) -> None:
    gltf.add("cameras", type="perspective", perspective={"yfov": 1.0, "aspectRatio": None})
    gltf.add("nodes", camera=0, name=7)
    gltf.mesh_node()
    scene = gltf.load()
    assert (scene.cameras[0].aspect, scene.cameras[0].name) == (16.0 / 9.0, "camera 0")
    assert {note.split(":")[0] for note in scene.report.notes} >= {
        "nodes[0].name",
        "cameras[0].perspective.aspectRatio",
    }
