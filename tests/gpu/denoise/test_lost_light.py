import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from walls import CPU, HEIGHT, LEFT, WIDTH, grey_values, numbers, split_walls, wall

from gpu.core.image_size import image_size
from gpu.denoise.lost_light import restore
from gpu.gbuffer.gbuffer import GBuffer

STEPS = (1, 2, 4)
MIDDLE = (slice(7, -7), slice(7, -7))  # what the image's border has no part in


def restored(gbuffer: GBuffer, smoothed: NDArray, before: NDArray, frames: int) -> NDArray:
    """`smoothed` (height, width) with what it lacks of the light `before`, the mean of so many `frames`."""
    light, less = grey_values(before), grey_values(smoothed)
    known = wp.full(WIDTH * HEIGHT, frames, dtype=int, device=CPU)
    restore(gbuffer, image_size((WIDTH, HEIGHT)), STEPS, 1.0, light, less, wp.zeros_like(light), known)
    return numbers(light)


def test_there_is_as_much_light_as_before_and_little_of_its_noise() -> None:
    before = np.random.default_rng(0).exponential(size=(HEIGHT, WIDTH)) ** 2 + 1.0
    result = restored(wall(), np.full((HEIGHT, WIDTH), 1.0), before, frames=8)
    assert result.sum() == pytest.approx(before.sum(), rel=1e-5)
    assert result[MIDDLE].var() < before.var() / 40.0


def test_light_is_given_back_to_its_own_surface() -> None:
    before = np.where(LEFT, 3.0, 1.0)
    for kind in ("normals", "depth"):
        result = restored(split_walls()[kind], np.ones((HEIGHT, WIDTH)), before, frames=8)
        assert result == pytest.approx(before, rel=1e-5)


@pytest.mark.parametrize(("frames", "share"), [(0, 1 / 3), (1, 1 / 3), (2, 2 / 3), (3, 1.0), (8, 1.0)])
def test_where_few_pixels_are_of_a_surface_few_frames_give_back_little(frames: int, share: float) -> None:
    line = np.zeros((HEIGHT, WIDTH), bool)
    line[:, 20] = True
    result = restored(wall(seen=line), np.zeros((HEIGHT, WIDTH)), line.astype(float), frames)
    assert result[MIDDLE[0], 20] == pytest.approx(share, rel=1e-5)


def test_no_light_is_less_than_none() -> None:
    before = np.zeros((HEIGHT, WIDTH))
    smoothed = np.where(LEFT, 1.0, 0.0)
    assert restored(wall(), smoothed, before, frames=8).min() == 0.0
