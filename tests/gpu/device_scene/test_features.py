from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, scene_of

from gpu.device_scene.features import EVERYTHING, SceneFeatures, features_of_any, scene_features
from gpu.scene.types import AlphaMode, Environment, Light, LightKind, Material, Sky, Texture, TextureSlot


def test_what_a_scene_has_and_what_is_assumed_of_it() -> None:
    mask = Texture("mask", np.full((1, 1, 4), 254, np.uint8), srgb=True)
    materials = [
        Material(alpha_mode=AlphaMode.MASK, base_color_slot=TextureSlot(0), roughness=0.1),
        Material(emission=(3.0, 2.0, 1.0), double_sided=False),
        Material(unlit=True, backdrop=True),
        Material(transmission=1.0, roughness=0.0, thickness=1.0, dispersion=0.5),
        Material(transmission=0.5, roughness=0.0),
        Material(transmission=1.0, roughness=0.3),
        Material(clearcoat=0.5),
        Material(sheen_color=(0.0, 0.5, 0.0)),
        Material(iridescence=0.5),
        Material(anisotropy=0.5),
        Material(diffuse_transmission=0.5),
        Material(alpha_mode=AlphaMode.BLEND, base_color=(1.0, 1.0, 1.0, 0.3)),
    ]
    bulb = Light("bulb", LightKind.POINT, (0.2, 0.3, 0.1), position=(0.3, 0.2, 0.2))
    lamp = quad((-0.2, 0.45, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    scene = scene_of([*box(), lamp], materials, [bulb], Sky((0.3, 0.4, 0.5)), [mask])
    assert scene_features(scene, lambertian=False) == replace(EVERYTHING, environment=False)
    hidden = ("environment", "alpha", "cutouts", "blend", "sheer", "glass", "panes", "one_sided", "gloss", "specular",
              "frosted", "coats", "focus", "sheen", "films", "grain", "translucent", "dispersion",
              "part_glass")  # fmt: skip
    assert scene_features(scene, lambertian=True) == replace(EVERYTHING, **dict.fromkeys(hidden, False))
    around = replace(scene, sky=Environment("sky", np.ones((1, 2, 3), np.float32)))
    assert scene_features(around, lambertian=True).environment
    bare = replace(scene_of(box(), [grey(0.5)]), sky=None)
    nothing = SceneFeatures(**dict.fromkeys(vars(EVERYTHING), False) | {"constants": True})
    assert scene_features(bare, lambertian=False) == nothing
    for name, more in (("alpha", ("masks", "cutouts")), ("textures", ()), ("gloss", ())):
        assumed = replace(nothing, **dict.fromkeys((name, *more), True))
        assert scene_features(bare, lambertian=False, **{f"assume_{name}": True}) == assumed
    for many in (False, True):
        lit = scene_of(box(), [grey(0.5)], [bulb] * (8 + many))
        assert scene_features(lit, lambertian=False) == replace(nothing, soft=many, lamps=many)


@pytest.mark.parametrize(
    ("lamps", "sky", "several"), [(1, False, False), (0, True, False), (1, True, True), (2, False, True)]
)
def test_lights_are_several_where_there_is_a_choice(lamps: int, sky: bool, several: bool) -> None:
    lamp = quad((-0.2, 0.45, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    scene = scene_of([*box(), *[lamp] * lamps], [grey(0.5), grey(0.0, 5.0)], sky=Sky((0.3, 0.4, 0.5)) if sky else None)
    assert scene_features(scene, lambertian=False).lamps == several


@pytest.mark.parametrize("change", [{"specular": 0.0}, {"roughness": 0.5}, {"unlit": True}])
def test_only_narrow_specular_lobes_are_gloss(change: dict[str, float]) -> None:
    glossy = Material(roughness=0.49)
    assert scene_features(scene_of(box(), [glossy]), lambertian=False).gloss
    assert not scene_features(scene_of(box(), [replace(glossy, **change)]), lambertian=False).gloss


def test_coats_are_gloss_over_anything() -> None:
    coated = scene_features(scene_of(box(), [replace(grey(0.5), clearcoat=0.1)]), lambertian=False)
    assert coated.coats
    assert coated.gloss


@pytest.mark.parametrize("change", [{"roughness": 0.2}, {"metallic": 0.4}, {"unlit": True}, {"thickness": 0.0}])
def test_only_bodies_of_clear_glass_are_panes(change: dict[str, float]) -> None:
    body = Material(transmission=0.6, roughness=0.1, thickness=1.0)
    for material, is_pane in ((body, True), (replace(body, **change), False)):
        features = scene_features(scene_of(box(), [material]), lambertian=False)
        assert (features.glass, features.panes) == (True, is_pane)


@pytest.mark.parametrize(
    ("material", "specular"),
    [
        (Material(metallic=1.0, roughness=0.02), True),
        (Material(metallic=1.0, roughness=0.04), False),
        (Material(metallic=0.9, roughness=0.02), False),
        (Material(metallic=1.0, metallic_roughness_slot=TextureSlot(0)), True),
        (Material(metallic=1.0, roughness=0.02, unlit=True), False),
        (Material(transmission=0.1, roughness=0.1), True),
        (Material(transmission=1.0, roughness=0.2), False),
        (Material(transmission=1.0, metallic_roughness_slot=TextureSlot(0)), True),
    ],
)
def test_mirrors_and_clear_glass_are_specular(material: Material, specular: bool) -> None:
    texture = Texture("smooth", np.zeros((1, 1, 4), np.uint8), srgb=False)
    scene = scene_of(box(), [material], textures=[texture])
    assert scene_features(scene, lambertian=False).specular == specular
    assert not scene_features(scene, lambertian=True).specular


@pytest.mark.parametrize(
    ("material", "casts"),
    [
        (Material(metallic=1.0, roughness=0.2), True),
        (Material(metallic=1.0, roughness=0.5), False),
        (Material(metallic=1.0, roughness=0.02), False),
        (Material(metallic=0.05, roughness=0.2), False),
        (Material(roughness=0.2, ior=1.8), False),
        (Material(roughness=0.2, ior=2.4), True),
        (Material(roughness=0.2, iridescence=0.5), True),
        (Material(metallic=1.0, metallic_roughness_slot=TextureSlot(0)), True),
        (Material(metallic=1.0, roughness=0.2, unlit=True), False),
        (Material(transmission=1.0, roughness=0.05), False),
        (Material(transmission=1.0, roughness=0.3), True),
    ],
)
def test_lobes_of_metal_and_frosted_glass_cast_caustics_and_those_of_paint_do_not(
    material: Material, casts: bool
) -> None:
    texture = Texture("smooth", np.zeros((1, 1, 4), np.uint8), srgb=False)
    scene = scene_of(box(), [material], textures=[texture])
    assert scene_features(scene, lambertian=False).focus == casts


@pytest.mark.parametrize(
    ("glass", "frosted"),
    [
        (Material(transmission=1.0, roughness=0.05), False),
        (Material(transmission=1.0, roughness=0.3), True),
        (Material(transmission=0.3, roughness=0.0), True),
        (Material(transmission=1.0, roughness=0.0, transmission_slot=TextureSlot(0)), True),
        (Material(roughness=0.0), False),
    ],
)
def test_glass_that_light_does_not_cross_straight_is_frosted(glass: Material, frosted: bool) -> None:
    texture = Texture("share", np.zeros((1, 1, 4), np.uint8), srgb=False)
    scene = scene_of(box(), [replace(glass, specular=0.0)], textures=[texture])
    features = scene_features(scene, lambertian=False)
    assert features.frosted == features.lobes == frosted


def test_general_kernels_know_what_lights_there_are_and_leave_out_what_is_rare() -> None:
    dark = scene_features(scene_of(box(), [grey(0.5)]), lambertian=False)
    rare = dict.fromkeys(("frosted", "coats", "sheen", "films", "grain", "translucent", "dispersion"), False)
    assert features_of_any(dark) == replace(EVERYTHING, soft=False, lamps=False, **rare)
    assert features_of_any(EVERYTHING) == EVERYTHING


@pytest.mark.parametrize(
    ("alpha", "texel", "vertex", "sheer", "cutouts"),
    [
        (0.7, 255, None, False, False),
        (0.3, 255, None, True, False),
        (0.7, 170, None, True, True),
        (0.9, 170, None, False, True),
        (0.7, 255, 0.5, True, True),
        (0.7, 255, 1.0, False, False),
    ],
)
def test_how_much_may_be_there_of_a_surface_is_by_factor_texture_and_vertices(
    alpha: float, texel: int, vertex: float | None, sheer: bool, cutouts: bool
) -> None:
    veil = Material(base_color=(1.0, 1.0, 1.0, alpha), base_color_slot=TextureSlot(0), alpha_mode=AlphaMode.BLEND)
    pixels = np.full((1, 2, 4), 255, np.uint8)
    pixels[0, 1, 3] = texel
    scene = scene_of(box(), [veil], textures=[Texture("veil", pixels, srgb=True)])
    colors = None if vertex is None else np.full((len(scene.vertices), 4), vertex, np.float32)
    found = scene_features(replace(scene, colors=colors), lambertian=False)
    assert (found.sheer, found.cutouts) == (sheer, cutouts)
    masked = replace(scene, colors=colors, materials=[replace(veil, alpha_mode=AlphaMode.MASK)])
    assert not scene_features(masked, lambertian=False).sheer
    whole = replace(scene, materials=[replace(veil, alpha_mode=AlphaMode.OPAQUE)])
    assert not scene_features(whole, lambertian=False).cutouts
