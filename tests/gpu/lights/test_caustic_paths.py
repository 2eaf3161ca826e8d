import numpy as np
import pytest
from glass import GLASS, MIRROR, bulb, caustics_of, cube, mirror_over_floor, photons_in
from scenes import grey, quad, rectangle_over, resident_of

from gpu.scene.types import Light, LightKind

PATHS = 4096
LAMP = bulb(0.0, -0.3, 0.0)


def solid_angle(half: float, height: float) -> float:
    """Of a square seen from under its middle [sr]."""
    return float(4.0 * np.arcsin(half**2 / (half**2 + height**2)))


def test_a_mirror_sends_on_what_it_gets_as_if_from_behind_it() -> None:
    positions, normals, flux = photons_in(caustics_of(mirror_over_floor(LAMP), PATHS))
    assert len(positions) == PATHS
    assert flux[:, 0].sum() == pytest.approx(solid_angle(0.1, 0.3), rel=0.01)
    # From the lamp's image, 0.3 above the mirror, its edge throws a square of 0.1 · 0.8 / 0.3 onto the floor.
    assert np.allclose(positions[:, 1], -0.5, atol=1e-4)
    assert np.allclose(normals, [0.0, 1.0, 0.0], atol=1e-4)
    assert np.abs(positions[:, [0, 2]]).max() == pytest.approx(0.1 * 0.8 / 0.3, rel=0.01)


@pytest.mark.parametrize(("roughness", "share"), [(0.1, 1.0), (0.3, 1.0), (0.45, 0.495), (0.48, 0.196), (0.5, 0.0)])
def test_metal_sends_less_by_caustics_the_rougher_it_is(roughness: float, share: float) -> None:
    """Up to a roughness of 0.4 all that it reflects, from 0.5 on nothing."""
    positions, _, flux = photons_in(caustics_of(mirror_over_floor(LAMP, roughness=roughness), PATHS))
    assert flux[:, 0].sum() == pytest.approx(solid_angle(0.1, 0.3) * share, rel=0.03)
    if roughness == 0.1:  # the floor that a mirror lights
        below = (positions[:, 1] < -0.499) & (np.abs(positions[:, [0, 2]]).max(axis=1) < 0.1 * 0.8 / 0.3)
        assert 0.9 < below.mean() < 0.99


def test_light_of_a_lobe_ends_at_the_next_surface_which_is_matt_to_light_paths() -> None:
    plate = quad([-0.1, -0.45, -0.1], [0.0, 0.0, 0.2], [0.2, 0.0, 0.0], 0)
    for roughness, some in ((0.1, True), (0.0, False)):  # mirrors send all of it on
        scene = mirror_over_floor(bulb(0.0, -0.15, 0.0), parts=[plate], roughness=roughness)
        positions = photons_in(caustics_of(scene, PATHS))[0]
        assert bool((np.abs(positions[:, 1] + 0.45) < 1e-4).mean() > 0.05) == some


def test_photons_bring_about_as_much_each() -> None:
    flux = photons_in(caustics_of(mirror_over_floor(LAMP), PATHS))[2][:, 0]
    assert flux.std() < 0.3 * flux.mean()


def test_fifty_lamps_do_not_starve_a_mirror() -> None:
    """All but one are brighter, and light the mirror from where nothing is sent on to."""
    far = [bulb(0.45 * np.cos(k), -0.02, 0.45 * np.sin(k), intensity=2.0) for k in range(49)]
    positions, _, flux = photons_in(caustics_of(mirror_over_floor(LAMP, *far), PATHS))
    from_lamp = (np.abs(positions[:, [0, 2]]).max(axis=1) < 0.27) & (positions[:, 1] < -0.49)
    assert from_lamp.sum() > PATHS / 10
    assert flux[from_lamp, 0].sum() == pytest.approx(solid_angle(0.1, 0.3), rel=0.1)


def test_what_is_hidden_from_an_emitter_gets_none_of_its_light() -> None:
    screen = quad([-0.4, -0.2, -0.4], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8], 1)
    mirror = quad([-0.1, 0.0, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 0)
    lamp = quad([-0.05, -0.4, -0.05], [0.0, 0.0, 0.1], [0.1, 0.0, 0.0], 2)
    scene = resident_of([mirror, screen, lamp], [GLASS, grey(0.5), grey(0.0, 3.0)])
    assert len(photons_in(caustics_of(scene, PATHS))[0]) == 0


@pytest.mark.parametrize("bounces", [1, 2])
def test_paths_meet_no_more_glass_than_bounces(bounces: int) -> None:
    """A block of glass has two faces, and keeps what both reflect: 4 % each."""
    floor = quad([-0.5, -0.5, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1)
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1.0, 1.0), direction=(0.0, -1.0, 0.0))
    device_scene = resident_of([*cube(0.1), floor], [GLASS, grey(0.5)], lights=[sun])
    positions, _, flux = photons_in(caustics_of(device_scene, PATHS, bounces))
    through = np.abs(positions[:, [0, 2]]).max(axis=1, initial=0.0) < 0.101
    expected = 0.04 * (0.96**2 if bounces == 2 else 0.0)
    assert flux[through, 0].sum() == pytest.approx(expected, rel=0.03)


def test_an_area_light_sends_by_a_mirror_what_its_form_factor_tells() -> None:
    """A small lamp of cosine emission below the mirror's middle."""
    mirror = quad([-0.1, 0.0, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], 0)
    lamp = quad([-0.005, -0.3, -0.005], [0.0, 0.0, 0.01], [0.01, 0.0, 0.0], 2)
    floor = quad([-0.5, -0.4, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1)
    device_scene = resident_of([mirror, lamp, floor], [MIRROR, grey(0.5), grey(0.0, 3.0)])
    flux = photons_in(caustics_of(device_scene, PATHS))[2]
    assert flux[:, 0].sum() == pytest.approx(np.pi * 3.0 * 1e-4 * rectangle_over(0.1, 0.1, 0.3), rel=0.03)
