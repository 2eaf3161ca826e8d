from itertools import pairwise

import numpy as np

from gpu.adaptive.levels import Level
from gpu.methods.steering import Steering, swayed
from gpu.scene.camera import look_at
from gpu.scene.types import Camera


def view_direction(camera: Camera) -> np.ndarray:
    return -camera.to_world[:3, 2]


def degrees_between(one: Camera, other: Camera) -> float:
    return float(np.degrees(np.arccos(np.clip(view_direction(one) @ view_direction(other), -1.0, 1.0))))


def test_a_camera_that_sways_turns_as_fast_as_walkers_and_sees_much_the_same() -> None:
    camera = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5))
    cameras = [swayed(camera, number) for number in range(32)]
    turns = [degrees_between(before, after) for before, after in pairwise(cameras)]
    assert 0.7 < np.mean(turns) < 1.4
    assert max(turns) < 2.0
    assert 3.0 < max(degrees_between(camera, each) for each in cameras) < 5.0


def test_frames_of_a_walk_with_other_lights_tell_nothing_until_they_are_alike() -> None:
    """A light set's first three frames have new clusters; other SP clusters are alike from the second frame on."""

    def unlike(level: Level, *, walks: bool = True) -> int:
        steering = Steering(Level(1000, 100), None)
        steering.begin_frame(walks=walks)
        steering.change(level, walks=walks, retries=False)
        frames = 0
        while steering.unlike > 0:
            frames += 1
            steering.begin_frame(walks=walks)
        return frames

    assert 3 <= unlike(Level(1000, 128)) <= 6
    assert unlike(Level(1100, 100)) == 1
    assert unlike(Level(1000, 128), walks=False) == unlike(Level(1000, 100, passes=2.0)) == 0


def test_another_try_has_the_lights_of_the_one_before() -> None:
    for level, is_retry in (Level(1100, 100), True), (Level(1000, 128), False):
        steering = Steering(Level(1000, 100), None)
        steering.begin_frame(walks=True)
        steering.change(level, walks=True, retries=True)
        assert (steering.level, steering.is_retry) == (level, is_retry)
        steering.begin_frame(walks=True)
        assert not steering.is_retry


def test_what_single_frames_of_the_host_take_is_not_believed() -> None:
    """Six hiccups in a row, a tenth of a second, change nothing; what ten frames take does."""
    steering = Steering(Level(1000, 100), None)
    for _ in range(60):
        assert steering.host_time(2.0, walks=True) <= 2.0
    assert {steering.host_time(9.0, walks=True) for _ in range(6)} == {2.0}
    assert [steering.host_time(9.0, walks=True) for _ in range(4)][-1] == 9.0
    assert steering.host_time(None, walks=True) == 9.0
    assert steering.host_time(None, walks=False) == 0.0
    steering.learning_ms = 1.0
    assert steering.host_time(None, walks=False) == 0.0
    assert [steering.host_time(2.0, walks=False) for _ in range(60)][-1] == 3.0
