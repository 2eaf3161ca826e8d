import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column

from gpu.film.tonemap import Tonemap

CPU = wp.get_device("cpu")


def shown(radiance: NDArray, exposure: float | None, **parameters: float) -> tuple[NDArray, int]:
    """The bytes of a picture, and how many of its pixels are not finite."""
    tonemap = Tonemap(len(radiance), CPU, **parameters)
    tonemap.run(column(radiance, wp.vec3), exposure)
    return tonemap.pixels.numpy(), tonemap.nonfinite()


def twin(radiance: NDArray, exposure: float) -> NDArray:
    """The same curve in NumPy."""
    x = np.maximum(radiance * exposure, 0.0)
    x = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
    return 255.0 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-12) ** (1 / 2.4) - 0.055)


def test_a_fixed_exposure_follows_the_curve() -> None:
    radiance = np.random.default_rng(0).uniform(0.0, 4.0, (5000, 3)) ** 2
    pixels, bad = shown(radiance, 0.7)
    assert np.abs(pixels - twin(radiance, 0.7)).max() <= 0.51
    assert bad == 0


@pytest.mark.parametrize(("scale", "grey"), [(1e-9, {}), (1.0, {}), (1e9, {}), (1.0, {"middle_grey": 0.36})])
def test_automatic_exposure_shows_the_same_picture_at_any_scale(scale: float, grey: dict[str, float]) -> None:
    radiance = np.random.default_rng(1).uniform(0.1, 2.0, (3000, 3))
    luminance = radiance @ [0.2126, 0.7152, 0.0722]
    exposure = grey.get("middle_grey", 0.18) / np.exp(np.log(luminance).mean())
    pixels, _ = shown(radiance * scale, None, **grey)
    assert np.abs(pixels - twin(radiance, exposure)).max() <= 1.0


def test_non_finite_pixels_are_counted_and_shown() -> None:
    radiance = np.ones((2000, 3))
    radiance[17] = np.nan, 1.0, 1.0
    radiance[99] = np.inf
    pixels, bad = shown(radiance, None)
    assert bad == 2
    assert pixels[99].tolist() == [255, 0, 255]
    assert pixels[17, 0] == 255
    assert (pixels[0] == pixels[1]).all()


def test_a_black_picture_stays_black() -> None:
    pixels, bad = shown(np.zeros((100, 3)), None)
    assert (pixels == 0).all()
    assert bad == 0
