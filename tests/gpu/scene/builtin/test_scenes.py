"""Every built-in scene is sound: closed, lit, walkable, the same each time, and as large as it says."""

import subprocess
import sys

import numpy as np
import pytest
from builtin_scenes import face_normals, nearest_hit, scene_of, world_corners

from gpu.scene.builtin import BUILTIN
from gpu.scene.types import LightKind


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("cornell-box", 30, 40),
        ("glass-box", 2000, 2500),
        ("water-box", 6000, 7000),
        ("conference-room", 300_000, 450_000),
        ("living-room", 50_000, 300_000),
        ("atrium", 50_000, 300_000),
    ],
)
def test_has_the_promised_detail_and_nothing_degenerate(name: str, least: int, most: int) -> None:
    scene = scene_of(name)
    assert scene.name == name
    assert least <= len(scene.triangles) <= most
    assert scene.report.dropped_triangles == 0
    assert scene.report.ignored == ()
    assert set(np.unique(scene.triangle_material)) == set(range(len(scene.materials)))


@pytest.mark.parametrize("name", BUILTIN)
def test_is_the_same_each_time(name: str) -> None:
    first, second = scene_of(name), BUILTIN[name]()
    for field in ("vertices", "normals", "uvs", "triangles", "triangle_material"):
        np.testing.assert_array_equal(getattr(first, field), getattr(second, field))
    assert first.materials == second.materials
    for one, other in zip(first.textures, second.textures, strict=True):
        np.testing.assert_array_equal(one.pixels, other.pixels)


@pytest.mark.parametrize("name", BUILTIN)
def test_shading_normals_are_on_the_winding_side(name: str) -> None:
    scene = scene_of(name)
    faces = face_normals(world_corners(scene))
    assert np.einsum("tkc,tc->tk", scene.normals[scene.triangles], faces).min() > 0.25


@pytest.mark.parametrize("name", BUILTIN)
def test_albedos_are_those_of_real_surfaces(name: str) -> None:
    scene = scene_of(name)
    for material in scene.materials:
        assert material.metallic == 0.0
        if material.base_color_slot is None and material.transmission == 0.0:
            assert min(material.base_color[:3]) >= 0.045, material.name
            assert max(material.base_color[:3]) <= 0.85, material.name
    for texture in scene.textures:
        assert texture.srgb
        encoded = texture.pixels[..., :3] / 255.0
        albedo = ((encoded + 0.055) / 1.055) ** 2.4
        assert albedo.min() >= 0.05, texture.name
        assert albedo.max() <= 0.85, texture.name


@pytest.mark.parametrize("name", BUILTIN)
def test_is_lit_and_emitters_shine_inwards(name: str) -> None:
    scene = scene_of(name)
    corners = world_corners(scene)
    emissive = [number for number, material in enumerate(scene.materials) if any(material.emission)]
    assert emissive or scene.lights
    inside = np.array(scene.placement.centre)
    around = ("bulb", "lamp shade", "shade lining")
    flat = [number for number in emissive if scene.materials[number].name not in around]
    for number in flat:
        faces = corners[scene.triangle_material == number]
        away = np.einsum("tc,tc->t", face_normals(faces), inside - faces.mean(axis=1))
        assert (away > 0.0).all(), scene.materials[number].name
    for light in scene.lights:
        assert light.kind is LightKind.DIRECTIONAL
        assert light.direction[1] < 0.0


@pytest.mark.parametrize("name", ["conference-room", "living-room", "atrium"])
def test_cameras_stand_free_on_a_floor(name: str) -> None:
    scene = scene_of(name)
    corners = world_corners(scene)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    normals = face_normals(corners)
    assert len(scene.cameras) >= 2
    assert len({camera.name for camera in scene.cameras}) == len(scene.cameras)
    for camera in scene.cameras:
        eye = camera.to_world[:3, 3]
        assert (low < eye).all()
        assert (eye < high).all()
        height, floor = nearest_hit(corners, eye, np.array([0.0, -1.0, 0.0]))
        assert 0.6 < height < 1.8, camera.name
        assert normals[floor, 1] > 0.9
        ahead, _ = nearest_hit(corners, eye, -camera.to_world[:3, 2])
        assert ahead > 1.5, camera.name
        assert np.linalg.norm(corners.reshape(-1, 3) - eye, axis=1).min() > 0.25


def test_importing_makes_no_scene() -> None:
    code = "import sys, gpu.scene.builtin; sys.exit(any('builtin.' in name for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
