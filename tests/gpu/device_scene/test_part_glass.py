"""Sheets of clear glass, whole or in part: what passes, in closed form, how often rays cross, and what these meet."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import grey, quad, resident_of, results

from gpu.device_scene.data import HALF, NO_HIT, WHOLE, SceneData
from gpu.device_scene.even_light import even_reflectance, spread_reflectance
from gpu.device_scene.panes import crossed_tint, meet, met_surface, tint_between, transmittance
from gpu.device_scene.part_glass import met_at
from gpu.device_scene.rays import closest_hit, connected
from gpu.device_scene.upload import DeviceScene
from gpu.sampling.sobol import hashed
from gpu.scene.types import AlphaMode, Doubles, Material, Texture, TextureSlot

COUNT = 1 << 14
COLOUR = np.array([0.9, 0.6, 0.3])
STRAIGHT, SLANTED = np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.6, -0.8])
SHEET = quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])
WALL = quad([-2.0, -2.0, -1.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 1)
GLASS = Material(base_color=(*COLOUR, 1.0), transmission=0.4, roughness=0.0, specular=0.0)
HALF_TEXTURE = Texture("half", np.full((1, 1, 4), 128, np.uint8), srgb=False)
# Sheets, and how much of each is there and is glass.
SHEETS = {
    "factor": (GLASS, 1.0, 0.4),
    "whole": (replace(GLASS, transmission=1.0), 1.0, 1.0),
    "mostly": (replace(GLASS, transmission=0.8), 1.0, 0.8),
    "metal": (replace(GLASS, transmission=1.0, metallic=0.3), 1.0, 0.7),
    "texture": (replace(GLASS, transmission=1.0, transmission_slot=TextureSlot(0)), 1.0, 128 / 255),
    "blend": (replace(GLASS, base_color=(*COLOUR, 0.6), transmission=1.0, alpha_mode=AlphaMode.BLEND), 0.6, 1.0),
    "blend in part": (replace(GLASS, base_color=(*COLOUR, 0.6), alpha_mode=AlphaMode.BLEND), 0.6, 0.4),
    "mask": (replace(GLASS, base_color=(*COLOUR, 0.6), alpha_mode=AlphaMode.MASK), 1.0, 0.4),
    "opaque, whatever its alpha": (replace(GLASS, base_color=(*COLOUR, 0.2)), 1.0, 0.4),
}
ALL = pytest.mark.parametrize(("material", "there", "glass"), SHEETS.values(), ids=SHEETS)


def reflected(cosine: float, ior: float = 1.5) -> float:
    """What a sheet of glass reflects, of both polarisations."""
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / ior**2)
    face = 0.5 * (((ior * cosine - inner) / (ior * cosine + inner)) ** 2
                  + ((cosine - ior * inner) / (cosine + ior * inner)) ** 2)  # fmt: skip
    return float(2.0 * face / (1.0 + face))


def window(material: Material) -> DeviceScene:
    """A sheet in the plane z = 0 before a wall at z = −1."""
    return resident_of([SHEET, WALL], [material, grey(0.5)], textures=[HALF_TEXTURE])


def along(device_scene: DeviceScene, direction: Doubles, way: float) -> wp.vec3:
    """The point that light along `direction` comes to `way` behind the sheet, in unit space."""
    placement = device_scene.scene.placement
    return wp.vec3(*((direction * way - placement.centre) * placement.scale))


@wp.kernel
def between_kernel(first: int, scene: SceneData, p: wp.vec3, q: wp.vec3, out: wp.array[wp.vec4]) -> None:
    """What passes from one point to another, and whether a ray of its own sees one from the other."""
    index = first + wp.tid()
    none = wp.vec3(0.0, 0.0, 0.0)
    scene.coverage = hashed(wp.uint32(index)) | wp.uint32(1)
    left = transmittance(scene, p, none, q, none)
    out[index] = wp.vec4(left[0], left[1], left[2], float(int(connected(scene, p, none, q, none))))


@ALL
@pytest.mark.parametrize("direction", [STRAIGHT, SLANTED])
def test_a_share_of_light_passes_tinted(material: Material, there: float, glass: float, direction: Doubles) -> None:
    device_scene = window(material)
    ends = [along(device_scene, direction, way) for way in (-0.5, 0.9)]
    expected = (1.0 - there) + there * glass * (1.0 - reflected(-direction[2])) * COLOUR
    for pair in (ends, ends[::-1]):
        found = results(between_kernel, COUNT, [device_scene.data, *pair], wp.vec4)
        assert np.allclose(found[:, :3], expected, rtol=1e-3)
        assert found[:, 3].mean() == pytest.approx(expected.mean(), abs=0.012)
    lambertian = device_scene.view(lambertian=True)
    assert not results(between_kernel, 4, [lambertian, *ends], wp.vec4).any()


@wp.kernel
def tint_kernel(first: int, scene: SceneData, p: wp.vec3, q: wp.vec3, out: wp.array[wp.vec3]) -> None:
    none = wp.vec3(0.0, 0.0, 0.0)
    out[first + wp.tid()] = tint_between(scene, p, none, q, none)


@ALL
def test_rays_that_arrive_have_the_colour_of_what_passes(material: Material, there: float, glass: float) -> None:
    device_scene = window(material)
    ends = [along(device_scene, SLANTED, way) for way in (-0.5, 0.9)]
    passes = (1.0 - there) + there * glass * (1.0 - reflected(0.8)) * COLOUR
    found = results(tint_kernel, 1, [device_scene.data, *ends], wp.vec3)[0]
    assert np.allclose(found, passes / passes.mean(), rtol=1e-3)
    assert np.allclose(results(tint_kernel, 1, [device_scene.data, ends[1], ends[1]], wp.vec3), 1.0)


@wp.kernel
def meet_kernel(first: int, scene: SceneData, origin: wp.vec3, direction: wp.vec3, rule: wp.uint32,
                out: wp.array[wp.vec4]) -> None:  # fmt: skip
    """(triangle, green of the tint, share of glass, what is reflected of even light where a ray ends) of a ray, by a
    rule of SceneData.coverage, or at random. Without panes a ray meets the same.
    """
    index = first + wp.tid()
    scene.coverage = rule
    if rule == wp.uint32(1):
        scene.coverage = hashed(wp.uint32(index)) | wp.uint32(1)
    met = meet(scene, origin, direction, False)
    hit = closest_hit(scene, origin, direction, 10.0)
    if hit.face != met.hit.face or hit.face == NO_HIT:
        out[index] = wp.vec4(-1.0, 0.0, 0.0, 0.0)
        return
    surface = met_surface(scene, hit, direction)
    even = even_reflectance(met_at(scene, hit, direction), -direction)
    tint = crossed_tint(scene, origin, direction, hit.t, False)
    if wp.length(tint - met.tint) > 1.0e-6:
        tint = -tint
    out[index] = wp.vec4(float(hit.face), tint[1], surface.glass, even[1])


@ALL
@pytest.mark.parametrize("direction", [STRAIGHT, SLANTED])
def test_rays_cross_as_often_as_light_and_meet_the_rest(material: Material, there: float, glass: float,
                                                        direction: Doubles) -> None:  # fmt: skip
    device_scene = window(material)
    sheet = {face for face, number in enumerate(device_scene.data.triangle_material.numpy()) if number == 0}
    origin, mirrored = along(device_scene, direction, -0.5), glass * reflected(-direction[2])
    crossing = 1.0 - there * (1.0 - glass + mirrored)
    inputs = [device_scene.data, origin, wp.vec3(*direction)]
    face, tint, share, even = results(meet_kernel, COUNT, [*inputs, wp.uint32(1)], wp.vec4).T
    met = np.isin(face, list(sheet))
    assert (face >= 0.0).all()
    assert met.mean() == pytest.approx(1.0 - crossing, abs=0.012)
    assert np.allclose(tint[met], 1.0)
    passes = (1.0 - there) + there * (glass - mirrored) * COLOUR[1]
    assert np.allclose(tint[~met], passes / crossing, rtol=1e-3)
    # What is met is no glass or a mirror, which rays that end there take for matt.
    assert np.allclose(share[met], there * mirrored / (1.0 - crossing), atol=1e-3)
    if material.metallic == 0.0:
        sent = there * (mirrored + (1.0 - glass) * COLOUR[1]) / (1.0 - crossing)
        assert np.allclose(even[met], sent, rtol=1e-3)
    for rule, least in ((HALF, 0.5), (WHOLE, 1.0 / 256.0)):
        face = results(meet_kernel, 1, [*inputs, wp.uint32(int(rule))], wp.vec4)[0, 0]
        assert (face in sheet) == (1.0 - crossing >= least)


@wp.kernel
def spread_kernel(first: int, scene: SceneData, origin: wp.vec3, direction: wp.vec3, out: wp.array[wp.vec3]) -> None:
    """What a sheet sends of light from emitters besides caustics, of that of matt surfaces, and its mirror's share."""
    scene.coverage = WHOLE
    surface = met_at(scene, closest_hit(scene, origin, direction, 10.0), direction)
    sent = spread_reflectance(surface, -direction, 1.0)[0]
    out[first + wp.tid()] = wp.vec3(sent, spread_reflectance(surface, -direction, 0.0)[0], surface.glass)


