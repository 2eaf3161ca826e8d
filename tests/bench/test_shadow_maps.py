from pathlib import Path

import numpy as np

from gpu.device_scene.upload import DeviceScene
from gpu.scene.load import load_scene
from tests.bench.shadow_maps import frames_of, set_bulb
from tests.bench.subjects import Subject
from tests.bench.suite import Suite


def test_a_bulb_moves_in_the_table_while_the_camera_rests(tmp_path: Path, cpu: str) -> None:
    suite = Suite(out=tmp_path, cache=tmp_path, device=cpu, quick=True)
    subject = Subject("cornell-box", load_scene("cornell-box"), (8, 6), cpu, None, tmp_path, 1)
    light_sets, path, lit = frames_of(suite, subject, moves=True)
    assert isinstance(lit.device_scene, DeviceScene)
    cameras, bulbs = zip(*path, strict=True)
    assert all(camera is subject.camera for camera in cameras)
    set_bulb(light_sets, bulbs[-1])
    assert np.allclose(light_sets.table.lights.numpy()[-1]["position"], bulbs[-1].position)
    assert np.ptp([bulb.position[0] for bulb in bulbs]) > 0.0
