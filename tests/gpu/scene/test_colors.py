import numpy as np

from gpu.scene.colors import mean_color, srgb_to_linear
from gpu.scene.types import Texture


def test_known_levels() -> None:
    assert np.allclose(srgb_to_linear(np.array([0, 10, 11, 188, 255])), [0, 0.003035, 0.003347, 0.502886, 1], atol=1e-6)


def test_the_mean_of_a_texture_is_that_of_its_light() -> None:
    pixels = np.array([[[0, 255, 188, 0], [255, 255, 188, 255]]], np.uint8)
    assert np.allclose(mean_color(Texture("t", pixels, srgb=True)), [0.5, 1.0, 0.503, 0.5], atol=1e-3)
    assert np.allclose(mean_color(Texture("t", pixels, srgb=False)), [0.5, 1.0, 188 / 255, 0.5])
