import numpy as np
import pytest
from photons import STRETCH, lattice, photons_of, read_at, tree_of, two_sided_square
from scenes import grey, quad, resident_of

from gpu.device_scene.upload import DeviceScene
from gpu.indirect.cut_lookup import CutLight
from gpu.lights.photon_density import NEIGHBOURS
from gpu.lights.photon_tree import allocate_tree, build_tree
from gpu.scene.types import Floats

COUNT, POINTS, ALBEDO = 2000, 40, 0.7


@pytest.fixture(scope="module")
def floor() -> DeviceScene:
    return resident_of([quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))], [grey(ALBEDO)])


def weighted(light: CutLight, position: Floats, normal: Floats) -> Floats:
    """Eq. 4 and 5 over all nodes of the cut that answer there."""
    lit, photons = light.lit, light.lit.tree.photons
    count = light.cut.nodes.count.numpy()[0]
    photon, node = lit.sites.photon.numpy()[:count], light.cut.nodes.node.numpy()[:count]
    nodes = lit.tree.nodes.numpy()[node]
    sides = (nodes["upper"] - nodes["lower"]).max(axis=1)
    radius = lit.sites.radius.numpy()[:count]
    own = COUNT / 2.0 ** light.cut.nodes.level.numpy()[:count]
    widest = lit.chosen.most_radii * radius * np.sqrt(np.maximum(own / NEIGHBOURS, 1.0))
    reach = np.minimum(lit.chosen.reach * np.clip(sides, radius, widest), lit.chosen.most_reach)
    normals = photons.normal.numpy()[photon]
    way = photons.position.numpy()[photon] - position
    plane = np.maximum(np.abs(way @ normal), np.abs((way * normals).sum(axis=1)))
    share = np.sqrt((way**2).sum(axis=1) + (STRETCH**2 - 1.0) * plane**2) / reach
    open_way = np.linalg.norm(way, axis=1) < lit.free.numpy()[:count]
    weight = np.where(open_way, np.maximum(1.0 - share**2, 0.0) * np.maximum(normals @ normal, 0.0), 0.0)
    return weight @ lit.sites.irradiance.numpy()[:count] / max(weight.sum(), 1e-12)


def test_a_ray_reads_the_mean_of_the_nodes_around(floor: DeviceScene) -> None:
    """From close to the surface, so that it ends below where it begins."""
    positions, normals = two_sided_square(COUNT)
    rng = np.random.default_rng(3)
    tree = allocate_tree(photons_of(positions, normals, rng.uniform(size=(COUNT, 3))))
    build_tree(tree)
    light = CutLight(tree, 256)
    light.estimate(floor.view(lambertian=True))
    places = rng.uniform(-0.45, 0.45, (POINTS, 3)) * (1.0, 0.0, 1.0)
    told, places = read_at(places, floor, ALBEDO, light)
    assert len(places) > 0.8 * POINTS
    wanted = np.stack([weighted(light, place, np.float32([0.0, 1.0, 0.0])) for place in places])
    assert told == pytest.approx(wanted, rel=0.03)
    assert wanted.max() > 1.2 * wanted.min()


def read_of(photons: Floats, floor: DeviceScene) -> Floats:
    """Irradiance all over a floor of `photons` (photon, 3), which bring 1 W, read of a cut of 256 nodes."""
    light = CutLight(tree_of(photons, np.full(len(photons), 1.0 / len(photons))), 256)
    light.estimate(floor.view(lambertian=True))
    return read_at(lattice(60), floor, ALBEDO, light)[0][:, 0]


@pytest.fixture(scope="module")
def strewn() -> Floats:
    return np.random.default_rng(1).uniform(-0.5, 0.5, (COUNT, 3)) * (1.0, 0.0, 1.0)


def test_even_light_is_smooth_and_spreads_beyond_its_edge_by_less_than_a_quarter(
    strewn: Floats, floor: DeviceScene
) -> None:
    everywhere = read_of(strewn, floor)
    known = everywhere > 0.0  # all but the rim
    assert known.mean() > 0.95
    everywhere = everywhere[known]
    assert everywhere.mean() == pytest.approx(1.0, abs=0.05)
    assert everywhere.std() < 0.12  # that of one estimate, of 32 photons, is 0.18
    half = strewn * (0.5, 1.0, 1.0) - (0.25, 0.0, 0.0)
    assert read_of(half, floor).mean() < 1.25


def test_nodes_tell_nothing_of_what_is_half_of_their_width_above_them(strewn: Floats, floor: DeviceScene) -> None:
    """Shelves do not light each other. Nodes are 0.1 wide."""
    assert not read_of(strewn - np.array([0.0, 0.05, 0.0]), floor).any()
