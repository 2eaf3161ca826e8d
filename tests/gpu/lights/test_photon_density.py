import numpy as np
import pytest
import warp as wp
from photons import photons_of, separations, two_sided_square
from scenes import column, grey, quad, resident_of, results

from gpu.clustering.grid import CLUSTERING_PARAMETERS, ClusteringParameters
from gpu.core.intrinsics import CUDA_LANES
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.disk_coverage import crossed
from gpu.device_scene.upload import DeviceScene
from gpu.lights.photon_density import (
    NEIGHBOURS,
    DensityParameters,
    PhotonSites,
    allocate_sites,
    covered_disk,
    disk_places,
    estimate_irradiance,
    times_mean,
)
from gpu.lights.photon_map import Photons
from gpu.lights.photon_tree import allocate_tree, build_tree
from gpu.scene.types import Floats

COUNT = 2000
FLUX = np.array([1.0, 2.0, 3.0], np.float32) / COUNT


@pytest.fixture(scope="module")
def square() -> DeviceScene:
    return resident_of([quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))], [grey(0.7)])


def estimated(scene: DeviceScene, photons: Photons, sites: "PhotonSites | None" = None, **chosen: float) -> PhotonSites:
    tree = allocate_tree(photons)
    build_tree(tree)
    sites = sites or allocate_sites(len(photons.flux), scene.device)
    sites.photon.assign(np.arange(len(photons.flux), dtype=np.int32))
    wp.copy(sites.count, photons.count)
    estimate_irradiance(scene.view(lambertian=True), tree, sites, parameters(DensityParameters, **chosen))
    return sites


def lit_square(count: int = COUNT) -> tuple[Floats, Floats, Photons]:
    positions, normals = two_sided_square(count)
    return positions, normals, photons_of(positions, normals, np.tile(FLUX, (count, 1)))


def test_irradiance_is_flux_over_area_up_to_the_edges(square: DeviceScene) -> None:
    positions, normals, photons = lit_square()
    sites = estimated(square, photons)
    irradiance = sites.irradiance.numpy()
    up = normals[:, 1] > 0.0
    for side in (up, ~up):
        assert irradiance[side].mean(axis=0) == pytest.approx(FLUX * side.sum(), rel=0.06)
    out = np.abs(positions[:, [0, 2]]).max(axis=1)
    rim = out > 0.45
    assert irradiance[rim, 0].mean() == pytest.approx(irradiance[~rim, 0].mean(), rel=0.1)
    free, radius = sites.free.numpy(), sites.radius.numpy()
    assert (free >= np.minimum(radius, 0.5 - out) - 1e-6).mean() > 0.99
    assert (free[rim] < 2.0 * (0.5 - out[rim]) + 0.3 * radius[rim]).mean() > 0.9


@wp.kernel
def times_mean_kernel(first: int, sites: PhotonSites, out: wp.array[float]) -> None:
    site = first + wp.tid()
    out[site] = times_mean(sites, sites.irradiance[site])


def test_the_mean_of_all_light_is_that_of_what_is_lit(square: DeviceScene) -> None:
    """Of a square in light of 1, a hundredth has as much again, and so half of all photons."""
    positions = np.random.default_rng(2).uniform(-0.5, 0.5, (8000, 3)) * (1.0, 0.0, 1.0)
    positions[4000:] *= 0.1
    photons = photons_of(positions, np.tile((0.0, 1.0, 0.0), (8000, 1)), np.full((8000, 3), 1.0 / 4000.0))
    sites = allocate_sites(8000, square.device)
    sites.flux.fill_(1.0 / 4000.0)
    sites = estimated(square, photons, sites)
    times = results(times_mean_kernel, 8000, [sites], float)
    assert np.median(times[:4000]) == pytest.approx(0.5, rel=0.1)
    assert np.median(times[4000:]) == pytest.approx(50.5, rel=0.1)


def test_a_site_answers_up_to_a_thin_wall_on_its_surface() -> None:
    """Of the few places of a disk that are looked at, those behind the wall may be far behind it."""
    floor = quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    wall = quad((0.0, 0.0, -0.5), (0.0, 0.0, 1.0), (0.0, 0.5, 0.0))
    positions, normals, photons = lit_square()
    device_scene = resident_of([floor, wall], [grey(0.7)])
    placement = device_scene.scene.placement
    photons.position.assign(((positions - placement.centre) * placement.scale).astype(np.float32))
    sites = estimated(device_scene, photons)
    away = np.abs(positions[:, 0]) * placement.scale
    free, radius = sites.free.numpy(), sites.radius.numpy()
    cut = (normals[:, 1] > 0.0) & (away < 0.7 * radius)
    assert cut.sum() > 50
    assert (free[cut] < 1.1 * away[cut]).mean() > 0.98


def test_inside_it_is_the_estimate_of_the_nearest(square: DeviceScene) -> None:
    positions, normals, photons = lit_square()
    sites = estimated(square, photons, own_share=0.25, most_radius=0.2)
    radius, irradiance = sites.radius.numpy(), sites.irradiance.numpy()
    inner = np.flatnonzero(np.abs(positions[:, [0, 2]]).max(axis=1) < 0.3)
    for photon in inner[::40]:
        away = separations(positions[photon], normals[photon], positions, normals)
        away[photon] = np.inf
        wanted = np.sort(away)[NEIGHBOURS - 1]
        assert radius[photon] == pytest.approx(wanted, rel=1e-4)
        assert irradiance[photon] == pytest.approx(FLUX * (NEIGHBOURS - 0.75) / (np.pi * wanted**2), rel=1e-3)


