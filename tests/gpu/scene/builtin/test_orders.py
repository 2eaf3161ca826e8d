"""Parts of a colonnade face outwards and have the measures of their order."""

from collections.abc import Callable

import numpy as np
import pytest
from shape_checks import volume

from gpu.scene.builtin import orders
from gpu.scene.builtin.shape import Shape


@pytest.mark.parametrize(
    "make",
    [
        lambda: orders.column(3.2, 0.2),
        lambda: orders.fountain(1.3)[0],
        orders.baluster,
        lambda: orders.arch(2.4, 1.75, 0.36)[1],
    ],
)
def test_its_solids_face_outwards(make: Callable[[], Shape]) -> None:
    assert volume(make()) > 0.0


def test_a_column_is_as_high_as_asked_and_swells_less_towards_its_top() -> None:
    column = orders.column(3.2, 0.2)
    np.testing.assert_allclose((column.positions[:, 1].min(), column.positions[:, 1].max()), (0.0005, 3.2), atol=1e-9)
    reach = np.hypot(column.positions[:, 0], column.positions[:, 2])
    heights = column.positions[:, 1]
    below, above = (reach[(heights > low) & (heights < low + 0.7)].max() for low in (0.4, 1.8))
    assert 0.84 * 0.2 < above < below <= 0.2


def test_an_arch_leaves_its_opening_free() -> None:
    wall, _ = orders.arch(2.4, 1.75, 0.36)
    radius = 2.4 / 2 - 0.23
    centres = wall.positions[wall.triangles].mean(axis=1)
    assert np.hypot(centres[:, 0], centres[:, 1]).min() > 0.98 * radius
    np.testing.assert_allclose(np.ptp(wall.positions, axis=0), (2.4, 1.75, 0.36))


def test_a_clipped_ball_is_leaves_about_its_core() -> None:
    leaves, core = orders.topiary(1, 0.4)
    assert np.linalg.norm(core.positions, axis=1).max() == pytest.approx(0.88 * 0.4)
    assert np.linalg.norm(leaves.positions, axis=1).max() < 0.4 * 1.25
    assert len(leaves.positions) == 700 * 15
