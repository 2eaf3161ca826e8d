from math import cos, radians, tan

import numpy as np
import pytest
from gltf_file import GltfFile

from gpu.errors import SceneError
from gpu.scene.types import LightKind

HALF = float(np.sqrt(0.5))
DOWN = [-HALF, 0, 0, HALF]  # turns −Z to −Y


def lit(gltf: GltfFile, light: dict, **node: object) -> None:
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
        ({}, "lights[0]: 'type' is missing"),
        ({"type": "sun"}, "lights[0].type: must be one of point, spot, directional"),
        ({"type": "point", "intensity": -1}, "lights[0].intensity"),
        ({"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.5}}, "spot.innerConeAngle"),
    ],
)
def test_broken_lights(gltf: GltfFile, light: dict, says: str) -> None:
    lit(gltf, light)
    with pytest.raises(SceneError) as caught:
        gltf.load()
    assert says in str(caught.value)


def test_a_perspective_camera_under_a_scaled_node(gltf: GltfFile) -> None:
    gltf.add("cameras", type="perspective", perspective={"yfov": radians(90), "aspectRatio": 2.0, "znear": 0.1})
    child = gltf.add("nodes", camera=0, rotation=DOWN, name="eye")
    gltf.add("nodes", children=[child], translation=[0, 7, 0], scale=[2, 2, 2])
    gltf.mesh_node()
    (camera,) = gltf.load().cameras
    assert camera.name == "eye"
    assert np.allclose(camera.half_height, tan(radians(45)))
    assert camera.aspect == 2.0
    assert np.allclose(camera.to_world[:3, 3], (0, 7, 0))
    assert np.allclose(-camera.to_world[:3, 2], (0, -1, 0))
    assert np.allclose(np.linalg.det(camera.to_world), 1.0)


def test_an_orthographic_camera(gltf: GltfFile) -> None:
    gltf.add("cameras", type="orthographic", orthographic={"xmag": 6, "ymag": 3, "znear": 0, "zfar": 9}, name="plan")
    gltf.add("nodes", camera=0)
    gltf.mesh_node()
    (camera,) = gltf.load().cameras
    assert (camera.name, camera.orthographic, camera.half_height, camera.aspect) == ("plan", True, 3.0, 2.0)


@pytest.mark.parametrize(
    ("camera", "says"),
    [
        ({"type": "fisheye"}, "cameras[0].type"),
        ({"type": "perspective"}, "'perspective' is missing"),
        ({"type": "perspective", "perspective": {"yfov": 4}}, "cameras[0].perspective.yfov"),
        ({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}}, "must not be 0"),
    ],
)
def test_broken_cameras(gltf: GltfFile, camera: dict, says: str) -> None:
    gltf.add("cameras", **camera)
    gltf.add("nodes", camera=0)
    gltf.mesh_node()
    with pytest.raises(SceneError) as caught:
        gltf.load()
    assert says in str(caught.value)
