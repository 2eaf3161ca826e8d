from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, resident_of, trace_light_paths

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.light_paths import Vpls
from gpu.scene.types import Light, LightKind, Material

PATHS = 8192
BULB = Light("bulb", LightKind.POINT, (1.0, 2.0, 4.0), position=(0.1, 0.0, -0.2))


def paths_in(
    device_scene: DeviceScene, bounces: int, seed: int = 0, paths: int = PATHS, *, arriving: bool = False
) -> Vpls:
    table = build_light_table(device_scene)
    return trace_light_paths(device_scene, device_scene.data, table, paths, bounces, seed, arriving=arriving)


@pytest.mark.parametrize("bounces", [1, 2, 4])
def test_the_flux_in_a_closed_box_is_a_geometric_series(bounces: int) -> None:
    albedo = np.array([0.3, 0.6, 0.9])
    walls = Material(base_color=(*albedo, 1.0), emission=(1.0, 1.0, 1.0), specular=0.0)
    vpls = paths_in(resident_of(box(), [walls]), bounces)
    emitted = np.pi * 6.0
    expected = emitted * np.sum([albedo**k for k in range(1, bounces + 1)], axis=0)
    assert np.allclose(vpls.flux.numpy().sum(axis=0, dtype=np.float64), expected, rtol=0.02)


def test_vpls_know_how_many_surfaces_their_light_met_before() -> None:
    """Roulette keeps half of the light at each, so half as many VPLs are of each later bounce."""
    vpls = paths_in(resident_of(box(), [grey(0.5)], lights=[BULB]), 3)
    numbers = np.bincount(vpls.bounce.numpy())
    assert numbers[0] == PATHS
    assert numbers / PATHS == pytest.approx([1.0, 0.5, 0.25], rel=0.05)


def test_a_lamp_in_a_box_gives_the_same_series() -> None:
    vpls = paths_in(resident_of(box(), [grey(0.5)], lights=[BULB]), 4)
    expected = 4.0 * np.pi * np.array(BULB.intensity) * (0.5 + 0.25 + 0.125 + 0.0625)
    assert np.allclose(vpls.flux.numpy().sum(axis=0, dtype=np.float64), expected, rtol=0.02)


def test_a_spot_in_the_plane_of_a_ceiling_shines_into_the_room() -> None:
    down = Light("down", LightKind.SPOT, (1.0, 1.0, 1.0), (0.1, 0.47, -0.2), (0.0, -1.0, 0.0), 0.9, 0.9)
    vpls = paths_in(resident_of(box(half=0.47), [grey(0.5)], lights=[down]), 1)
    assert len(vpls.flux) == PATHS
    assert (vpls.position.numpy()[:, 1] < 0.0).all()


def test_vpls_lie_on_surfaces_and_face_the_side_that_was_lit() -> None:
    device_scene = resident_of(box(), [grey(0.8)], lights=[BULB])
    vpls = paths_in(device_scene, 4)
    position, normal = vpls.position.numpy(), vpls.normal.numpy()
    assert np.allclose(np.abs(position).max(axis=1), 0.5, atol=1e-5)
    assert np.allclose(np.sum(position * normal, axis=1), -0.5, atol=1e-5)


def test_a_sheet_is_lit_on_the_side_of_the_light() -> None:
    sheet = quad([-0.5, 0.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])  # its front looks down
    above = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    vpls = paths_in(resident_of([sheet], [grey(0.5)], lights=[above]), 2)
    assert np.allclose(vpls.normal.numpy(), [0, 1, 0], atol=1e-6)
    assert np.allclose(vpls.flux.numpy().sum(axis=0), 0.5, rtol=0.03)


