import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of

from gpu.clustering.grid import Grid
from gpu.clustering.points import Points
from gpu.core.device import allocate
from gpu.core.parameters import parameters
from gpu.gbuffer.point_list import PointList
from gpu.indirect.final_gather import Gathered
from gpu.indirect.irradiance_interpolation import SAMPLES, InterpolationParameters, interpolate_irradiance
from gpu.scene.types import Floats

CPU = wp.get_device("cpu")
CENTRES, POINTS, SPACING = 120, 200, 0.1
UP = (0.0, 1.0, 0.0)


@pytest.fixture(scope="module")
def places() -> tuple[Floats, Floats]:
    """Positions of centres and of points on a unit square."""
    rng = np.random.default_rng(0)
    flat = rng.uniform(-0.5, 0.5, (CENTRES + POINTS, 3)) * (1.0, 0.0, 1.0)
    return flat[:CENTRES].astype(np.float32), flat[CENTRES:].astype(np.float32)


def interpolated(centres: Floats, points: Floats, irradiance: Floats, distance: Floats, **chosen: float) -> Floats:
    grid = Grid(len(centres), CPU)
    grid.data.position, grid.data.spacing = column(centres, wp.vec3), wp.full(len(centres), SPACING, device=CPU)
    grid.data.normal = column(np.tile(UP, (len(centres), 1)), wp.vec3)
    grid.build()
    gathered = allocate(Gathered, len(centres), CPU)
    gathered.irradiance, gathered.harmonic_distance = column(irradiance, wp.vec3), column(distance, float)
    sps, listed = Points(), PointList()
    sps.position, sps.normal = column(points, wp.vec3), column(np.tile(UP, (len(points), 1)), wp.vec3)
    sps.spacing, sps.count = wp.full(len(points), SPACING, device=CPU), column([len(points)], wp.int32)
    listed.pixels, listed.count = column(np.arange(len(points))[::-1], wp.int32), sps.count
    out = wp.zeros(len(points), dtype=wp.vec3, device=CPU)
    floor = quad((-0.5, -0.01, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    room = resident_of([floor], [grey(0.7)]).view(lambertian=True)
    interpolate_irradiance(room, sps, listed, grid.data, gathered, out, parameters(InterpolationParameters, **chosen))
    return np.asarray(out.numpy())[::-1]


def test_it_is_wards_mean_of_the_centres_around(places: tuple[Floats, Floats]) -> None:
    centres, points = places
    rng = np.random.default_rng(1)
    irradiance, distance = rng.uniform(size=(CENTRES, 3)), rng.uniform(0.005, 2.0, CENTRES)
    chosen = InterpolationParameters.cls()
    means = np.clip(distance, chosen.least_distance * SPACING, chosen.most_distance * SPACING)
    found = interpolated(centres, points, irradiance, distance)
    for point, light in zip(points, found, strict=True):
        away = np.linalg.norm(centres - point, axis=1)
        nearest = np.argsort(away)[:SAMPLES]
        weights = means[nearest] / away[nearest]
        weights -= weights.min()
        assert light == pytest.approx(weights @ irradiance[nearest] / weights.sum(), rel=1e-3)


def test_even_light_stays_even_and_a_point_far_from_all_takes_the_nearest(places: tuple[Floats, Floats]) -> None:
    centres, points = places
    even = interpolated(centres, points, np.ones((CENTRES, 3)), np.ones(CENTRES))
    assert even == pytest.approx(1.0, rel=1e-5)
    far = np.float32([[40.0, 0.0, 0.0]])
    light = np.arange(3.0 * CENTRES).reshape(CENTRES, 3)
    # Of all centres one in two is looked at, then.
    nearest = 2 * np.argmin(np.linalg.norm(centres[::2] - far, axis=1))
    assert interpolated(centres, far, light, np.ones(CENTRES), search=100)[0] == pytest.approx(light[nearest])
