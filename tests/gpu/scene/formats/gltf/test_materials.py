from math import inf, pi

import numpy as np
import pytest
from gltf_file import UV, GltfFile, image, material_of

from gpu.scene.types import AlphaMode, Material


def test_defaults_are_those_of_the_specification(gltf: GltfFile) -> None:
    material = material_of(gltf)
    assert (material.base_color, material.metallic, material.roughness) == ((1, 1, 1, 1), 1.0, 1.0)
    assert (material.emission, material.ior, material.specular) == ((0, 0, 0), 1.5, 1.0)
    assert (material.alpha_mode, material.alpha_cutoff, material.attenuation_distance) == (AlphaMode.OPAQUE, 0.5, inf)
    assert material.double_sided is False
    assert not material.unlit


def test_every_factor_is_read(gltf: GltfFile) -> None:
    material = material_of(
        gltf,
        name="all",
        pbrMetallicRoughness={"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0, "roughnessFactor": 0.5},
        emissiveFactor=[1, 0.5, 0],
        alphaMode="MASK",
        alphaCutoff=0.7,
        doubleSided=True,
        extensions={
            "KHR_materials_emissive_strength": {"emissiveStrength": 10},
            "KHR_materials_unlit": {},
            "KHR_materials_transmission": {"transmissionFactor": 0.9},
            "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_dispersion": {"dispersion": 0.36},
            "KHR_materials_volume": {"thicknessFactor": 2, "attenuationDistance": 3, "attenuationColor": [0, 1, 0]},
            "KHR_materials_specular": {"specularFactor": 0.25, "specularColorFactor": [1, 2, 3]},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.125},
            "KHR_materials_sheen": {"sheenColorFactor": [1, 0.5, 0.25], "sheenRoughnessFactor": 0.75},
            "KHR_materials_iridescence": {
                "iridescenceFactor": 0.5,
                "iridescenceIor": 1.75,
                "iridescenceThicknessMinimum": 200,
                "iridescenceThicknessMaximum": 600,
            },
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": -1.5},
            "KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 0.75,
                "diffuseTransmissionColorFactor": [1, 0.5, 0.25],
            },
        },
    )
    assert material == Material(
        name="all",
        base_color=(0.1, 0.2, 0.3, 0.4),
        metallic=0.0,
        roughness=0.5,
        emission=(10.0, 5.0, 0.0),
        alpha_mode=AlphaMode.MASK,
        alpha_cutoff=0.7,
        double_sided=True,
        unlit=True,
        transmission=0.9,
        ior=1.33,
        dispersion=0.36,
        thickness=2.0,
        attenuation_color=(0.0, 1.0, 0.0),
        attenuation_distance=3.0,
        specular=0.25,
        specular_color=(1.0, 2.0, 3.0),
        clearcoat=0.5,
        clearcoat_roughness=0.125,
        sheen_color=(1.0, 0.5, 0.25),
        sheen_roughness=0.75,
        iridescence=0.5,
        iridescence_ior=1.75,
        iridescence_least=200.0,
        iridescence_most=600.0,
        anisotropy=0.5,
        anisotropy_rotation=-1.5,
        diffuse_transmission=0.75,
        diffuse_transmission_color=(1.0, 0.5, 0.25),
    )


def extension(name: str, **values: object) -> dict:
    return {"extensions": {f"KHR_materials_{name}": values}}


def metal(**values: object) -> dict:
    return {"pbrMetallicRoughness": values}


