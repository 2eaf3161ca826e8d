"""Where chains end behind mirrors and glass, in closed form, and what they leave of light."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, camera_of, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.device_scene.data import NO_HIT
from gpu.device_scene.features import EVERYTHING
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer, allocate_gbuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import LIKELIER, chain_samples
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Camera, Doubles, Material, Sky, Texture, TextureSlot

SIZE = (24, 16)
FLAGS = {"chains", "gloss", "traces_gloss", "grained", "translucent"}
COLOUR = (0.9, 0.6, 0.3)
MIRROR = Material(base_color=(*COLOUR, 1.0), metallic=1.0, roughness=0.0)
GLASS = Material(base_color=(*COLOUR, 1.0), transmission=1.0, roughness=0.0, thickness=1.0)
SLANTED = look_at((0.3, 0.2, 0.4), (-0.1, 0.0, -0.1), yfov_degrees=30.0)


def look(
    device_scene: DeviceScene,
    camera: Camera,
    moment: int = LIKELIER,
    *,
    lambertian: bool = False,
    lobes: bool = False,
    seed: int = 0,
    splits: bool = False,
) -> dict[str, Doubles]:
    """The G-buffer's arrays, each (pixel, …)."""
    pixels = SIZE[0] * SIZE[1]
    gbuffer = allocate(GBuffer, pixels, device_scene.device)
    scene, data = device_scene.view(lambertian=lambertian), camera_of(device_scene, camera, SIZE)
    gbuffer.chains, samples = True, chain_samples(device_scene.device, moment, seed)
    samples.lobes, samples.splits = lobes, splits
    trace_primary_rays(scene, data, SIZE, gbuffer, samples)
    return {name: getattr(gbuffer, name).numpy().astype(float) for name in GBuffer.vars if name not in FLAGS}


def slab(material: int = 0, half: float = 0.1) -> list[MeshPart]:
    """A plate in |z| < half, wider than what is looked at, closed but for its rim."""
    front = quad([-2, -2, half], [4, 0, 0], [0, 4, 0], material)
    return [front, quad([-2, -2, -half], [0, 4, 0], [4, 0, 0], material)]


def wall(z: float, material: int = 1) -> MeshPart:
    return quad([-4, -4, z], [8, 0, 0], [0, 8, 0], material)


def world(device_scene: DeviceScene, positions: Doubles) -> Doubles:
    placement = device_scene.scene.placement
    return np.asarray(positions / placement.scale + placement.centre)


def schlick(cosine: Doubles) -> Doubles:
    """What a metal of COLOUR reflects, (…, 3)."""
    rise = (1.0 - cosine[..., None]) ** 5
    return np.array(COLOUR) * (1.0 - rise) + rise


def face_fresnel(cosine: Doubles, ior: float = 1.5) -> Doubles:
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / ior**2)
    parallel, crossed = (ior * cosine - inner) / (ior * cosine + inner), (cosine - ior * inner) / (cosine + ior * inner)
    return np.asarray(0.5 * (parallel**2 + crossed**2))


def test_a_plane_mirror_shows_what_is_before_it() -> None:
    device_scene = resident_of([wall(-0.3, 0), wall(0.6, 1)], [MIRROR, grey(0.5)])
    seen, eye = look(device_scene, SLANTED), SLANTED.to_world[:3, 3]
    ends, apparent = world(device_scene, seen["position"]), world(device_scene, seen["apparent"])
    assert np.allclose(ends[:, 2], 0.6, atol=1e-5)
    assert np.allclose(seen["albedo"], 0.5)
    assert np.allclose(apparent, ends * [1, 1, -1] - [0, 0, 0.6], atol=1e-5)
    ways = apparent - eye
    lengths = np.linalg.norm(ways, axis=1)
    ways /= lengths[:, None]
    assert np.allclose(seen["to_camera"], -ways * [1, 1, -1], atol=1e-5)
    scale = device_scene.scene.placement.scale
    assert np.allclose(seen["spacing"], lengths * scale * 2.0 * SLANTED.half_height / SIZE[1], rtol=1e-4)
    assert np.allclose(seen["throughput"], schlick(-ways[:, 2]), atol=1e-4)


def test_lambertian_views_show_mirrors_and_glass_themselves() -> None:
    for material in (MIRROR, GLASS):
        device_scene = resident_of([*slab(), wall(-0.6)], [material, grey(0.5)])
        seen = look(device_scene, SLANTED, lambertian=True)
        assert np.allclose(seen["albedo"], COLOUR)
        assert np.allclose(seen["throughput"], 1.0)


