import numpy as np

from gpu.scene.colors import srgb_to_linear


def test_known_levels() -> None:
    assert np.allclose(srgb_to_linear(np.array([0, 10, 11, 188, 255])), [0, 0.003035, 0.003347, 0.502886, 1], atol=1e-6)
