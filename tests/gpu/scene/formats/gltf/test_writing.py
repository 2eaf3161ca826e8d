"""What is written is read again as it was."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes import quad, scene_of

from gpu.scene.camera import look_at
from gpu.scene.edits import LightEdit, MaterialEdit, ObjectEdit, SceneEdits, edited
from gpu.scene.formats.gltf.writing import glb_of
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.lighting.emitted_power import emitted_power
from gpu.scene.load import load_scene
from gpu.scene.parts import lights_of
from gpu.scene.types import AlphaMode, Light, LightKind, Material, Scene, Texture, TextureSlot, Wrap

CHECKS = Texture(
    "checks", np.random.default_rng(1).integers(0, 256, (4, 8, 4), np.uint8), srgb=True, wrap_s=Wrap.MIRROR
)
BUMPS = Texture("bumps", np.random.default_rng(2).integers(0, 256, (2, 2, 4), np.uint8), srgb=False, nearest=True)
TURNED = TextureSlot(0, 0, (0.0, -2.0, 0.25, -3.0, 0.0, 0.5))
MATERIALS = (
    Material("wall", (0.25, 0.5, 0.75, 1.0), 0.25, 0.5, base_color_slot=TURNED, double_sided=True),
    Material("lamp", emission=(4.0, 2.0, 1.0), double_sided=False, normal_slot=TextureSlot(1), normal_scale=0.5),
    Material("leaf", (1.0, 1.0, 1.0, 0.5), alpha_mode=AlphaMode.MASK, alpha_cutoff=0.25, double_sided=False),
    Material(
        "glass",
        transmission=0.75,
        ior=1.25,
        thickness=0.5,
        attenuation_color=(0.5, 1.0, 1.0),
        dispersion=0.25,
        double_sided=True,
    ),
    Material("velvet", sheen_color=(1.0, 0.5, 0.25), sheen_roughness=0.5, double_sided=True),
    Material(
        "soap",
        iridescence=0.5,
        iridescence_ior=1.25,
        iridescence_least=200.0,
        iridescence_most=500.0,
        double_sided=True,
    ),
    Material("paper", diffuse_transmission=0.5, diffuse_transmission_color=(1.0, 0.5, 0.25), double_sided=True),
    Material("steel", metallic=1.0, anisotropy=0.5, anisotropy_rotation=0.25, double_sided=True),
    Material("brocade", specular_slot=TextureSlot(1), specular_color_slot=TextureSlot(0), double_sided=True),
    Material("lacquer", clearcoat=0.5, clearcoat_roughness=0.25, specular=0.5, unlit=True, double_sided=True),
)
LIGHTS = (
    Light("bulb", LightKind.POINT, (4.0, 2.0, 0.0), position=(0.25, 0.5, 1.0)),
    Light("spot", LightKind.SPOT, (1.0, 1.0, 1.0), (0.5, 1.0, 0.5), (0.6, -0.8, 0.0), cos_inner=0.9, cos_outer=0.5),
    Light("sun", LightKind.DIRECTIONAL, (3.0, 3.0, 3.0), direction=(0.0, -1.0, 0.0)),
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A quad of each material, two of which are one object, far from the world's origin."""
    made = [quad((100.0, 0.5 * n, 50.0), (3.0, 0.0, 0.0), (0.0, 0.25, 1.0), n) for n in range(len(MATERIALS))]
    names = "room", "lamp", "room", "pane", "cloth", "bubble", "lampshade", "sink", "curtain", "box"
    parts = [replace(part, name=name) for part, name in zip(made, names, strict=True)]
    lights = [replace(it, position=(100.0 + it.position[0], it.position[1], 50.0)) for it in LIGHTS]
    return scene_of(parts, MATERIALS, lights, textures=(CHECKS, BUMPS))


def read_again(scene: Scene, folder: Path) -> Scene:
    path = folder / "written.glb"
    path.write_bytes(glb_of(scene))
    return load_scene(str(path))


def world_triangles(scene: Scene) -> dict[str, list[np.ndarray]]:
    """Corners of triangles by their object and material."""
    corners = scene.vertices[scene.triangles] / scene.placement.scale + scene.placement.centre
    names = [scene.objects[n] for n in scene.vertex_object[scene.triangles[:, 0]]]
    found: dict[str, list[np.ndarray]] = {}
    for name, material, rows in zip(names, scene.triangle_material, corners, strict=True):
        found.setdefault(f"{name}/{scene.materials[material].name}", []).append(rows)
    return found


