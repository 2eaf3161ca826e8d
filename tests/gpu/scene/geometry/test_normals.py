import numpy as np

from gpu.scene.geometry.normals import area_vectors, repaired_normals, smooth_normals, unit_rows

CORNER = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2]])
SIDES = np.array([[0, 1, 2], [0, 3, 1]])


def test_area_vectors_have_twice_the_area_on_the_counter_clockwise_side() -> None:
    assert np.array_equal(area_vectors(CORNER, SIDES), [[0, 0, 1], [0, 2, 0]])


def test_unit_rows_of_any_size() -> None:
    rows = np.array([[3e200, 0, 4e200], [0, 5e-200, 0], [0, 0, 0], [np.nan, 1, 0], [np.inf, 0, 0]])
    unit, good = unit_rows(rows)
    assert np.allclose(unit[:2], [[0.6, 0, 0.8], [0, 1, 0]])
    assert good.tolist() == [True, True, False, False, False]


def test_sound_normals_are_kept_and_broken_ones_become_geometric() -> None:
    normals = np.array([[np.nan, 0, 0], [5, 0, 0], [0, 0, 0], [0, np.inf, 0]])
    repaired = repaired_normals(normals, CORNER.astype(np.float32), SIDES)
    assert np.allclose(repaired[0], [0, 2 / 5**0.5, 1 / 5**0.5])  # both triangles, by area
    assert np.allclose(repaired[1:], [[1, 0, 0], [0, 0, 1], [0, 1, 0]])


def test_triangles_back_to_back_still_give_a_normal() -> None:
    both_sides = np.array([[0, 1, 2], [0, 2, 1]])
    repaired = repaired_normals(np.zeros((3, 3)), CORNER[:3].astype(np.float32), both_sides)
    assert np.allclose(np.abs(repaired), [[0, 0, 1]] * 3)


def test_smooth_normals_do_not_depend_on_how_a_polygon_is_cut() -> None:
    roof = np.array([[0.0, 0, 0], [0, 0, 1], [1, 1, 0], [1, 1, 1], [2, 0, 0], [2, 0, 1]])
    for cut in ([[0, 1, 3], [0, 3, 2]], [[0, 1, 2], [1, 3, 2]]):
        normals, _ = unit_rows(smooth_normals(roof, np.array([*cut, [2, 3, 5], [2, 5, 4]])))
        assert np.allclose(normals[2:4], (0, 1, 0))
