from dataclasses import replace

import numpy as np
import pytest
from scenes import box, grey, scene_of

from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import LightEdit, SceneEdits, edited
from gpu.scene.types import Light, LightKind
from gpu.vpl.light_set import LightSet, LightSetChoice
from gpu.vpl.light_sets import LightSets

CHOICE = LightSetChoice(vpls=300, vpl_clusters=10, bounces=3, seed=5, lambertian=True)


def silent(what: str, fraction: float) -> None:
    pass


@pytest.fixture(scope="module")
def base() -> DeviceScene:
    """A box with a hole, and a bulb in it."""
    bulb = Light("bulb", LightKind.POINT, (1.0, 1.0, 1.0))
    return DeviceScene(scene_of(box()[1:], [grey(0.5)], lights=[bulb]), "cpu")


def with_bulb_at(base: DeviceScene, x: float) -> DeviceScene:
    moved = SceneEdits(lights={"bulb": LightEdit(position=(x, 0.0, 0.0))})
    return base.edited(edited(base.scene, moved))


def bits(light_sets: LightSets, light_set: LightSet) -> list[bytes]:
    clusters, count = light_set.clusters, light_set.count
    radiosity = light_sets.radiosity(light_set).radiosity.numpy()[:count]
    arrays = clusters.disks.numpy(), clusters.members.flux.numpy()[:count], clusters.centre.numpy(), radiosity
    return [np.ascontiguousarray(array).tobytes() for array in arrays]


def test_a_set_that_follows_a_light_has_the_bits_of_a_new_one_in_its_own_arrays(base: DeviceScene) -> None:
    light_sets = LightSets(with_bulb_at(base, 0.4))
    light_set = light_sets.made(CHOICE, silent)
    bits(light_sets, light_set)
    arrays, number = light_set.clusters, light_set.numbers[0]
    for x in (0.3, -0.4):
        assert light_sets.follow(with_bulb_at(base, x))
        assert not light_sets.is_current(light_set)
        light_sets.renew(light_set, silent)
        anew = LightSets(with_bulb_at(base, x))
        assert bits(light_sets, light_set) == bits(anew, anew.made(CHOICE, silent))
        assert light_set.clusters is arrays
        assert light_set.numbers[0] == number


@pytest.mark.parametrize("room", [0.02, 0.5])
def test_a_set_that_outgrows_its_arrays_gets_others(
    base: DeviceScene, monkeypatch: pytest.MonkeyPatch, room: float
) -> None:
    """Where there is too little room for paths, or for the VPLs that they leave, arrays are made that have it."""
    light_sets = LightSets(with_bulb_at(base, 0.4))
    monkeypatch.setattr("gpu.vpl.light_sets.ROOM", 1.0)
    light_set = light_sets.made(replace(CHOICE, vpls=int(CHOICE.vpls * room)), silent)
    before = light_set.clusters, light_set.numbers
    light_set.choice = CHOICE
    light_sets.renew(light_set, silent)
    assert light_set.clusters is not before[0]
    assert light_set.numbers != before[1]
    anew = LightSets(with_bulb_at(base, 0.4))
    assert bits(light_sets, light_set) == bits(anew, anew.made(CHOICE, silent))
