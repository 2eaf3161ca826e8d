import numpy as np
import pytest
from glass import bulb, caustics_of, mirror_over_floor, photons_in

from gpu.lights.caustic_map import widest_radius


def test_estimates_are_narrower_the_more_photons_there_are() -> None:
    assert widest_radius(40_000) == pytest.approx(widest_radius(10_000) / 2.0)
    assert widest_radius(1) == pytest.approx(0.1)


def test_seeds_differ_and_repeat() -> None:
    room = mirror_over_floor(bulb(0.0, -0.3, 0.0))
    first, again, other = (photons_in(caustics_of(room, 512, seed=seed))[0] for seed in (0, 0, 1))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_photons_at_an_edge_stand_for_those_that_would_lie_beyond_it() -> None:
    """Two walls of the room end the floor at x = ½; the lamp's image lights it evenly there."""
    caustics = caustics_of(mirror_over_floor(bulb(-0.12, -0.08, 0.0)), 8192)
    positions, normals, flux = photons_in(caustics)
    floor = normals[:, 1] > 0.9
    whole = caustics.light.sites.free.numpy()[: len(positions)][floor] > 0.0
    near = np.abs(positions[floor][:, 0] - 0.5) < 0.01
    assert near.sum() > 20
    assert not whole[near].any()
    assert flux[floor, 0][near].mean() > 1.3 * flux[floor, 0][whole].mean()


def test_a_cleared_map_has_no_photons() -> None:
    caustics = caustics_of(mirror_over_floor(bulb(0.0, -0.3, 0.0)), 256)
    caustics.clear()
    assert caustics.count.numpy()[0] == 0
    assert not caustics.light.grid.starts.numpy().any()