@pytest.mark.parametrize("thickness", [0.0, 1.0])
def test_frosted_glass_sends_what_it_reflects_and_what_it_lets_through(thickness: float) -> None:
    sheet = quad([-0.5, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    above = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    glass = Material(base_color=(1.0, 1.0, 0.5, 1.0), transmission=1.0, roughness=0.5, thickness=thickness)
    vpls = paths_in(resident_of([sheet], [glass], lights=[above]), 2)
    up, flux = vpls.normal.numpy()[:, 1] > 0.0, vpls.flux.numpy()
    assert flux[up].sum(axis=0) == pytest.approx([0.08, 0.08, 0.08], abs=0.02)
    assert flux[~up].sum(axis=0) == pytest.approx([0.85, 0.85, 0.425], rel=0.05)


@pytest.mark.parametrize(("roughness", "spread"), [(0.2, 0.0), (0.45, 0.5), (0.5, 1.0)])
def test_vpls_on_metal_send_what_caustics_have_not(roughness: float, spread: float) -> None:
    sheet = quad([-0.5, -0.5, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    askew = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.8, -0.6, 0.0))
    metal = Material(metallic=1.0, roughness=roughness)
    vpls = paths_in(resident_of([sheet], [metal], lights=[askew]), 2)
    assert vpls.flux.numpy()[:, 0].sum() == pytest.approx(0.53 * spread, rel=0.05, abs=1e-6)


def test_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    device_scene = resident_of(box(), [grey(0.7)], lights=[BULB])
    first, again, other = (paths_in(device_scene, 3, seed) for seed in (5, 5, 6))
    for name in ("position", "normal", "flux"):
        assert np.array_equal(getattr(first, name).numpy(), getattr(again, name).numpy())
    assert not np.array_equal(first.position.numpy()[:100], other.position.numpy()[:100])


def test_light_goes_on_where_lobes_send_it() -> None:
    """From a plate of metal to the wall that it mirrors the sun to, not to the one behind."""
    plate = quad([-0.3, -0.5, 0.3], [0.6, 0.0, 0.0], [0.0, 0.0, -0.6])
    walls = [quad([side * 0.5, -0.5, -0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 1) for side in (-1.0, 1.0)]
    askew = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.6, -0.8, 0.0))
    metal = Material(metallic=1.0, roughness=0.2)
    vpls = paths_in(resident_of([plate, *walls], [metal, grey(0.01)], lights=[askew]), 2)
    far = (vpls.bounce.numpy() == 1) & (np.abs(vpls.position.numpy()[:, 0]) > 0.49)
    flux, right = vpls.flux.numpy()[far, 0], vpls.position.numpy()[far, 0] > 0.0
    assert flux[right].sum() > 0.9 * flux.sum() > 0.0


@pytest.mark.parametrize("roughness", [0.2, 0.5, 0.9])
def test_lobes_keep_as_much_light_on_its_way_as_surfaces_reflect(roughness: float) -> None:
    walls = Material(base_color=(0.8, 0.5, 0.2, 1.0), roughness=roughness)
    vpls = paths_in(resident_of(box(), [walls], lights=[BULB]), 4, paths=4 * PATHS)
    flux, bounce = vpls.flux.numpy().astype(np.float64), vpls.bounce.numpy()
    sent = [flux[bounce == number].sum(axis=0) for number in range(4)]
    # The first light arrives from the bulb, mostly head-on, where lobes reflect least.
    assert sent[3] / sent[2] == pytest.approx(sent[2] / sent[1], rel=0.04)
    assert sent[1] / sent[0] == pytest.approx(sent[2] / sent[1], rel=0.08)


@pytest.mark.parametrize("specular", [0.0, 1.0])
def test_light_goes_on_from_either_side_of_paper(specular: float) -> None:
    """A sun on a sheet between a ceiling and a floor, both black: VPLs of the sheet carry what it sends to each."""
    down = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    color = (1.0, 0.5, 0.25)
    paper = replace(grey(0.8), specular=specular, diffuse_transmission=0.25, diffuse_transmission_color=color)
    sheet = quad([-0.5, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    device_scene = resident_of([sheet], [paper], lights=[down])
    vpls = paths_in(device_scene, 1, paths=4 * PATHS)
    flux, up = vpls.flux.numpy().astype(np.float64), vpls.normal.numpy()[:, 1] > 0.0
    matt = 1.0 - 0.04 * specular
    assert flux[~up].sum(axis=0) == pytest.approx(0.25 * matt * np.array(color), rel=0.02)
    assert flux[up].sum(axis=0) == pytest.approx(0.6 * matt + 0.01 * specular, rel=0.02)
    largest = flux.max(axis=1)
    assert largest.min() == pytest.approx(largest.max(), rel=1e-3)


def test_light_that_paper_lets_through_lights_a_floor() -> None:
    down = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    paper = replace(grey(0.8), specular=0.0, diffuse_transmission=0.5)
    above, below = (quad([-0.5, y, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], n) for n, y in enumerate((0.0, -0.002)))
    vpls = paths_in(resident_of([above, below], [paper, grey(0.5)], lights=[down]), 2, paths=4 * PATHS)
    on_floor = vpls.position.numpy()[:, 1] < 0.0
    assert vpls.flux.numpy()[on_floor, 0].sum() == pytest.approx(0.25, rel=0.03)


GLASS = Material(base_color=(0.9, 0.6, 0.3, 1.0), transmission=0.4, roughness=0.0, specular=0.0)


@pytest.mark.parametrize("arriving", [False, True])
def test_part_glass_sends_what_is_no_glass_and_lets_the_rest_light_a_floor(arriving: bool) -> None:
    sheet = quad([-0.5, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    floor = quad([-0.5, -0.3, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], 1)
    above = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    device_scene = resident_of([sheet, floor], [GLASS, grey(0.5)], lights=[above])
    vpls = paths_in(device_scene, 1, arriving=arriving)
    on_sheet, flux = vpls.position.numpy()[:, 1] > 0.0, vpls.flux.numpy()
    colour, mirror = np.array([0.9, 0.6, 0.3]), 0.08 / 1.04
    crosses = 0.4 * (1.0 - mirror)
    # Photons tell what would light all that is met as much, mirrors among it.
    reflects = (0.4 * mirror + 0.6 * colour) / (1.0 - crosses) if arriving else 1.0
    assert flux[on_sheet].sum(axis=0) == pytest.approx(0.6 * colour / reflects, rel=0.03)
    assert flux[~on_sheet].sum(axis=0) == pytest.approx(crosses * colour * (1.0 if arriving else 0.5), rel=0.03)


def test_light_of_matt_surfaces_crosses_part_glass_or_is_mirrored() -> None:
    """In a box of such sheets, whose sides send back at each bounce what does not leave it."""
    white = replace(GLASS, base_color=(1.0, 1.0, 1.0, 1.0))
    device_scene = resident_of(box(), [white], lights=[BULB])
    vpls = paths_in(device_scene, 4)
    by_bounce = [vpls.flux.numpy()[vpls.bounce.numpy() == bounce, 0].sum() for bounce in range(4)]
    left = np.array(by_bounce[2:]) / by_bounce[1:3]
    assert left == pytest.approx([0.6 + 0.4 * 0.17] * 2, abs=0.03)
