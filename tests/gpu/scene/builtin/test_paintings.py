"""Paintings are deterministic, of their stated size, within the albedos of real surfaces, and show their subject."""

from collections.abc import Callable

import numpy as np
import pytest
from image_checks import assert_sound_image

from gpu.scene.builtin import paintings
from gpu.scene.types import Bytes

BROWN = "#59402a #7c5b3d #97744f"
MAKERS: dict[str, Callable[[int], Bytes]] = {
    "landscape": lambda seed: paintings.landscape(seed, BROWN, BROWN, 128),
    "blocks": lambda seed: paintings.blocks(seed, "#ffffff " + BROWN, 128),
    "strata": lambda seed: paintings.strata(seed, BROWN, 128),
}


@pytest.mark.parametrize("name", MAKERS)
def test_is_sound_and_depends_on_its_seed_alone(name: str) -> None:
    assert_sound_image(MAKERS[name])


def test_a_landscape_has_its_sky_above_its_hills() -> None:
    pixels = paintings.landscape(3, "#4060e0 #5070e0", "#40a040 #60c060", 128)[..., :3].astype(np.float64)
    red, green, blue = (pixels[..., channel] for channel in range(3))
    assert (blue - green)[:16, :32].min() > 0.0
    assert (green - blue)[-16:].min() > 0.0
    sun = np.argmax(np.where(np.arange(128)[:, None] < 64, red, 0.0))
    assert np.hypot(sun % 128 / 128 - 0.68, sun // 128 / 128 - 0.3) < 0.1


def test_blocks_lie_on_a_ground_of_the_first_colour() -> None:
    pixels = paintings.blocks(3, "#e0e0e0 #e04040 #4040e0", 128)[..., :3].astype(np.float64)
    redness = pixels[..., 0] - pixels[..., 2]
    assert np.abs(redness[:, :6]).max() < 10.0
    assert redness[24, 64] > 50.0
    assert redness[112, 64] < -50.0