def check_same(read: Scene, scene: Scene) -> None:
    ours, theirs = world_triangles(scene), world_triangles(read)
    assert ours.keys() == theirs.keys()
    for name, rows in ours.items():
        np.testing.assert_allclose(theirs[name], rows, atol=1e-5)
    assert len(read.materials) == len(scene.materials)
    for one, other in zip(read.materials, scene.materials, strict=True):
        assert one == replace(other, base_color_slot=one.base_color_slot)
    for a, b in zip(read.lights, scene.lights, strict=True):
        assert (a.name, a.kind) == (b.name, b.kind)
        growth = 1.0 if a.kind is LightKind.DIRECTIONAL else (read.placement.scale / scene.placement.scale) ** 2
        np.testing.assert_allclose(a.intensity, np.array(b.intensity) * growth, rtol=1e-6)
        if a.kind is not LightKind.DIRECTIONAL:
            places = [
                np.array(it.position) / s.placement.scale + s.placement.centre for it, s in ((a, read), (b, scene))
            ]
            np.testing.assert_allclose(*places, atol=1e-6)
        if a.kind is not LightKind.POINT:
            np.testing.assert_allclose(a.direction, b.direction, atol=1e-6)
    assert [(it.cos_inner, it.cos_outer) for it in read.lights][1] == pytest.approx((0.9, 0.5))


def test_a_scene_is_read_as_it_was_written(scene: Scene, tmp_path: Path) -> None:
    read = read_again(scene, tmp_path)
    check_same(read, scene)
    slot = read.materials[0].base_color_slot
    assert slot is not None
    assert slot.transform == pytest.approx(TURNED.transform)
    for one, other in zip(read.textures, (CHECKS, BUMPS), strict=True):
        np.testing.assert_array_equal(one.pixels, other.pixels)
        assert (one.srgb, one.wrap_s, one.wrap_t, one.nearest) == (
            other.srgb,
            other.wrap_s,
            other.wrap_t,
            other.nearest,
        )
    np.testing.assert_allclose(read.uvs[0][read.triangles[:2]], scene.uvs[0][scene.triangles[:2]])
    assert read.report.ignored == ()


def test_what_was_edited_is_in_the_file(scene: Scene, tmp_path: Path) -> None:
    edits = SceneEdits(
        lights={"bulb": LightEdit(intensity=0.5, position=(101.0, 1.0, 50.5))},
        materials={"wall": MaterialEdit(color=(1.0, 0.0, 0.0), roughness=1.0)},
        objects={"pane": ObjectEdit(visible=False), "lamp": ObjectEdit(offset=(0.0, 0.25, 0.0))},
    )
    there = edited(scene, edits)
    read = read_again(there, tmp_path)
    check_same(read, there)
    assert "pane/glass" not in world_triangles(read)


def test_cameras_look_as_they_did(scene: Scene, tmp_path: Path) -> None:
    view = look_at((101.0, 1.0, 55.0), (101.0, 1.0, 50.0), yfov_degrees=40.0, aspect=1.5, name="front")
    plan = replace(view, name="plan", orthographic=True, half_height=2.0)
    read = read_again(replace(scene, cameras=(view, plan)), tmp_path)
    for one, other in zip(read.cameras, (view, plan), strict=True):
        assert (one.name, one.orthographic) == (other.name, other.orthographic)
        assert (one.half_height, one.aspect) == pytest.approx((other.half_height, other.aspect))
        np.testing.assert_allclose(one.to_world, other.to_world, atol=1e-9)


def test_a_lamp_whose_file_tells_no_sides_is_seen_from_behind_and_stays_dark_there(tmp_path: Path) -> None:
    lamp = Material("lamp", (0.5, 0.25, 1.0, 1.0), emission=(4.0, 2.0, 1.0), emission_slot=TextureSlot(0))
    made = scene_of([replace(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), name="panel")], [lamp], textures=(CHECKS,))
    read = read_again(made, tmp_path)
    assert read.objects == ("panel",)
    front, back = read.materials
    assert (front.emission, front.double_sided) == (lamp.emission, False)
    assert (back.base_color, back.emits, back.double_sided) == (lamp.base_color, False, False)
    assert back.emission_slot is None
    sides = area_vectors(read.vertices.astype(np.float64), read.triangles)
    assert (np.sign(sides[:, 2]) == np.where(read.triangle_material == 0, 1.0, -1.0)).all()
    assert (np.sign(read.normals[read.triangles[:, 0], 2]) == np.sign(sides[:, 2])).all()
    assert [part.id for part in lights_of(read) if not part.added] == ["lamp"]
    assert emitted_power(read).sum() == pytest.approx(emitted_power(made).sum())
