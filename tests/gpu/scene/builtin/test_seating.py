"""Seats stand on the floor, face outwards and have the size that they are asked for."""

from collections.abc import Callable

import numpy as np
import pytest
from shape_checks import volume

from gpu.scene.builtin import seating
from gpu.scene.builtin.shape import Shape


@pytest.mark.parametrize(
    "make",
    [
        lambda: seating.pouf(0.3, 0.4),
        lambda: seating.sofa(2.0, 3)[0],
        lambda: seating.wooden_chair()[1],
    ],
)
def test_its_solids_face_outwards(make: Callable[[], Shape]) -> None:
    assert volume(make()) > 0.0


def test_a_sofa_is_as_wide_as_asked_and_stands_on_its_legs() -> None:
    upholstery, legs = seating.sofa(2.0, 3)
    np.testing.assert_allclose(np.ptp(upholstery.positions[:, [0, 2]], axis=0), (2.0, 0.92), atol=0.02)
    assert legs.positions[:, 1].min() == pytest.approx(0.0005)
    assert legs.positions[:, 1].max() > upholstery.positions[:, 1].min()
    more = seating.sofa(2.0, 4)[0]
    cushion = len(more.positions) - len(upholstery.positions)
    assert 0 < cushion < len(upholstery.positions) / 3


def test_a_scatter_cushion_leans_back_about_its_place() -> None:
    place = (1.0, 0.6, -2.0)
    cushion = seating.scatter(place, 20.0)
    low, high = cushion.positions.min(axis=0), cushion.positions.max(axis=0)
    np.testing.assert_allclose((low + high) / 2, place, atol=0.02)
    assert high[1] - low[1] > 2 * (high[2] - low[2])
