import numpy as np
import pytest
from glass import bulb, mirror_over_floor
from scenes import trace_light_paths

from gpu.lights.build import build_light_table

PATHS = 1 << 14


def test_light_goes_on_from_a_mirror_to_what_scatters_it() -> None:
    room = mirror_over_floor(bulb(0.0, -0.3, 0.0))
    vpls = trace_light_paths(room, room.data, build_light_table(room), PATHS, 2, 0)
    positions, bounce, flux = vpls.position.numpy(), vpls.bounce.numpy(), vpls.flux.numpy()[:, 0]
    on_mirror = (np.abs(positions[:, 1]) < 1e-4) & (np.abs(positions[:, [0, 2]]).max(axis=1) < 0.1)
    assert (bounce[on_mirror] == 1).all()  # of what the walls send
    share = np.arcsin(0.1**2 / (0.1**2 + 0.3**2)) / np.pi
    first = (bounce == 0).sum() / PATHS
    assert first == pytest.approx(1.0 - share, abs=0.003)
    lit = (bounce == 1) & (np.abs(positions[:, [0, 2]]).max(axis=1) < 0.27) & (positions[:, 1] < -0.49)
    # Walls light that part of the floor, too.
    assert flux[lit].sum() > 0.5 * 4.0 * np.pi * share
