import numpy as np
import pytest

from gpu.film.frame import FrameStats
from gpu.scene.camera import look_at
from tests.bench.rows import over_target
from tests.bench.targets import AHEAD, PERIOD, held, path_of, running_means, share_at_fewest, swayed


def test_what_is_within_a_tenth_of_its_target_is_held() -> None:
    measured = held([9.0, 10.0, 11.0, 11.2], 10.0)
    assert measured["within"] == 0.75
    assert measured["mean"] == pytest.approx(1.03)
    assert measured["median"] == pytest.approx(1.05)


def test_a_path_keeps_each_frame_and_counts_what_changed() -> None:
    levels = [(8, 2, 1.0), (8, 2, 1.0), (9, 2, 3.0), (9, 2, 2.0), (4, 3, 2.0)]
    frames = []
    for sps, vpls, passes in levels:
        estimates = {"expected_ms": 1.6, "passes": passes}
        counts = {"sp_clusters": sps, "vpl_clusters": vpls}
        frames.append(FrameStats({"a": 1.0, "b": 0.5}, counts, {}, estimates))
    path = path_of(frames, [2.0, 2.0, 2.0, 2.0, 4.0], "ms")
    assert (path["frames"], path["changes"], path["light_sets"]) == (5, 3, 1)
    assert path["path_ms"] == [1.5] * 5
    assert (path["path_wall_ms"], path["wall_ms"]["median"]) == ([2.0, 2.0, 2.0, 2.0, 4.0], 2.0)
    assert path["path_expected"] == [1.6] * 5
    assert path["path_clusters"] == ["8 2", "8 2", "9 2", "9 2", "4 3"]
    assert (path["path_passes"], path["passes"]["median"]) == ([1.0, 1.0, 3.0, 2.0, 2.0], 2.0)


def test_errors_below_the_target_are_told_where_no_counts_are_fewer() -> None:
    levels = ["8 2", "8 2", "9 2", "8 2"]
    assert share_at_fewest([0.85, 0.95, 0.5, 1.2], levels, "8 2", 1.0) == 0.25


def test_running_means_are_of_so_many_values_in_a_row() -> None:
    assert running_means([1.0, 3.0, 5.0], 2) == [2.0, 4.0]
    assert running_means([1.0, 3.0], 4) == [2.0]


def test_a_walk_sways_and_comes_back() -> None:
    camera = look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    eyes = [swayed(camera, 10.0, frame).to_world[:3, 3] for frame in range(PERIOD + 1)]
    assert np.allclose(eyes[PERIOD // 2], (0.0, 0.0, 3.0 - 10.0 * AHEAD))
    assert np.allclose(swayed(camera, 10.0, PERIOD).to_world, camera.to_world)
    left, right = (swayed(camera, 10.0, PERIOD * quarter // 4).to_world[:3, :3] @ (0, 0, -1) for quarter in (1, 3))
    assert left[0] == pytest.approx(-right[0])
    assert left[0] < -0.2


def test_what_frames_have_over_a_target_is_of_those_that_were_measured() -> None:
    row = {"frames": 4, "path_ms": [3.0, 6.0, 6.0, 9.0], "target": {"ms": 6.0}}
    assert over_target(row) == ([1, 2, 3, 4], [0.5, 1.0, 1.0, 1.5])
    assert over_target({**row, "path_wall_ms": [6.0, 6.0, 6.0, 12.0]})[1] == [1.0, 1.0, 1.0, 2.0]
    assert over_target({**row, "errors": [2e-3, 1e-3], "target": {"error": 1e-3}}) == ([2, 4], [2.0, 1.0])
