import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.clustering.grid import Grid
from gpu.core.device import allocate
from gpu.indirect.centre_smoothing import smooth_centres
from gpu.indirect.final_gather import Gathered
from gpu.scene.types import Floats

CPU, SIDE = wp.get_device("cpu"), 20
NOISE = 0.1


def smoothed(irradiance: Floats) -> Floats:
    """What centres in a square lattice have then, of irradiance (SIDE, SIDE) with NOISE."""
    along = (np.arange(SIDE) + 0.5) / SIDE - 0.5
    x, z = np.meshgrid(along, along)
    grid = Grid(SIDE * SIDE, CPU)
    grid.data.position = column(np.stack([x.ravel(), np.zeros(SIDE * SIDE), z.ravel()], axis=1), wp.vec3)
    grid.data.normal = column(np.tile((0.0, 1.0, 0.0), (SIDE * SIDE, 1)), wp.vec3)
    grid.data.spacing = wp.full(SIDE * SIDE, 1.0 / SIDE, device=CPU)
    grid.build()
    gathered: Gathered = allocate(Gathered, SIDE * SIDE, CPU)
    gathered.irradiance = column(np.repeat(irradiance.reshape(-1, 1), 3, axis=1), wp.vec3)
    gathered.variance.fill_(NOISE**2)
    smooth_centres(grid.data, gathered, wp.zeros(SIDE * SIDE, dtype=wp.vec3, device=CPU))
    return gathered.irradiance.numpy()[:, 0].reshape(SIDE, SIDE)


def test_noise_is_less_and_edges_stay() -> None:
    wanted = np.where(np.arange(SIDE) < SIDE // 2, 1.0, 3.0) * np.ones((SIDE, 1))
    noise = np.random.default_rng(0).normal(0.0, NOISE, (SIDE, SIDE))
    left = smoothed(wanted + noise) - wanted
    assert left.std() < 0.8 * noise.std()
    assert left.mean() == pytest.approx(noise.mean(), abs=0.01)