def test_what_caustics_bring_is_mirrored_but_not_sent_by_vpls() -> None:
    device_scene = window(replace(GLASS, transmission=0.8))
    inputs = [device_scene.data, along(device_scene, STRAIGHT, -0.5), wp.vec3(*STRAIGHT)]
    spread, even, mirror = results(spread_kernel, 1, inputs, wp.vec3)[0]
    assert mirror > 0.2
    assert spread == pytest.approx(COLOUR[0] * (1.0 - mirror), rel=1e-4)
    assert even == pytest.approx(spread + mirror, rel=1e-4)


@pytest.mark.parametrize(
    ("change", "in_part"),
    [
        ({}, True),
        ({"transmission": 1.0}, True),
        ({"transmission": 0.0}, False),
        ({"transmission": 1.0, "metallic": 1.0}, False),
        ({"roughness": 0.2}, False),
        ({"thickness": 0.1}, False),
        ({"unlit": True}, False),
        ({"backdrop": True}, False),
    ],
)
def test_sheets_of_clear_glass_are_there_in_part(change: dict[str, object], in_part: bool) -> None:
    material = replace(GLASS, **change)
    device_scene = window(material)
    assert material.is_part_glass == in_part
    assert (device_scene.data.masked_count, device_scene.data.part_glass) == (2 * in_part, in_part)
    features = device_scene.features(lambertian=False)
    assert (features.part_glass, features.masks, features.blend, features.sheer) == (in_part,) * 4
    if in_part:
        assert (features.specular, features.frosted, features.panes) == (True, material.transmission < 1.0, False)
    assert not device_scene.features(lambertian=True).part_glass