@pytest.mark.parametrize("ior", [1.33, 2.0])
def test_a_body_of_glass_refracts_tints_and_absorbs(ior: float) -> None:
    """By the law of refraction a slab shifts rays beside themselves; it takes from light at both faces and between."""
    glass = replace(GLASS, ior=ior, attenuation_color=(0.5, 0.7, 0.9), attenuation_distance=0.25)
    device_scene = resident_of([*slab(), wall(-0.6)], [glass, grey(0.5)])
    seen, eye = look(device_scene, SLANTED), SLANTED.to_world[:3, 3]
    ends = world(device_scene, seen["position"])
    ways = ends - eye
    straight = look(resident_of([*slab(2), wall(-0.6)], [GLASS, grey(0.5), replace(grey(0.5))]), SLANTED)
    way = -straight["to_camera"]
    inside = way / ior
    inside[:, 2] = -np.sqrt(1.0 - inside[:, 0] ** 2 - inside[:, 1] ** 2)
    steps = (eye[2] + 0.6 - 0.2) / -way[:, 2], 0.2 / -inside[:, 2]
    assert np.allclose(ways, way * steps[0][:, None] + inside * steps[1][:, None], atol=1e-4)
    assert np.allclose(seen["to_camera"], -way, atol=1e-4)
    left = np.array([0.5, 0.7, 0.9]) ** (steps[1][:, None] / 0.25)
    assert np.allclose(seen["throughput"], np.array(COLOUR) ** 2 * left, rtol=1e-3)


def test_drawn_chains_go_on_in_one_colour_through_glass_that_disperses() -> None:
    """20 over an Abbe number of 25: the index of red is 2 % of what it is over 1 less than that of green."""
    glass = replace(GLASS, base_color=(1.0, 1.0, 1.0, 1.0), ior=2.0, dispersion=0.8)
    device_scene = resident_of([*slab(), wall(-0.6)], [glass, grey(0.5)])
    way = -look(resident_of([wall(-0.6, 0)], [grey(0.5)]), SLANTED)["to_camera"]
    found = [look(device_scene, SLANTED, moment) for moment in range(16)]
    drawn = np.array([each["throughput"] for each in found])
    assert drawn.mean(axis=(0, 1)) == pytest.approx(drawn.mean(), rel=0.05)
    mean = look(device_scene, SLANTED)
    assert np.ptp(mean["throughput"], axis=1).max() == 0.0
    for channel, ior in enumerate((1.98, 2.0, 2.02)):
        inside = way / ior
        inside[:, 2] = -np.sqrt(1.0 - inside[:, 0] ** 2 - inside[:, 1] ** 2)
        steps = (SLANTED.to_world[2, 3] + 0.6 - 0.2) / -way[:, 2], 0.2 / -inside[:, 2]
        expected = SLANTED.to_world[:3, 3] + way * steps[0][:, None] + inside * steps[1][:, None]
        for each in found:
            own = np.isclose(each["throughput"][:, channel], 3.0) & (each["to_camera"][:, 2] > 0.0)
            own &= np.isclose(world(device_scene, each["position"])[:, 2], -0.6, atol=1e-4)
            near = np.linalg.norm(world(device_scene, each["position"]) - expected, axis=1)[own]
            assert np.mean(near < 1e-4) > 0.9  # the others were reflected within


def test_drawn_chains_reflect_as_often_as_glass_does() -> None:
    """Each of its faces reflects for itself, and what stays inside leaves in the end."""
    glass = replace(GLASS, base_color=(1.0, 1.0, 1.0, 1.0))
    device_scene = resident_of([*slab(), wall(-0.6), wall(0.6, 2)], [glass, grey(0.2), grey(0.8)])
    found = [look(device_scene, SLANTED, moment)["albedo"][:, 0] for moment in range(64)]
    one = face_fresnel(look(device_scene, SLANTED, lambertian=True)["to_camera"][:, 2])
    assert np.mean(np.array(found) > 0.5) == pytest.approx(np.mean(2.0 * one / (1.0 + one)), rel=0.03)
    assert all((look(device_scene, SLANTED)["albedo"][:, 0] < 0.5).tolist())


def test_chains_of_other_seeds_are_drawn_otherwise() -> None:
    device_scene = resident_of([*slab(), wall(-0.6), wall(0.6, 2)], [GLASS, grey(0.2), grey(0.8)])
    drawn, other, again = (look(device_scene, SLANTED, 0, seed=seed)["albedo"] for seed in (0, 1, 0))
    assert drawn.tobytes() == again.tobytes() != other.tobytes()
    likelier = (look(device_scene, SLANTED, seed=seed)["albedo"].tobytes() for seed in (0, 1))
    assert len(set(likelier)) == 1


