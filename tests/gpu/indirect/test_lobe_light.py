"""Where rays of lobes end: past mirrors and glass, in what VPLs know of the light there."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import box, grey, quad, resident_of, results

from gpu.device_scene.data import SceneData
from gpu.indirect.lobe_light import NO_EMISSION, KnownLight, LobeRay, known_light, light_along
from gpu.scene.types import Doubles, Material
from gpu.vpl.light_sets import LightSetChoice, LightSets

MIRROR = Material(base_color=(0.8, 0.8, 0.8, 1.0), metallic=1.0, roughness=0.0)
CLEAR = Material(base_color=(1.0, 1.0, 1.0, 1.0), transmission=1.0, roughness=0.0)


@wp.kernel
def seen_kernel(first: int, scene: SceneData, known: KnownLight, density: float, out: wp.array[wp.vec3]) -> None:
    """One thread a ray: what is seen from near the middle along −z."""
    ray = LobeRay()
    ray.normal = wp.vec3(0.0, 0.0, -1.0)
    ray.direction = wp.normalize(wp.vec3(0.002 * float(first + wp.tid()), 0.003, -1.0))
    ray.density = density
    ray.place = first + wp.tid()
    out[first + wp.tid()] = light_along(scene, known, ray).light


def seen(material: Material, density: float = NO_EMISSION) -> Doubles:
    """Light along 64 rays that meet a plate of `material`, in parts of what there is: the wall behind the plate is lit
    and half of its light its own, the wall that the rays begin before is black.
    """
    parts = [*box(), quad((-0.3, -0.3, -0.3), (0.6, 0.0, 0.0), (0.0, 0.6, 0.0), 1)]
    parts[5] = replace(parts[5], material=2)
    device_scene = resident_of(parts, [grey(0.5, emission=1.0 / np.pi), material, grey(0.0)]).generalised()
    lights = LightSets(device_scene)
    choice = LightSetChoice(vpls=5000, vpl_clusters=100, bounces=8, seed=0, lambertian=False)
    cache = lights.radiosity(lights.made(choice, lambda what, fraction: None))
    inputs = [device_scene.view(lambertian=False), known_light(lights.table, cache, direct=True), density]
    return np.asarray(results(seen_kernel, 64, inputs, wp.vec3))[:, 0] * np.pi / 2.0


def test_matt_surfaces_show_the_light_that_they_get() -> None:
    assert seen(grey(0.8)).mean() > 0.2


@pytest.mark.parametrize("roughness", [0.0, 0.1])
def test_mirrors_and_narrow_metal_show_what_they_reflect(roughness: float) -> None:
    assert seen(replace(MIRROR, roughness=roughness)) == pytest.approx(np.zeros(64), abs=1e-4)


def test_glass_shows_what_is_behind() -> None:
    behind = seen(CLEAR).mean()
    assert 0.25 < behind < 0.5
    assert seen(CLEAR, 0.0).mean() == pytest.approx(behind + 0.5 * 0.92, abs=0.03)
