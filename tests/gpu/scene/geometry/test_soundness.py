import numpy as np

from gpu.scene.geometry.soundness import sound


def test_points_lines_and_what_is_too_thin_for_single_precision_are_not_sound() -> None:
    unit = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 1e-13, 0], [np.inf, 0, 0]])
    triangles = np.array([[0, 1, 2], [0, 1, 1], [0, 1, 3], [0, 1, 4], [0, 1, 5]])
    assert sound(unit, triangles).tolist() == [True, False, False, False, False]
