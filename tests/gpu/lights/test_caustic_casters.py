from dataclasses import replace

import numpy as np
import pytest
from glass import GLASS, MIRROR
from scenes import grey, quad, resident_of

from gpu.device_scene.features import scene_features
from gpu.lights.caustic_casters import caustic_casters
from gpu.scene.types import Material

MATERIALS = [grey(0.5), MIRROR, GLASS, replace(MIRROR, roughness=0.2), replace(GLASS, roughness=0.4)]


@pytest.mark.parametrize(("lobes", "first"), [(False, 1), (True, 3)])
def test_mirrors_and_clear_glass_cast_caustics_by_their_area_and_so_do_lobes(lobes: bool, first: int) -> None:
    parts = [quad([0.2 * k, 0, 0], [0.1, 0, 0], [0, 0.1 + 0.1 * k, 0], k) for k in range(5)]
    device_scene = resident_of(parts, MATERIALS)
    casters = caustic_casters(device_scene)[not lobes]
    assert casters.lobes == lobes
    faces = casters.faces.numpy()
    materials = device_scene.scene.triangle_material[device_scene.triangle_order[faces]]
    assert sorted(materials) == [first, first, first + 1, first + 1]
    scale = device_scene.scene.placement.scale
    assert np.allclose(casters.areas.numpy(), (0.1 + 0.1 * materials) * 0.05 * scale**2, rtol=1e-5)
    shares = np.diff(np.append(0.0, casters.choice.cumulative.numpy() / 2**32))
    assert np.allclose(shares, (1 + materials) / (2.0 * (2 * first + 3)), atol=1e-6)


def test_matt_and_painted_surfaces_cast_none() -> None:
    materials = [grey(0.5), Material(roughness=0.5, metallic=1.0), Material(roughness=0.1)]
    parts = [quad([0.0, 0.0, k], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], k) for k in range(3)]
    device_scene = resident_of(parts, materials)
    assert caustic_casters(device_scene) == []
    assert not scene_features(device_scene.scene, lambertian=False).caustics


@pytest.mark.parametrize(("side", "share"), [(0.02, 1.0 / 16.0), (0.3, 4.0 * 0.09), (0.7, 0.5)])
def test_small_lobes_get_few_paths_and_mirrors_the_rest(side: float, share: float) -> None:
    parts = [quad([0, 0, 0], [1, 0, 0], [0, 1, 0]), quad([0, 0, 1], [1, 0, 0], [0, 1, 0], 1)]
    parts.append(quad([0, 0, 0.5], [side, 0, 0], [0, side, 0], 3))
    device_scene = resident_of(parts, MATERIALS)
    scale = device_scene.scene.placement.scale
    lobes, mirrors = caustic_casters(device_scene)
    assert lobes.share == pytest.approx(np.clip(share * scale**2, 1.0 / 16.0, 0.5))
    assert mirrors.share == 1.0 - lobes.share
