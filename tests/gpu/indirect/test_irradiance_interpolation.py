import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of

from gpu.clustering.grid import Grid
from gpu.clustering.points import Points
from gpu.core.device import allocate
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.gbuffer.point_list import PointList
from gpu.indirect.final_gather import Gathered
from gpu.indirect.irradiance_interpolation import (
    SAMPLES,
    InterpolationParameters,
    allocate_weights,
    interpolate_irradiance,
    weigh_centres,
)
from gpu.scene.scene_parts import MeshPart
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


@pytest.fixture(scope="module")
def floor() -> SceneData:
    return room_of()


def room_of(*kerbs: MeshPart) -> SceneData:
    """A floor just below points, and what stands on it."""
    floor = quad((-0.5, -0.01, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    return resident_of([floor, *kerbs], [grey(0.7)]).view(lambertian=True)


def kerb(x: float, height: float) -> MeshPart:
    """Of such a height above points, along z."""
    return quad((x, -0.01, -0.5), (0.0, 0.01 + height, 0.0), (0.0, 0.0, 1.0))


def gathered_of(irradiance: Floats, least: float | Floats = 0.0) -> Gathered:
    """What centres have: irradiance (centre, 3), and the length of shortest rays, of all or (centre,)."""
    gathered: Gathered = allocate(Gathered, len(irradiance), CPU)
    gathered.irradiance = column(irradiance, wp.vec3)
    gathered.least_distance = column(np.broadcast_to(least, len(irradiance)), float)
    return gathered


def interpolated(room: SceneData, centres: Floats, points: Floats, gathered: Gathered, **chosen: float) -> Floats:
    grid = Grid(len(centres), CPU)
    grid.data.position, grid.data.spacing = column(centres, wp.vec3), wp.full(len(centres), SPACING, device=CPU)
    grid.data.normal = column(np.tile(UP, (len(centres), 1)), wp.vec3)
    grid.build()
    sps, listed = Points(), PointList()
    sps.position, sps.normal = column(points, wp.vec3), column(np.tile(UP, (len(points), 1)), wp.vec3)
    sps.spacing, sps.count = wp.full(len(points), SPACING, device=CPU), column([len(points)], wp.int32)
    listed.pixels, listed.count = column(np.arange(len(points))[::-1], wp.int32), sps.count
    out = wp.zeros(len(points), dtype=wp.vec3, device=CPU)
    how = parameters(InterpolationParameters, **chosen)
    weights = allocate_weights(len(points), CPU)
    weigh_centres(room, sps, grid.data, gathered.least_distance, weights, how)
    interpolate_irradiance(listed, weights, gathered, out)
    return np.asarray(out.numpy())[::-1]


def test_it_is_wards_mean_of_the_centres_around(floor: SceneData, places: tuple[Floats, Floats]) -> None:
    centres, points = places
    rng = np.random.default_rng(1)
    irradiance, least = rng.uniform(size=(CENTRES, 3)), rng.uniform(0.005, 2.0, CENTRES)
    found = interpolated(floor, centres, points, gathered_of(irradiance, least))
    for point, light in zip(points, found, strict=True):
        away = np.linalg.norm(centres - point, axis=1)
        nearest = np.argsort(away)[:SAMPLES]
        weights = 1.0 / away[nearest]
        weights -= weights.min()
        assert light == pytest.approx(weights @ irradiance[nearest] / weights.sum(), rel=1e-3)


def test_even_light_stays_even_and_a_point_far_from_all_takes_the_nearest(
    floor: SceneData, places: tuple[Floats, Floats]
) -> None:
    centres, points = places
    even = interpolated(floor, centres, points, gathered_of(np.ones((CENTRES, 3))))
    assert even == pytest.approx(1.0, rel=1e-5)
    far = np.float32([[40.0, 0.0, 0.0]])
    light = np.arange(3.0 * CENTRES).reshape(CENTRES, 3)
    # Of all centres one in two is looked at, then.
    nearest = 2 * np.argmin(np.linalg.norm(centres[::2] - far, axis=1))
    assert interpolated(floor, centres, far, gathered_of(light), search=100)[0] == pytest.approx(light[nearest])


def test_points_far_from_all_find_a_centre_about_as_near_as_one_of_256_and_no_more_are_looked_at(
    floor: SceneData,
) -> None:
    rng = np.random.default_rng(2)
    centres, above = (rng.uniform(-0.5, 0.5, (count, 3)) * (1.0, 0.0, 1.0) for count in (4096, 1500))
    points = above + np.array([0.0, 3.0, 0.0])
    told = interpolated(floor, centres, points, gathered_of(centres))
    assert len(np.unique(told.round(5), axis=0)) <= 256
    # Of 256 on a unit square, the nearest is 1/32 away in the mean.
    assert np.linalg.norm(told - above, axis=1).mean() < 1.2 / 32.0


def told_of_one(room: SceneData, distance: float, least: float) -> float:
    """What a point is told by the one centre, so far from it along x."""
    centre, point = np.zeros((1, 3)), np.array([[distance, 0.0, 0.0]])
    dark = np.array([[distance, 0.0, 1.5 * distance]])
    light = np.array([[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]])
    gathered = gathered_of(light, least)
    return float(interpolated(room, np.concatenate([centre, dark]), point, gathered)[0, 0])


def test_a_centre_tells_nothing_across_a_kerb_whose_top_its_rays_pass_and_is_not_asked_in_the_open() -> None:
    """Of 256 rays, four meet a kerb a quarter as high as it is far, maybe 1.5 times as far away as that is."""
    away = 0.05
    assert told_of_one(room_of(kerb(away, 0.25 * away)), 1.2 * away, 1.5 * away) == pytest.approx(0.0)
    # Ripples of a floor, whose ceiling is 2.5 times as far as the point, hide nothing.
    assert told_of_one(room_of(kerb(0.5 * away, 0.04 * away)), away, 2.5 * away) > 0.5


def test_a_centre_in_the_open_does_not_outweigh_one_in_a_crack_beside_it(
    floor: SceneData, places: tuple[Floats, Floats]
) -> None:
    """A lit hall and a dark crack, half of the floor each, whose centres' shortest rays are of 30 and 0.1 spacings."""
    centres, points = places
    hall, in_hall = centres[:, 0] > 0.0, points[:, 0] > 0.0
    light = np.tile(hall[:, None], (1, 3))
    told = interpolated(floor, centres, points, gathered_of(light, np.where(hall, 30.0, 0.1) * SPACING))[:, 0]
    # In the mean over half of the floor, which is five spacings wide: both sides have alike of the other's light.
    spill = np.array([told[~in_hall].mean(), 1.0 - told[in_hall].mean()])
    assert spill.max() < 0.4 / 5.0
    assert spill.max() < 2.0 * spill.min()
