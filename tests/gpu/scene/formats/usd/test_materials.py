import numpy as np
import pytest
from usd_file import UsdFile

from gpu.scene.types import AlphaMode, Material, Scene

pytest.importorskip("pxr")
from pxr import UsdGeom, UsdShade


def only_material(scene: Scene) -> Material:
    (material,) = scene.materials
    return material


def pixel(scene: Scene, slot: str) -> list[int]:
    texture = scene.textures[getattr(only_material(scene), slot).texture]
    return texture.pixels[0, 0].tolist()


def test_values(usd: UsdFile) -> None:
    usd.material(
        usd.mesh(), diffuseColor=(0.5, 0.25, 0.125), emissiveColor=(1.0, 2.0, 3.0), metallic=0.5, roughness=0.75,
        ior=1.25, clearcoat=0.5,
    )  # fmt: skip
    scene = usd.load()
    material = only_material(scene)
    assert material.name == "Material"
    assert material.base_color == (0.5, 0.25, 0.125, 1.0)
    assert material.emission == (1.0, 2.0, 3.0)
    assert (material.metallic, material.roughness, material.ior) == (0.5, 0.75, 1.25)
    assert material.alpha_mode is AlphaMode.OPAQUE
    assert "clearcoat of materials is not shown" in scene.report.ignored


def test_defaults(usd: UsdFile) -> None:
    usd.material(usd.mesh())
    material = only_material(usd.load())
    assert material.base_color == (0.18, 0.18, 0.18, 1.0)
    assert (material.metallic, material.roughness, material.ior) == (0.0, 0.5, 1.5)


@pytest.mark.parametrize(
    ("inputs", "mode", "cutoff"),
    [
        ({"opacity": 0.25}, AlphaMode.BLEND, 0.5),
        ({"opacity": 0.25, "opacityThreshold": 0.125}, AlphaMode.MASK, 0.125),
        ({"opacityThreshold": 0.125}, AlphaMode.OPAQUE, 0.125),
    ],
)
def test_opacity(usd: UsdFile, inputs: dict, mode: AlphaMode, cutoff: float) -> None:
    usd.material(usd.mesh(), **inputs)
    material = only_material(usd.load())
    assert (material.alpha_mode, material.alpha_cutoff) == (mode, cutoff)
    assert material.base_color[3] == inputs.get("opacity", 1.0)


def test_specular_workflow(usd: UsdFile) -> None:
    usd.material(usd.mesh(), useSpecularWorkflow=1, specularColor=(0.08, 0.04, 0.0), metallic=1.0)
    material = only_material(usd.load())
    assert material.metallic == 0.0
    assert material.specular_color == pytest.approx((2.0, 1.0, 0.0), rel=1e-5)


def test_a_colour_texture_with_its_own_alpha(usd: UsdFile) -> None:
    texture = usd.texture("/T", usd.image("a.png", [[(10, 20, 30, 40)]]), scale=(0.5, 1.0, 1.0, 1.0))
    usd.material(usd.mesh(), diffuseColor=(texture, "rgb"), opacity=(texture, "a"))
    scene = usd.load()
    material = only_material(scene)
    assert pixel(scene, "base_color_slot") == [10, 20, 30, 40]
    assert material.base_color == (0.5, 1.0, 1.0, 1.0)
    assert material.alpha_mode is AlphaMode.BLEND
    assert scene.textures[0].srgb


def test_alpha_of_another_texture(usd: UsdFile) -> None:
    color = usd.texture("/T", usd.image("a.png", [[(10, 20, 30), (50, 60, 70)]]))
    mask = usd.texture("/M", usd.image("b.png", [[(128, 0, 0)], [(0, 0, 0)]]), sourceColorSpace="raw")
    usd.material(usd.mesh(), diffuseColor=(color, "rgb"), opacity=(mask, "r"), opacityThreshold=0.5)
    scene = usd.load()
    assert scene.textures[0].pixels.shape == (2, 2, 4)
    assert scene.textures[0].pixels[0].tolist() == [[10, 20, 30, 128], [50, 60, 70, 128]]
    assert scene.textures[0].pixels[1, :, 3].tolist() == [0, 0]


def test_alpha_alone(usd: UsdFile) -> None:
    mask = usd.texture("/M", usd.image("b.png", [[(128, 0, 0)]]), sourceColorSpace="raw")
    usd.material(usd.mesh(), diffuseColor=(0.5, 0.5, 0.5), opacity=(mask, "r"))
    scene = usd.load()
    assert pixel(scene, "base_color_slot") == [255, 255, 255, 128]
    assert only_material(scene).base_color == (0.5, 0.5, 0.5, 1.0)


