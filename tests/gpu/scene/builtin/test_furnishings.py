"""Small things have fronts that face outwards and the size that they are asked for."""

from collections.abc import Callable

import numpy as np
import pytest
from shape_checks import volume

from gpu.scene.builtin import furnishings
from gpu.scene.builtin.shape import Shape


@pytest.mark.parametrize(
    "make",
    [
        lambda: furnishings.cushion(0.5),
        lambda: furnishings.mug(0.04, 0.095),
        furnishings.saucer,
        lambda: furnishings.vase(0.1, 0.3),
        lambda: furnishings.bowl_of_fruit(1)[0],
        lambda: furnishings.bowl_of_fruit(1)[2],
    ],
)
def test_its_solids_face_outwards(make: Callable[[], Shape]) -> None:
    assert volume(make()) > 0.0


def test_a_fig_grows_out_of_its_pot_up_to_its_height() -> None:
    stems, leaves = furnishings.tree(3, 1.6, 50, 0.3)
    assert 0.25 < stems.positions[:, 1].min() < 0.3
    assert 0.72 * 1.6 < stems.positions[:, 1].max() < 1.6
    assert len(leaves.positions) == 50 * len(furnishings.leaf(0.2, 0.105, 0.35).positions)
    np.testing.assert_allclose(np.linalg.norm(leaves.normals, axis=1), 1.0)


def test_books_fill_their_shelf_but_do_not_hang_over_it() -> None:
    covers, pages = furnishings.books(5, 0.8, 0.3)
    assert covers.positions[:, 0].min() == 0.0
    assert 0.8 - 0.042 < covers.positions[:, 0].max() <= 0.8
    assert 0.72 * 0.3 <= covers.positions[:, 1].max() <= 0.3
    assert covers.positions[:, 2].max() <= 0.0
    for axis in (0, 1, 2):
        assert covers.positions[:, axis].min() < pages.positions[:, axis].min()
        assert pages.positions[:, axis].max() < covers.positions[:, axis].max()
    assert (covers.uvs >= 0.0).all()
    assert (covers.uvs <= 1.0).all()


def test_a_curtain_hangs_to_the_floor_in_folds_that_face_the_room() -> None:
    hung = furnishings.curtain(0.7, 2.5, 7.5, 0.05, 1)
    np.testing.assert_allclose((hung.positions[:, 1].min(), hung.positions[:, 1].max()), (0.015, 2.5))
    assert np.abs(hung.positions[:, 0]).max() == pytest.approx(0.35)
    assert 0.05 < np.abs(hung.positions[:, 2]).max() <= 0.06
    a, b, c = (hung.positions[hung.triangles[:, corner]] for corner in range(3))
    assert np.cross(b - a, c - a)[:, 2].sum() > 0.0
