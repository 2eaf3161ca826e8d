"""What tests ask of procedural images."""

from collections.abc import Callable

import numpy as np

from gpu.scene.types import Bytes


def assert_sound_image(make: Callable[[int], Bytes]) -> None:
    """An image of 128 × 128 opaque pixels, within the albedos of real surfaces, depends on its seed alone."""
    first, again, other = make(3), make(3), make(4)
    assert first.shape == (128, 128, 4)
    assert first.dtype == np.uint8
    assert (first[..., 3] == 255).all()
    assert first[..., :3].min() >= 64
    assert first[..., :3].max() <= 236
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
