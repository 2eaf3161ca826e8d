from pathlib import Path

import numpy as np
import pytest

from gpu.device_scene.upload import DeviceScene
from gpu.scene.load import load_scene
from tests.bench.shadow_maps import MOVES, frames_of, set_bulb
from tests.bench.subjects import Subject
from tests.bench.suite import Suite


@pytest.mark.parametrize("moves", MOVES)
def test_a_bulb_and_the_camera_move_as_they_are_to(moves: str, tmp_path: Path, cpu: str) -> None:
    suite = Suite(out=tmp_path, cache=tmp_path, device=cpu, quick=True)
    subject = Subject("cornell-box", load_scene("cornell-box"), (8, 6), cpu, None, tmp_path, 1)
    light_sets, path, lit = frames_of(suite, subject, moves)
    assert isinstance(lit.device_scene, DeviceScene)
    cameras, bulbs = zip(*path, strict=True)
    assert (len({camera.view_key for camera in cameras}) > 1) == (moves != "bulb")
    assert (len({bulb.position for bulb in bulbs}) > 1) == (moves != "camera")
    set_bulb(light_sets, bulbs[-1])
    assert np.allclose(light_sets.table.lights.numpy()[-1]["position"], bulbs[-1].position)
