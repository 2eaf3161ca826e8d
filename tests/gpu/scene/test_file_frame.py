import numpy as np

from gpu.scene.file_frame import FileFrame

SURVEY = FileFrame("z", 0.3048, (456_789.123, 5_432_100.456, 120.789))


def test_z_up_becomes_y_up_without_mirroring() -> None:
    turned = FileFrame("z").turned(np.eye(3))
    assert np.array_equal(turned, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    assert np.linalg.det(turned) == 1.0


def test_the_origin_is_taken_away_in_the_units_of_the_file() -> None:
    assert np.allclose(SURVEY.to_world(np.add(SURVEY.origin, (1.0, 2.0, 3.0))), (0.3048, 3 * 0.3048, -2 * 0.3048))


def test_coordinates_of_a_survey_come_back_to_the_micrometre() -> None:
    points = np.array(SURVEY.origin) + np.random.default_rng(0).normal(0.0, 1e3, (100, 3))
    assert np.abs(SURVEY.to_file(SURVEY.to_world(points)) - points).max() < 1e-6 / 0.3048


def test_a_plain_frame_changes_nothing() -> None:
    points = np.array([[1.0, 2.0, 3.0]])
    assert np.array_equal(FileFrame().to_file(FileFrame().to_world(points)), points)
