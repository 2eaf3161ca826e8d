"""Radiosity of narrow surfaces: that of VPLs on slats in a room, told by rays."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import LightEdit, SceneEdits, edited
from gpu.scene.types import Floats, Light, LightKind
from gpu.vpl.gathered_radiosity import GatherParameters
from gpu.vpl.light_set import LightSetChoice
from gpu.vpl.light_sets import LightSets

CHOICE = LightSetChoice(vpls=3000, vpl_clusters=60, bounces=16, seed=0, lambertian=True)
WIDTH = 0.01  # of slats, where VPLs are about 0.05 apart
SLATS = [quad((x, 0.05 * x, -0.4), (0.0, 0.0, 0.8), (WIDTH, 0.0, 0.0)) for x in np.linspace(-0.4, 0.4, 9)]


def silent(what: str, fraction: float) -> None:
    pass


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gather however few VPLs there are."""
    monkeypatch.setattr("gpu.vpl.light_sets.GATHER_PARAMETERS", parameters(GatherParameters, least_vpls=0))


def radiosity_on_slats(light_sets: LightSets, choice: LightSetChoice = CHOICE) -> Floats:
    """Of each VPL there."""
    light_set = light_sets.made(choice, silent)
    lit, count = light_sets.radiosity(light_set), light_set.count
    inside = (np.abs(lit.position.numpy()[:count]) < 0.45).all(axis=1)
    assert 20 < inside.sum() < 0.2 * count
    return np.asarray(lit.radiosity.numpy()[:count][inside, 0])


def lamp(intensity: float) -> Light:
    return Light("lamp", LightKind.POINT, (intensity,) * 3, position=(0.0, 0.4, 0.0))


EVEN = [grey(0.5), grey(0.5, emission=1.0 / np.pi)]


@pytest.mark.usefixtures("few")
def test_slats_in_an_evenly_lit_room_have_the_radiosity_of_its_walls() -> None:
    """Walls that emit M/π and reflect ρ, and slats that reflect as much, have M·ρ/(1 − ρ), but that these hide a
    little.
    """
    room = resident_of([*box(1), *SLATS], EVEN)
    assert radiosity_on_slats(LightSets(room)).mean() == pytest.approx(1.0, rel=0.1)


def test_few_vpls_have_the_radiosity_that_their_density_tells() -> None:
    """Which is too little: on a disk of three in eight places there would be more VPLs."""
    assert radiosity_on_slats(LightSets(resident_of([*box(1), *SLATS], EVEN))).mean() < 0.8


@pytest.mark.usefixtures("few")
def test_slats_have_the_light_of_a_lamp_above_them_and_follow_it_when_it_is_dimmed() -> None:
    """One of intensity I sends I·cos³θ/h² to what lies h below and θ aside."""
    lamp = Light("lamp", LightKind.POINT, (2.0, 2.0, 2.0), position=(0.0, 0.4, 0.0))
    room = resident_of([*box(0), *SLATS], [grey(0.5)], lights=[lamp])
    base = DeviceScene(room.scene, "cpu")
    light_sets, choice = LightSets(room), replace(CHOICE, bounces=1)
    radiosity = radiosity_on_slats(light_sets, choice)
    light_set = light_sets.made(choice, silent)
    place = light_set.clusters.members.position.numpy()[: light_set.count]
    way = np.array([0.0, 0.4, 0.0]) - place[(np.abs(place) < 0.45).all(axis=1)]
    expected = 0.5 * 2.0 * way[:, 1] / np.linalg.norm(way, axis=1) ** 3
    # Where VPLs are densest, below the lamp, some have disks as narrow as slats are.
    assert np.isclose(radiosity, expected, rtol=0.02).mean() > 0.8
    dimmed = SceneEdits(lights={"lamp": LightEdit(intensity=0.5)})
    assert light_sets.follow(base.edited(edited(base.scene, dimmed)))
    assert np.allclose(radiosity_on_slats(light_sets, choice), 0.5 * radiosity, rtol=1e-4)