def test_panes_are_crossed_dimmed_or_met_by_chance() -> None:
    pane = replace(GLASS, thickness=0.0)
    device_scene = resident_of([wall(0.0, 0), wall(-0.6), wall(0.6, 2)], [pane, grey(0.2), grey(0.8)])
    seen = look(device_scene, SLANTED)
    one = face_fresnel(seen["to_camera"][:, 2])
    both = 2.0 * one / (1.0 + one)
    assert np.allclose(seen["albedo"], 0.2)
    assert np.allclose(seen["throughput"], np.array(COLOUR) * (1.0 - both)[:, None], rtol=1e-4)
    found = np.array([look(device_scene, SLANTED, moment)["albedo"][:, 0] for moment in range(64)])
    assert np.mean(found > 0.5) == pytest.approx(both.mean(), rel=0.05)


@pytest.mark.parametrize(("share", "glassy"), [(0.3, False), (0.7, True)])
def test_sheets_of_glass_in_part_are_seen_themselves_where_they_are_mostly_something_else(
    share: float, glassy: bool
) -> None:
    """Both are shown, each by its share, where samples split; else what is there by half or more, whole."""
    pane = replace(GLASS, thickness=0.0, transmission_slot=TextureSlot(0))
    texture = Texture("share", np.full((1, 1, 4), round(255 * share), np.uint8), srgb=False)
    device_scene = resident_of([wall(0.0, 0), wall(-0.6)], [pane, grey(0.2)], textures=[texture])
    for splits in (False, True):
        seen = look(device_scene, SLANTED, splits=splits)
        one = face_fresnel(seen["to_camera"][:, 2])
        glass, reflects = round(255 * share) / 255, 2.0 * one / (1.0 + one)
        passes = glass * (1.0 - reflects)
        matt = 1.0 - glass * reflects / (1.0 - passes)  # of what does not pass
        shown = passes if glassy else 1.0 - passes
        whole = 1.0 - reflects if glassy else 1.0
        shown = np.where(splits, shown, whole)[:, None] * (np.array(COLOUR) if glassy else 1.0)
        assert np.allclose(seen["throughput"], shown, rtol=1e-3)
        assert np.allclose(seen["diffuse"], 0.2 if glassy else matt[:, None] * COLOUR, atol=1e-4)


def test_chains_end_in_the_sky_and_in_lamps() -> None:
    for shown, parts in ((Sky((3.0, 3.0, 3.0)), []), (None, [quad([-2, -2, 0.6], [0, 4, 0], [4, 0, 0], 1)])):
        device_scene = resident_of([wall(-0.3, 0), *parts], [MIRROR, grey(0.0, 3.0)][: 1 + len(parts)], sky=shown)
        seen = look(device_scene, look_at((0.0, 0.0, 0.4), (0.0, 0.0, -0.1), yfov_degrees=20.0))
        assert (seen["face"] == int(NO_HIT)).all() == (shown is not None)
        up = 1.0 if shown is None else 0.5
        middle = seen["emitted"].reshape(*SIZE[::-1], 3)[7:9].mean(axis=(0, 1))
        assert np.allclose(middle, 3.0 * up * np.array(COLOUR), rtol=0.02)


def test_chains_between_two_mirrors_end_after_eight() -> None:
    device_scene = resident_of([wall(-0.3, 0), quad([-2, -2, 0.6], [0, 4, 0], [4, 0, 0], 0)], [MIRROR])
    camera = look_at((0.0, 0.0, 0.4), (0.0, 0.0, -0.3), yfov_degrees=5.0)
    seen, step = look(device_scene, camera), 2.0 * camera.half_height / SIZE[1]
    assert np.allclose(seen["spacing"], (0.7 + 8 * 0.9) * device_scene.scene.placement.scale * step, rtol=0.02)
    assert np.allclose(seen["throughput"], np.array(COLOUR) ** 8, rtol=0.05)


def test_what_lies_deep_in_glass_is_seen_straight_through_the_rest() -> None:
    parts = [part for place in range(6) for part in slab(half=0.1 * 0.8**place)]
    device_scene = resident_of([*parts, wall(-0.6)], [GLASS, grey(0.5)])
    seen = look(device_scene, look_at((0.0, 0.0, 0.4), (0.0, 0.0, -0.3), yfov_degrees=5.0))
    assert np.allclose(seen["albedo"], 0.5)
    assert (seen["throughput"] > 0.0).all()