@pytest.mark.parametrize(
    ("material", "attribute", "value", "place"),
    [
        (metal(baseColorFactor=[1.0000001192, -0.5, 2, 1]), "base_color", (1, 0, 1, 1), "baseColorFactor[0]"),
        (metal(baseColorFactor=[0.5, 0.25, "x"]), "base_color", (0.5, 0.25, 1, 1), "baseColorFactor"),
        (metal(baseColorFactor=0.5), "base_color", (1, 1, 1, 1), "baseColorFactor"),
        (metal(baseColorFactor=[float("nan")] * 4), "base_color", (1, 1, 1, 1), "baseColorFactor[0]"),
        (metal(roughnessFactor=-1), "roughness", 0, "roughnessFactor"),
        (metal(metallicFactor=1.5), "metallic", 1, "metallicFactor"),
        ({"pbrMetallicRoughness": 3}, "roughness", 1, "pbrMetallicRoughness"),
        ({"alphaMode": "GLASS"}, "alpha_mode", AlphaMode.OPAQUE, "alphaMode"),
        ({"alphaMode": ["MASK"]}, "alpha_mode", AlphaMode.OPAQUE, "alphaMode"),
        ({"alphaCutoff": -1}, "alpha_cutoff", 0, "alphaCutoff"),
        ({"doubleSided": "yes"}, "name", "material 0", "doubleSided"),
        ({"name": 5}, "name", "material 0", "name"),
        ({"emissiveFactor": [1, 2, -1]}, "emission", (1, 2, 0), "emissiveFactor[2]"),
        ({"emissiveFactor": [5, 5, 5]}, "emission", (5, 5, 5), "emissiveFactor"),
        (
            {"emissiveFactor": [1, 1, 1], **extension("emissive_strength", emissiveStrength=-2)},
            "emission",
            (0, 0, 0),
            "Strength",
        ),
        (
            {"emissiveFactor": [1, 1, 1], **extension("emissive_strength", emissiveStrength=1e39)},
            "emission",
            (1e30,) * 3,
            "Strength",
        ),
        (
            {"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_emissive_strength": 4}},
            "emission",
            (1, 1, 1),
            "strength",
        ),
        ({"extensions": []}, "emission", (0, 0, 0), "extensions"),
        (extension("ior", ior=0.5), "ior", 1, "KHR_materials_ior.ior"),
        (extension("ior", ior=0), "ior", 1e6, ""),
        (extension("dispersion", dispersion=-1), "dispersion", 0, "KHR_materials_dispersion.dispersion"),
        (extension("volume", attenuationDistance=0), "attenuation_distance", inf, "attenuationDistance"),
        (extension("transmission", transmissionFactor=7), "transmission", 1, "transmissionFactor"),
        (extension("specular", specularFactor=-0.5), "specular", 0, "specularFactor"),
        (extension("sheen", sheenColorFactor=[2, 0.5, -1]), "sheen_color", (1, 0.5, 0), "sheenColorFactor[0]"),
        (extension("sheen", sheenRoughnessFactor="rough"), "sheen_roughness", 0, "sheenRoughnessFactor"),
        (extension("iridescence", iridescenceFactor=2), "iridescence", 1, "iridescenceFactor"),
        (extension("diffuse_transmission", diffuseTransmissionFactor=2), "diffuse_transmission", 1, "Factor"),
        (extension("anisotropy", anisotropyStrength=2), "anisotropy", 1, "anisotropyStrength"),
        (extension("anisotropy", anisotropyRotation="x"), "anisotropy_rotation", 0, "anisotropyRotation"),
        (extension("iridescence", iridescenceIor=0.5), "iridescence_ior", 1, "iridescenceIor"),
        (extension("iridescence", iridescenceThicknessMinimum=-1), "iridescence_least", 0, "ThicknessMinimum"),
        (extension("iridescence", iridescenceThicknessMaximum=[]), "iridescence_most", 400, "ThicknessMaximum"),
    ],
)
def test_what_is_odd_of_a_material_is_mended(
    gltf: GltfFile, material: dict, attribute: str, value: object, place: str
) -> None:
    assert getattr(material_of(gltf, **material), attribute) == value
    notes = [note for note in gltf.load().report.notes if note.startswith("materials[0]")]
    assert [note.split(": ")[0].endswith(place) for note in notes][:1] == [True] * bool(place)


@pytest.mark.parametrize(("factor", "roughness", "said"), [(0.9, 0.5, 1), (0.4, 0.0, 0), (0.9, 0.0, 0), (0.0, 0.5, 0)])
def test_glass_that_is_not_clear_is_said(gltf: GltfFile, factor: float, roughness: float, said: int) -> None:
    surface = metal(metallicFactor=0, roughnessFactor=roughness)
    material_of(gltf, name="glass", **surface, **extension("transmission", transmissionFactor=factor))
    notes = [note for note in gltf.load().report.notes if "lets light" in note]
    expected = "lets light through as frosted glass does (KHR_materials_transmission), all of which --method path shows"
    assert notes == [f"glass: {expected}"] * said


