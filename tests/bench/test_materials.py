from pathlib import Path

import numpy as np
import pytest
from pictures import CAMERA, SIZE, mirror_room

from gpu.errors import UserError
from tests.bench.materials import chained_pixels, errors_of_pixels, run
from tests.bench.suite import Suite


def test_without_references_it_says_what_it_needs(tmp_path: Path, cpu: str) -> None:
    with pytest.raises(UserError, match="materials: needs --scenes"):
        run(Suite(out=tmp_path, cache=tmp_path, device=cpu))


def test_pixels_with_chains_are_those_that_show_a_mirror() -> None:
    chained = chained_pixels(mirror_room(), CAMERA, SIZE)
    assert chained[11:22, 18:31].all()
    assert 143 <= chained.sum() <= 250


def test_errors_are_those_of_the_pixels_alone() -> None:
    reference = np.ones((2, 4, 3), np.float32)
    image, mask = reference.copy(), np.zeros((2, 4), bool)
    mask[0, :2] = True
    image[mask] = 1.5
    assert errors_of_pixels(image, reference, mask) == pytest.approx(
        {"share": 0.25, "rel_mse": 0.25 / 1.01, "energy": 1.5}
    )
    assert errors_of_pixels(image, reference, ~mask) == pytest.approx({"share": 0.75, "rel_mse": 0.0, "energy": 1.0})
    assert errors_of_pixels(image, reference, ~mask & mask)["share"] == 0.0