@pytest.mark.parametrize(
    "material", [Material(base_color=(0.5, 0.4, 0.3, 1.0), roughness=0.3), replace(MIRROR, roughness=0.3)]
)
def test_drawn_chains_go_on_in_lobes_as_often_as_the_rest_counts_more(material: Material) -> None:
    """Those that stay bring the diffuse lobe's light and direct light, the others what the specular lobe reflects, and
    none of the wall's emission, which is direct light.
    """
    device_scene = resident_of([wall(-0.3, 0), wall(0.6, 1)], [material, grey(0.8, 2.0)])
    found = [look(device_scene, SLANTED, moment, lobes=True) for moment in range(64)]
    ends = np.array([world(device_scene, seen["position"])[:, 2] for seen in found])
    light = np.array([seen["throughput"] for seen in found])
    stays, goes = np.abs(ends + 0.3) < 1e-3, np.abs(ends - 0.6) < 1e-3
    assert (stays | goes).mean() > 0.98
    assert (light * stays[..., None]).mean(axis=(0, 1)) == pytest.approx(np.ones(3), rel=0.02)
    still = look(device_scene, SLANTED)
    assert np.allclose(still["throughput"], 1.0)
    metal = material.metallic == 1.0
    matt = found[0]["albedo"][stays[0]]
    assert np.allclose(matt, 0.0) if metal else np.allclose(matt, [0.5 * 0.94, 0.4 * 0.94, 0.3 * 0.94], atol=0.01)
    even = still["albedo"].mean(axis=0) - matt.mean(axis=0)
    assert (light * goes[..., None]).mean(axis=(0, 1)) == pytest.approx(even, abs=0.03 if metal else 0.01)
    assert not any(seen["emitted"].any() for seen in found)


def test_drawn_chains_go_on_by_coats_or_end_below() -> None:
    """Each by its share, but by coats more often, so that bright things in them leave no fireflies."""
    coated = replace(grey(0.5), clearcoat=1.0)
    device_scene = resident_of([wall(-0.3, 0), wall(0.6, 1)], [coated, grey(0.8)])
    found = [look(device_scene, SLANTED, moment, lobes=True) for moment in range(256)]
    light = np.array([seen["throughput"][:, 0] for seen in found])
    ends = np.array([seen["diffuse"][:, 0] for seen in found])
    coat = (0.04 + 0.96 * (1.0 - look(device_scene, SLANTED)["to_camera"][:, 2]) ** 5).mean()
    assert (light * (ends == 0.5)).mean() == pytest.approx(1.0 - coat, rel=0.01)
    by_coat = np.isclose(ends, 0.8)
    assert (light * by_coat).mean() == pytest.approx(coat, rel=0.05)
    assert by_coat.mean() == pytest.approx(np.sqrt(coat), rel=0.1)
    assert (by_coat | (ends == 0.5)).all()


def test_drawn_chains_go_through_frosted_glass() -> None:
    """What it scatters to both sides is what a sheet reflects and lets through, but for masking."""
    frosted = replace(GLASS, thickness=0.0, roughness=0.4)
    device_scene = resident_of([wall(0.0, 0), wall(-0.6), wall(0.6, 2)], [frosted, grey(0.2), grey(0.8)])
    assert np.allclose(look(device_scene, SLANTED)["throughput"], 1.0)
    found = [look(device_scene, SLANTED, moment, lobes=True) for moment in range(64)]
    ends = np.array([seen["albedo"][:, 0] for seen in found])
    light = np.array([seen["throughput"] for seen in found])
    assert (np.isclose(ends, 0.2) | np.isclose(ends, 0.8)).mean() > 0.9
    one = face_fresnel(look(device_scene, SLANTED, lambertian=True)["to_camera"][:, 2])
    reflects = np.mean(2.0 * one / (1.0 + one))
    assert (light * (ends > 0.5)[..., None]).mean() == pytest.approx(reflects, abs=0.03)
    through = (light * (ends < 0.5)[..., None]).mean(axis=(0, 1))
    assert through == pytest.approx(np.array(COLOUR) * (1.0 - reflects), rel=0.08)


def test_scenes_without_specular_surfaces_have_no_chains() -> None:
    device_scene = resident_of([*box(half=3.0)], [grey(0.5)])
    features = device_scene.features(lambertian=False)
    arrays = []
    for known in (EVERYTHING, features):
        gbuffer = allocate_gbuffer(SIZE[0] * SIZE[1], device_scene.device, known)
        camera = camera_of(device_scene, SLANTED, SIZE)
        trace_primary_rays(device_scene.data, camera, SIZE, gbuffer, chain_samples(device_scene.device), known)
        some = {*FLAGS, "apparent", "sheen", "grain", "through"}
        arrays.append({name: getattr(gbuffer, name) for name in GBuffer.vars if name not in some})
        assert gbuffer.chains == known.specular
        assert (gbuffer.apparent.ptr == gbuffer.position.ptr) == (not known.specular)
        assert gbuffer.sheen.size == (SIZE[0] * SIZE[1] if known.sheen else 1)
    for name, array in arrays[0].items():
        assert np.array_equal(array.numpy(), arrays[1][name].numpy()), name
