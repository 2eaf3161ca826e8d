import numpy as np
import pytest

from tests.bench.pictures import LEAST_DECADE, MOST_DECADE, WIDEST, decoded, displayed, encoded, error_map, shrunk


def test_an_error_map_holds_decades() -> None:
    reference = np.ones((2, 3, 3), np.float32)
    render = reference.copy()
    render[0, 0] += 0.1
    decades = error_map(render, reference) / 255.0 * (MOST_DECADE - LEAST_DECADE) + LEAST_DECADE
    assert decades[0, 0] == pytest.approx(np.log10(0.01 / 1.01), abs=0.03)
    assert decades[1, 2] == LEAST_DECADE


def test_wide_pictures_shrink_to_their_means() -> None:
    image = np.random.default_rng(0).random((10, 2 * WIDEST, 3)).astype(np.float32)
    small = shrunk(image)
    assert small.shape == (5, WIDEST, 3)
    assert np.allclose(small[0, 0], image[:2, :2].mean(axis=(0, 1)))
    assert shrunk(image[:, :WIDEST]).shape == (10, WIDEST, 3)


def test_pixels_survive_their_text_but_for_jpegs_rounding() -> None:
    ramp = np.linspace(0.2, 1.0, 16, dtype=np.float32)
    pixels = displayed(np.stack([np.add.outer(ramp, ramp) / 2.0] * 3, axis=2), 1.0)
    assert np.abs(decoded(encoded(pixels)).astype(int) - pixels).max() <= 2
    assert displayed(np.array([[[0.0, 1.0, 2.0]]], np.float32), 1.0).ravel().tolist() == [0, 255, 255]