def test_few_photons_are_spread_over_the_widest_disk(square: DeviceScene) -> None:
    *_, photons = lit_square(3)
    sites = estimated(square, photons, most_radius=0.01)
    assert sites.radius.numpy() == pytest.approx(0.01)
    assert sites.irradiance.numpy() == pytest.approx(np.tile(0.5 * FLUX / (np.pi * 0.01**2), (3, 1)), rel=1e-3)


def test_few_photons_of_a_fleck_of_light_are_not_spread_over_what_is_dark_around(square: DeviceScene) -> None:
    """Fewer than an estimate takes, in a disk a sixth of the scene wide: its middle keeps more than half its light."""
    count, fleck = 24, 0.08
    turn, out = 2.4 * np.arange(count), fleck * np.sqrt((np.arange(count) + 0.5) / count)
    positions = np.stack([out * np.cos(turn), np.zeros(count), out * np.sin(turn)], axis=1)
    photons = photons_of(positions, np.tile((0.0, 1.0, 0.0), (count, 1)), np.full((count, 3), np.pi * fleck**2 / count))
    assert estimated(square, photons).irradiance.numpy()[:4, 0] == pytest.approx(1.0, abs=0.45)


def test_the_light_of_a_thin_strip_is_neither_lost_nor_a_bright_spot() -> None:
    """A slat, 0.3 radii of estimates wide, covers a fifth of their disks, of which few places are looked at."""
    count, width = 400, 0.012
    rng = np.random.default_rng(0)
    x, z = np.sort(rng.uniform(-0.5, 0.5, count)), rng.uniform(-0.5 * width, 0.5 * width, count)
    positions = np.stack([x, np.zeros(count), z], axis=1)
    photons = photons_of(positions, np.tile((0.0, 1.0, 0.0), (count, 1)), np.full((count, 3), width / count))
    slat = resident_of([quad((-0.5, 0.0, -0.5 * width), (0.0, 0.0, width), (1.0, 0.0, 0.0))], [grey(0.7)])
    irradiance = estimated(slat, photons).irradiance.numpy()
    assert irradiance.mean() == pytest.approx(1.0, abs=0.1)
    assert irradiance.max() < 2.7


def test_a_disk_off_its_surface_is_believed_to_be_the_least(square: DeviceScene) -> None:
    positions, normals, _ = lit_square(3)
    photons = photons_of(positions + np.float32([0.0, 0.3, 0.0]), normals, np.tile(FLUX, (3, 1)))
    sites = estimated(square, photons, most_radius=0.01, least_covered=0.2)
    assert sites.irradiance.numpy() == pytest.approx(np.tile(2.5 * FLUX / (np.pi * 0.01**2), (3, 1)), rel=1e-3)


@wp.kernel
def disk_kernel(first: int, lanes: int, scene: SceneData, alike: ClusteringParameters, position: wp.array[wp.vec3],
                radius: float, out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """What each of `lanes` threads of a disk that faces up sees of it, where no warp exchanges it."""
    index = first + wp.tid()
    point, lane = index // lanes, index % lanes
    up = wp.vec3(0.0, 1.0, 0.0)
    disk = covered_disk(scene, alike, position[point], up, radius, disk_places(point, 7), lane, lanes)
    beside = crossed(scene, position[point], up, radius, 0.1 * radius, lane, lanes)
    out[index] = wp.vec3(disk.share, disk.free, wp.where(beside, 1.0, 0.0))


def test_lanes_share_the_places_of_a_disk() -> None:
    floor = quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    wall = quad((0.0, 0.0, -0.5), (0.0, 0.0, 1.0), (0.0, 0.2, 0.0))
    scene = resident_of([floor, wall], [grey(0.7)])
    placement, out = scene.scene.placement, np.random.default_rng(5).uniform(-0.48, 0.48, (60, 2))
    points = np.stack([out[:, 0], np.zeros(60), out[:, 1]], axis=1)
    places = column((points - placement.centre) * placement.scale, wp.vec3)

    def seen(lanes: int) -> Floats:
        inputs = [lanes, scene.view(lambertian=True), CLUSTERING_PARAMETERS, places, 0.1]
        return results(disk_kernel, lanes * 60, inputs, wp.vec3).reshape(60, lanes, 3)

    one, each = seen(1)[:, 0], seen(CUDA_LANES)
    assert 10 < (one[:, 0] == 1.0).sum() < 50
    assert np.array_equal((each[..., 0] == 1.0).all(axis=1), one[:, 0] == 1.0)
    assert np.array_equal(each[..., 1].min(axis=1), one[:, 1])
    assert 5 < one[:, 2].sum() < 55
    assert np.array_equal(each[..., 2].max(axis=1), one[:, 2])
    assert (each[..., 1].max(axis=1) > one[:, 1])[one[:, 1] < 0.1].mean() > 0.9
