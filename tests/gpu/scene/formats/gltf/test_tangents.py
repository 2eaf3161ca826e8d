"""Directions of anisotropy by tangents: of the triangle u grows along x, the image's top is against v, along −y."""

import numpy as np
import pytest
from gltf_file import TRIANGLE, UV, GltfFile

BRUSHED = {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 0.25}}


def tangents(*degrees: float) -> np.ndarray:
    """Those of a triangle's corners, counter-clockwise from x where −y is a quarter turn from there."""
    angles = np.radians(degrees)
    return np.stack([np.cos(angles), -np.sin(angles), 0.0 * angles, 1.0 + 0.0 * angles], axis=1).astype(np.float32)


@pytest.mark.parametrize(("degrees", "turned"), [(30.0, 30.0), (-150.0, 30.0), (80.0, 80.0), (180.0, 0.0), (0.5, 0.0)])
def test_tangents_turn_a_grain_from_its_uvs(gltf: GltfFile, degrees: float, turned: float) -> None:
    gltf.add("materials", name="steel", extensions=BRUSHED)
    gltf.mesh_node(gltf.primitive(TEXCOORD_0=UV, TANGENT=tangents(*[degrees] * 3), material=0))
    scene = gltf.load()
    (used,) = {scene.materials[number] for number in scene.triangle_material}
    assert used.anisotropy_rotation == pytest.approx(0.25 + np.radians(turned), abs=1e-3)
    assert scene.report.ignored == ()


def test_a_material_that_all_meshes_turn_is_itself_turned(gltf: GltfFile) -> None:
    """So that what names it, and animates it, finds what is shown."""
    gltf.add("materials", name="plain")
    gltf.add("materials", name="steel", extensions=BRUSHED)
    gltf.mesh_node(*(gltf.primitive(TRIANGLE + k, TEXCOORD_0=UV, TANGENT=tangents(*[degrees] * 3), material=1)
                     for k, degrees in enumerate((30.0, 60.0))), gltf.primitive(TRIANGLE + 2))  # fmt: skip
    scene = gltf.load()
    assert scene.triangle_material.tolist() == [1, 3, 2]
    assert [material.name for material in scene.materials] == ["plain", "steel", "glTF default", "steel"]
    turns = [material.anisotropy_rotation - 0.25 for material in scene.materials if material.has_grain]
    assert np.degrees(turns) == pytest.approx([30.0, 60.0], abs=0.1)


def test_meshes_with_other_tangents_have_materials_of_their_own(gltf: GltfFile) -> None:
    gltf.add("materials", name="steel", extensions=BRUSHED)
    plain = gltf.primitive(TEXCOORD_0=UV, material=0)
    gltf.mesh_node(plain, *(gltf.primitive(TRIANGLE + k, TEXCOORD_0=UV, TANGENT=tangents(*[30.0] * 3), material=0)
                            for k in (1, 2)))  # fmt: skip
    scene = gltf.load()
    turns = [round(scene.materials[number].anisotropy_rotation, 2) for number in scene.triangle_material]
    assert turns == [0.25, 0.77, 0.77]
    assert [material.name for material in scene.materials] == ["steel", "steel"]


def test_tangents_that_turn_from_place_to_place_are_taken_in_the_mean(gltf: GltfFile) -> None:
    gltf.add("materials", extensions=BRUSHED)
    corners = np.concatenate([TRIANGLE, TRIANGLE + 2])
    turning = np.concatenate([tangents(*[20.0] * 3), tangents(*[80.0] * 3)])
    gltf.mesh_node(gltf.primitive(corners, TEXCOORD_0=np.tile(UV, (2, 1)), TANGENT=turning, material=0))
    scene = gltf.load()
    assert scene.materials[-1].anisotropy_rotation == pytest.approx(0.25 + np.radians(50.0), abs=1e-3)
    assert any("tangents that turn against its UVs" in note for note in scene.report.notes)


def test_without_uvs_tangents_turn_nothing(gltf: GltfFile) -> None:
    gltf.add("materials", extensions=BRUSHED)
    gltf.mesh_node(gltf.primitive(TANGENT=tangents(30.0, 30.0, 30.0), material=0))
    scene = gltf.load()
    assert [material.anisotropy_rotation for material in scene.materials] == [0.25]
