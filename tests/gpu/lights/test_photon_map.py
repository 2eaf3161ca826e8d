import numpy as np
import pytest
import warp as wp
from pictures import lamp_room

from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table
from gpu.lights.photon_map import PhotonMap

PATHS, BOUNCES = 2000, 4
LAMP_POWER = np.pi * 5.0 * 0.4**2  # π · radiance · area
ALBEDO = 0.7


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def traced(room: DeviceScene, seed: int, bounces: int = BOUNCES) -> PhotonMap:
    photon_map = PhotonMap(PATHS, bounces, room.device)
    seeds = wp.full(1, seed, dtype=int, device=room.device)
    features = room.features(lambertian=True)
    photon_map.trace(room.view(lambertian=True), build_light_table(room), seeds, features)
    return photon_map


def flux(photon_map: PhotonMap) -> float:
    photons = photon_map.photons
    return float(photons.flux.numpy()[: photons.count.numpy()[0], 0].sum())


def test_first_hits_bring_the_power_of_the_lamp_and_later_ones_what_is_reflected(room: DeviceScene) -> None:
    first = traced(room, 0, bounces=1)
    assert first.photons.count.numpy()[0] == PATHS
    assert flux(first) == pytest.approx(LAMP_POWER, rel=1e-3)
    # The block, of albedo 0.4, and the lamp, of none, reflect less than the walls.
    assert (
        0.9 * sum(ALBEDO**n for n in range(BOUNCES))
        < flux(traced(room, 0)) / LAMP_POWER
        < sum(ALBEDO**n for n in range(BOUNCES))
    )


def test_photons_lie_in_runs_of_one_side_and_carry_alike(room: DeviceScene) -> None:
    photons = traced(room, 0).photons
    count = photons.count.numpy()[0]
    normals, fluxes = photons.normal.numpy()[:count], photons.flux.numpy()[:count]
    assert PATHS < count < PATHS * BOUNCES
    assert (np.abs(np.diff(normals, axis=0)).max(axis=1) > 0.1).sum() <= 5  # the room's six sides
    assert fluxes.max() < 1.01 * fluxes.min()  # Russian roulette keeps them so
    assert (np.abs(photons.position.numpy()[:count]) < 0.5001).all()


def test_seeds_differ_and_repeat(room: DeviceScene) -> None:
    first, again, other = (traced(room, seed).photons.position.numpy() for seed in (0, 0, 1))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
