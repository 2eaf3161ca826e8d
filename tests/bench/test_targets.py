import numpy as np
import pytest

from gpu.camera import look_at
from tests.bench.targets import AHEAD, PERIOD, changes, held, swayed


def test_what_is_within_a_tenth_of_its_target_is_held() -> None:
    measured = held([9.0, 10.0, 11.0, 11.2], 10.0)
    assert measured["within"] == 0.75
    assert measured["mean"] == pytest.approx(1.03)
    assert measured["median"] == pytest.approx(1.05)


def test_changes_of_counts_are_counted() -> None:
    assert changes([(1, 2), (1, 2), (1, 3), (1, 2)]) == 2
    assert changes([(1, 2)]) == 0


def test_a_walk_sways_and_comes_back() -> None:
    camera = look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    eyes = [swayed(camera, 10.0, frame).to_world[:3, 3] for frame in range(PERIOD + 1)]
    assert np.allclose(eyes[PERIOD // 2], (0.0, 0.0, 3.0 - 10.0 * AHEAD))
    assert np.allclose(swayed(camera, 10.0, PERIOD).to_world, camera.to_world)
    left, right = (swayed(camera, 10.0, PERIOD * quarter // 4).to_world[:3, :3] @ (0, 0, -1) for quarter in (1, 3))
    assert left[0] == pytest.approx(-right[0])
    assert left[0] < -0.2