@pytest.mark.parametrize(("volume", "said"), [({"thicknessFactor": 1}, 1), ({}, 0)])
def test_paper_that_absorbs_is_said(gltf: GltfFile, volume: dict, said: int) -> None:
    through = {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5}}
    inside = {"attenuationColor": [1, 0.5, 0.5], "attenuationDistance": 1}
    material_of(gltf, name="wax", extensions=through | {"KHR_materials_volume": volume | inside})
    notes = [note for note in gltf.load().report.notes if "absorbs" in note]
    expected = "absorbs light that is scattered into it (KHR_materials_volume), which --method path alone shows"
    assert notes == [f"wax: {expected}"] * said


def test_specular_and_glossiness_are_converted_and_said(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf))
    gltf.json["extensionsRequired"] = ["KHR_materials_pbrSpecularGlossiness"]
    glossy = extension("pbrSpecularGlossiness", diffuseFactor=[0.5, 0.5, 0.5, 0.25], specularFactor=[0.04] * 3,
                       glossinessFactor=0.75, diffuseTexture={"index": 0})  # fmt: skip
    material = material_of(gltf, name="old", **metal(metallicFactor=1), **glossy)
    assert np.allclose(material.base_color, (0.5, 0.5, 0.5, 0.25))
    assert np.allclose((material.metallic, material.roughness), (0.0, 0.25))
    assert material.base_color_slot is not None
    report = gltf.load().report
    assert report.ignored == ()
    assert any(note.startswith("old: was converted from specular and glossiness") for note in report.notes)


@pytest.mark.parametrize("glossy", [{"diffuseFactor": "x", "glossinessFactor": 5}, {"specularGlossinessTexture": {}}])
def test_odd_specular_and_glossiness_is_mended(gltf: GltfFile, glossy: dict) -> None:
    material = material_of(gltf, **extension("pbrSpecularGlossiness", **glossy))
    assert (*material.base_color, material.metallic, material.roughness) == pytest.approx((1, 1, 1, 1, 1, 0))


@pytest.mark.parametrize("broken", [None, [], 5])
def test_a_material_that_is_none_is_plain(gltf: GltfFile, broken: object) -> None:
    gltf.json["materials"] = [broken]
    gltf.mesh_node(gltf.primitive(material=0))
    assert gltf.load().materials[0].base_color == (1, 1, 1, 1)


@pytest.mark.parametrize("info", [{"index": 0}, {"index": None}, {}, 3, {"index": 0, "texCoord": 99}])
def test_a_broken_texture_is_left_out(gltf: GltfFile, info: object) -> None:
    material = material_of(gltf, normalTexture=info, pbrMetallicRoughness={"baseColorTexture": info})
    assert (material.normal_slot, material.base_color_slot) == (None, None)
    (sentence,) = gltf.load().report.ignored
    assert sentence.startswith("materials[0].")
    assert "; the texture was left out (likewise materials[0]." in sentence


def test_many_odd_materials_are_told_in_one_sentence(gltf: GltfFile) -> None:
    gltf.json["materials"] = [metal(roughnessFactor=2 + number) for number in range(300)]
    gltf.mesh_node(gltf.primitive(material=0))
    notes = gltf.load().report.notes
    assert "roughnessFactor: must be between 0 and 1, not 2; 1 was used (likewise materials[1]" in notes[0]
    assert len("".join(notes)) < 1000


def test_every_texture_is_read_and_one_used_in_two_ways_becomes_two(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf))
    use = {"index": 0}
    gltf.add(
        "materials",
        pbrMetallicRoughness={"baseColorTexture": use, "metallicRoughnessTexture": use},
        normalTexture={**use, "scale": 0.5},
        emissiveTexture=use,
        emissiveFactor=[1, 1, 1],
        occlusionTexture=use,
        extensions={"KHR_materials_transmission": {"transmissionTexture": use}},
    )
    gltf.mesh_node(gltf.primitive(material=0, TEXCOORD_0=UV))
    scene = gltf.load()
    color, data = scene.textures
    assert (color.srgb, data.srgb) == (True, False)
    assert color.pixels is data.pixels
    assert color.pixels.tolist() == [[[255, 0, 0, 255]] * 2]
    (material,) = scene.materials
    slots = [material.base_color_slot, material.emission_slot, material.metallic_roughness_slot, material.normal_slot,
             material.transmission_slot]  # fmt: skip
    assert [scene.textures[slot.texture].srgb for slot in slots] == [True, True, False, False, False]
    assert material.normal_scale == 0.5
    assert scene.report.ignored == ("occlusion textures were ignored: the light itself is computed",)