def test_metallic_and_roughness_become_one_texture(usd: UsdFile) -> None:
    rough = usd.texture("/R", usd.image("r.png", [[(100, 0, 0)]]), sourceColorSpace="raw", scale=(0.5, 1.0, 1.0, 1.0))
    metal = usd.texture("/M", usd.image("m.png", [[(0, 200, 0)]]), sourceColorSpace="raw")
    usd.material(usd.mesh(), roughness=(rough, "r"), metallic=(metal, "g"))
    scene = usd.load()
    assert pixel(scene, "metallic_roughness_slot") == [255, 50, 200, 255]
    assert (only_material(scene).metallic, only_material(scene).roughness) == (1.0, 1.0)
    assert not scene.textures[0].srgb


def test_roughness_with_a_metallic_value(usd: UsdFile) -> None:
    rough = usd.texture("/R", usd.image("r.png", [[(100, 0, 0)]]), sourceColorSpace="raw")
    usd.material(usd.mesh(), roughness=(rough, "r"), metallic=0.25)
    scene = usd.load()
    assert pixel(scene, "metallic_roughness_slot") == [255, 100, 255, 255]
    assert only_material(scene).metallic == 0.25


@pytest.mark.parametrize(
    ("scale", "bias", "expected"),
    [
        ((2.0, 2.0, 2.0, 1.0), (-1.0, -1.0, -1.0, 0.0), [10, 20, 240]),
        ((2.0, -2.0, 2.0, 1.0), (-1.0, 1.0, -1.0, 0.0), [10, 235, 240]),  # green points down, as DirectX has it
        ((1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0), [10, 20, 240]),
    ],
)
def test_normal_maps(usd: UsdFile, scale: tuple, bias: tuple, expected: list[int]) -> None:
    texture = usd.texture("/N", usd.image("n.png", [[(10, 20, 240)]]), sourceColorSpace="raw", scale=scale, bias=bias)
    usd.material(usd.mesh(), normal=(texture, "rgb"))
    assert pixel(usd.load(), "normal_slot")[:3] == expected


def test_emission_textures_have_a_strength(usd: UsdFile) -> None:
    texture = usd.texture("/E", usd.image("e.png", [[(10, 20, 30)]]), scale=(5.0, 5.0, 5.0, 1.0))
    usd.material(usd.mesh(), emissiveColor=(texture, "rgb"))
    scene = usd.load()
    assert only_material(scene).emission == (5.0, 5.0, 5.0)
    assert pixel(scene, "emission_slot")[:3] == [10, 20, 30]


def test_display_color_without_a_material(usd: UsdFile) -> None:
    usd.mesh("/Grey")
    mesh = usd.mesh("/Red")
    usd.primvar(mesh, "displayColor", "Color3fArray", "constant", [(1.0, 0.0, 0.0)])
    usd.primvar(mesh, "displayOpacity", "FloatArray", "constant", [0.5])
    scene = usd.load()
    assert [material.base_color[0] for material in scene.materials] == [0.18, 1.0]
    assert [material.alpha_mode for material in scene.materials] == [AlphaMode.OPAQUE, AlphaMode.BLEND]
    assert np.allclose(scene.colors[-4:], (1.0, 0.0, 0.0, 0.5))


def test_display_color_read_by_a_material(usd: UsdFile) -> None:
    mesh = usd.mesh()
    usd.primvar(mesh, "displayColor", "Color3fArray", "constant", [(1.0, 0.5, 0.0)])
    reader = usd.shader("/Reader", "UsdPrimvarReader_float3", varname="displayColor")
    usd.material(mesh, diffuseColor=(reader, "result"))
    scene = usd.load()
    assert only_material(scene).base_color == (1.0, 1.0, 1.0, 1.0)
    assert np.allclose(scene.colors, (1.0, 0.5, 0.0, 1.0))


def test_inputs_of_the_material_count(usd: UsdFile) -> None:
    material = usd.material(usd.mesh())
    from pxr import Sdf

    rough = material.CreateInput("roughness", Sdf.ValueTypeNames.Float)
    rough.Set(0.25)
    UsdShade.Shader(usd.stage.GetPrimAtPath("/Material/Surface")).CreateInput(
        "roughness", Sdf.ValueTypeNames.Float
    ).ConnectToSource(rough)
    assert only_material(usd.load()).roughness == 0.25


def test_other_shaders_are_said(usd: UsdFile) -> None:
    mesh = usd.mesh()
    material = UsdShade.Material.Define(usd.stage, "/Other")
    shader = usd.shader("/Other/S", "ND_standard_surface_surfaceshader")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "out")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    assert any("without a UsdPreviewSurface" in sentence for sentence in usd.load().report.ignored)


def test_inherited_bindings(usd: UsdFile) -> None:
    parent = UsdGeom.Xform.Define(usd.stage, "/Parent")
    usd.mesh("/Parent/Mesh")
    usd.material(parent, roughness=0.125)
    assert only_material(usd.load()).roughness == 0.125
