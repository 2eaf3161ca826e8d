import numpy as np
import pytest

from gpu.scene.formats.gltf.specular_glossiness import converted
from gpu.scene.types import Material, TextureSlot

SLOT = TextureSlot(3)


def given(diffuse: list[float], specular: list[float], texture: list[float] | None = None) -> Material:
    slot = (SLOT, np.array(texture)) if texture else None
    return converted(Material("m"), np.array([*diffuse, 1.0]), np.array(specular), 0.9, slot)


@pytest.mark.parametrize("diffuse", [[0.8, 0.2, 0.1], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
def test_a_dielectric_keeps_its_diffuse_colour(diffuse: list[float]) -> None:
    material = given(diffuse, [0.04] * 3)
    assert np.allclose(material.base_color[:3], diffuse)
    assert material.metallic == pytest.approx(0.0, abs=1e-6)
    assert material.roughness == pytest.approx(0.1)


@pytest.mark.parametrize("specular", [[1.0, 0.77, 0.34], [0.95, 0.93, 0.88]])
def test_a_metal_takes_the_colour_that_it_reflects(specular: list[float]) -> None:
    material = given([0.0] * 3, specular)
    assert material.metallic > 0.9
    assert np.allclose(material.base_color[:3], specular, atol=0.06)


def test_in_between_diffuse_and_reflected_light_are_about_the_same() -> None:
    diffuse, specular = np.array([0.5, 0.5, 0.5]), np.array([0.2, 0.2, 0.2])
    material = given([*diffuse], [*specular])
    base, metallic = np.array(material.base_color[:3]), material.metallic
    assert np.allclose(base * (1 - metallic), diffuse * (1 - 0.2) / 0.96, atol=0.05)
    assert np.allclose(0.04 * (1 - metallic) + base * metallic, specular, atol=0.05)


def test_a_dielectrics_texture_stays_and_a_metals_does_not() -> None:
    assert given([1.0] * 3, [0.04] * 3, [0.5, 0.25, 0.5, 1.0]).base_color_slot == SLOT
    assert given([1.0] * 3, [0.04] * 3, [0.5, 0.25, 0.5, 1.0]).base_color == pytest.approx((1, 1, 1, 1))
    assert given([1.0] * 3, [0.9] * 3, [0.01, 0.01, 0.01, 1.0]).base_color_slot is None