def test_uv_sets_and_their_override(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf))
    change = {"KHR_texture_transform": {"texCoord": 2}}
    material = material_of(gltf, 3, pbrMetallicRoughness={"baseColorTexture": {"index": 0, "texCoord": 1}},
                           normalTexture={"index": 0, "texCoord": 1, "extensions": change})  # fmt: skip
    assert (material.base_color_slot.uv_set, material.normal_slot.uv_set) == (1, 2)
    assert np.array_equal(gltf.load().uvs, [UV] * 3)


def test_a_missing_uv_set_is_said(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf))
    material_of(gltf, 1, pbrMetallicRoughness={"baseColorTexture": {"index": 0, "texCoord": 1}})
    scene = gltf.load()
    assert "meshes[0].primitives[0]: has no TEXCOORD_1 for its textures; (0, 0) was used" in scene.report.notes
    assert not scene.uvs[1].any()


def test_a_texture_transform_as_in_the_extensions_example(gltf: GltfFile) -> None:
    """ "Only the lower left quadrant of the source image, rotated clockwise 90°": v points down."""
    gltf.add("textures", source=image(gltf))
    change = {"KHR_texture_transform": {"offset": [0, 1], "rotation": pi / 2, "scale": [0.5, 0.5]}}
    slot = material_of(gltf, pbrMetallicRoughness={"baseColorTexture": {"index": 0, "extensions": change}})
    matrix = np.array(slot.base_color_slot.transform).reshape(2, 3)
    corners = np.array([matrix @ [u, v, 1] for u, v in ((0, 0), (1, 0), (0, 1), (1, 1))])
    assert np.allclose(corners, [[0, 1], [0, 0.5], [0.5, 1], [0.5, 0.5]])


def test_textures_of_factors_that_are_not_supported_are_said(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf))
    use = {"index": 0}
    material_of(gltf, extensions={"KHR_materials_volume": {"thicknessTexture": use}})
    assert [sentence.split(" are")[0] for sentence in gltf.load().report.ignored] == ["textures of thickness"]


def test_all_layers_have_textures(gltf: GltfFile) -> None:
    gltf.add("textures", source=image(gltf))
    use, normal = {"index": 0}, {"index": 0, "scale": 0.5}
    coat = {"clearcoatTexture": use, "clearcoatRoughnessTexture": use, "clearcoatNormalTexture": normal}
    specular = {"specularTexture": use, "specularColorTexture": use}
    sheen = {"sheenColorTexture": use, "sheenRoughnessTexture": use}
    film = {"iridescenceTexture": use, "iridescenceThicknessTexture": use}
    grain = {"anisotropyTexture": use}
    through = {"diffuseTransmissionTexture": use, "diffuseTransmissionColorTexture": use}
    layers = {"specular": specular, "clearcoat": coat, "sheen": sheen, "iridescence": film, "anisotropy": grain}
    layers["diffuse_transmission"] = through
    material = material_of(gltf, extensions={f"KHR_materials_{name}": layer for name, layer in layers.items()})
    linear = material.clearcoat_slot
    assert linear == material.clearcoat_roughness_slot == material.clearcoat_normal_slot == material.specular_slot
    assert linear == material.anisotropy_slot == material.diffuse_transmission_slot
    assert linear == material.sheen_roughness_slot == material.iridescence_slot == material.iridescence_thickness_slot
    # Colours' textures are in sRGB, the others are linear: another texture of the same image.
    assert None is not linear != material.specular_color_slot == material.sheen_color_slot is not None
    assert material.diffuse_transmission_color_slot == material.sheen_color_slot
    assert material.clearcoat_normal_scale == 0.5
