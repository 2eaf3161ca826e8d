"""Textures are deterministic, of their stated size, within the albedos of real surfaces, and repeat without a seam."""

from collections.abc import Callable

import numpy as np
import pytest
from image_checks import assert_sound_image

from gpu.scene.builtin import textures
from gpu.scene.types import Bytes

BROWN = "#59402a #7c5b3d #97744f"
MAKERS: dict[str, Callable[[int], Bytes]] = {
    "wood": lambda seed: textures.wood(seed, BROWN, 128),
    "planks": lambda seed: textures.planks(seed, BROWN, 4, 2, 128),
    "marble": lambda seed: textures.marble(seed, BROWN, 1.0, 128),
    "tiles": lambda seed: textures.tiles(seed, [BROWN, "#ffffff #000000"], 4, "#222222", 128),
    "plaster": lambda seed: textures.plaster(seed, "#dddddd", 0.02, 128),
    "fabric": lambda seed: textures.fabric(seed, BROWN, 16, 128),
    "carpet": lambda seed: textures.carpet(seed, BROWN, 2, 128),
    "leaves": lambda seed: textures.leaves(seed, BROWN, 128),
    "spines": lambda seed: textures.book_spines(seed, BROWN, 16, 128),
    "kilim": lambda seed: textures.kilim(seed, BROWN + " #ffffff #000000", 128),
}


@pytest.mark.parametrize("name", MAKERS)
def test_is_sound_and_depends_on_its_seed_alone(name: str) -> None:
    assert_sound_image(MAKERS[name])


@pytest.mark.parametrize("name", ["wood", "marble", "plaster", "fabric"])
def test_repeats_without_a_seam(name: str) -> None:
    pixels = MAKERS[name](5)[..., :3].astype(np.float64)
    for axis in (0, 1):
        steps = np.abs(pixels - np.roll(pixels, 1, axis=axis)).mean(axis=(1 - axis, 2))
        assert steps[0] <= 1.5 * steps.max(initial=0.0, where=np.arange(128) > 0)


def test_colours_of_a_palette_lie_evenly_along_a_ramp() -> None:
    np.testing.assert_allclose(textures.palette("#ff0000 #00ff33"), [(1, 0, 0), (0, 1, 0.2)])
    values = textures.ramp(np.array([[-1.0, 0.25, 2.0]]), "#000000 #ff0000 #ffffff")
    np.testing.assert_allclose(values[0], [(0, 0, 0), (0.5, 0, 0), (1, 1, 1)])


def test_noise_is_seamless_and_stretched_where_asked() -> None:
    values = textures.noise(128, 1, 1.5, (8.0, 1.0))
    assert values.std() == pytest.approx(1.0)
    assert abs(values.mean()) < 1e-9
    across = np.abs(np.diff(values, axis=1)).mean()
    assert across < 0.5 * np.abs(np.diff(values, axis=0)).mean()


def test_what_images_share_is_made_once_and_forgotten() -> None:
    textures.forget()
    first, again = textures.fabric(3, BROWN, size=64), textures.fabric(3, BROWN, size=64)
    assert np.array_equal(first, again)
    assert textures._weave.cache_info().misses == 1
    textures.forget()
    assert textures._gain.cache_info().currsize + textures._weave.cache_info().currsize == 0
