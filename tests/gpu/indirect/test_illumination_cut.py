import numpy as np
import pytest
from photons import lattice, photons_of, read_at, tree_of, two_sided_square
from scenes import grey, quad, resident_of

from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.cut_lookup import CutLight
from gpu.indirect.illumination_cut import CutParameters, IlluminationCut
from gpu.lights.photon_tree import allocate_tree, build_tree
from gpu.scene.types import Floats

COUNT = 3000


@pytest.fixture(scope="module")
def floor() -> DeviceScene:
    return resident_of([quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))], [grey(0.7)])


@pytest.fixture(scope="module")
def square(floor: DeviceScene) -> SceneData:
    return floor.view(lambertian=True)


def cut_of(square: SceneData, fluxes: Floats, size: int, **chosen: float) -> IlluminationCut:
    positions, normals = two_sided_square(len(fluxes))
    tree = allocate_tree(photons_of(positions, normals, np.repeat(fluxes[:, None], 3, axis=1)))
    build_tree(tree)
    cut = IlluminationCut(tree, size, parameters(CutParameters, **chosen))
    cut.choose(square)
    return cut


def listed(cut: IlluminationCut) -> tuple[list[int], list[int]]:
    count = cut.nodes.count.numpy()[0]
    return cut.nodes.node.numpy()[:count].tolist(), cut.nodes.level.numpy()[:count].tolist()


def coarse_cut(cut: IlluminationCut) -> set[int]:
    """The nodes of the paper's coarse cut, by its words."""
    tree, deepest = cut.tree, cut.size.bit_length() - 2
    nodes = tree.nodes.numpy()
    sides = np.maximum(nodes["upper"] - nodes["lower"], 0.0).max(axis=1)
    approximate = np.linalg.norm(tree.flow.numpy(), axis=1) / np.maximum(sides**2, 1e-12)
    nodes = range(1, 2 << deepest)
    least = approximate[1 << deepest : 2 << deepest].mean()
    bright = {node for node in nodes if approximate[node] > least}
    above = {node >> up for node in bright for up in range(1, node.bit_length())}
    return {node for node in nodes if node not in above and (node == 1 or node // 2 in above)}


@pytest.mark.parametrize("dark_half", [False, True])
def test_unless_it_is_refined_it_is_the_coarse_cut(square: SceneData, dark_half: bool) -> None:
    fluxes = np.ones(COUNT, np.float32)
    fluxes[: COUNT // 2] = 0.01 if dark_half else 1.0
    cut = cut_of(square, fluxes, 256, max_change=1e9)
    nodes, levels = listed(cut)
    assert set(nodes) == coarse_cut(cut)
    assert levels == [node.bit_length() - 1 for node in nodes]
    if dark_half:  # one side is dark, and in few nodes
        assert sum(node >> (level - 1) == 2 for node, level in zip(nodes, levels, strict=True)) < 0.2 * len(nodes)


def test_rounds_split_what_its_box_does_not_tell_as_long_as_there_is_room(square: SceneData) -> None:
    fluxes = np.ones(COUNT, np.float32)
    sizes = {
        (size, change): len(listed(cut_of(square, fluxes, size, max_change=change))[0])
        for size, change in ((256, 1e9), (256, 0.0), (1024, 0.3), (1024, 0.6))
    }
    assert sizes[256, 1e9] <= 128
    assert sizes[256, 0.0] == 256
    assert sizes[1024, 0.6] < sizes[1024, 0.3] < 1024


def test_nodes_cover_all_photons_once_and_sites_are_theirs(square: SceneData) -> None:
    cut = cut_of(square, np.ones(COUNT, np.float32), 1024, max_change=0.4)
    covered = np.zeros(COUNT, int)
    for node, level, photon in zip(*listed(cut), cut.sites.photon.numpy().tolist(), strict=False):
        number = node - (1 << level)
        begin, end = number * COUNT >> level, (number + 1) * COUNT >> level
        covered[begin:end] += 1
        assert photon == (begin + end) // 2
    assert (covered == 1).all()
    count = cut.nodes.count.numpy()[0]
    assert cut.sites.irradiance.numpy()[:count, 0].mean() == pytest.approx(COUNT / 2, rel=0.1)


def read_of(floor: DeviceScene, radius: float) -> tuple[IlluminationCut, Floats]:
    """A cut of up to 256 nodes for nine flecks of light of such a radius, with a tenth of that light between them, and
    what is read of it there, where anything tells of it.
    """
    rng = np.random.default_rng(1)
    middles = 0.31 * np.stack(np.meshgrid((-1, 0, 1), (-1, 0, 1)), axis=-1).reshape(-1, 2)
    middles += rng.uniform(-0.04, 0.04, (9, 2))

    def light_at(places: Floats) -> Floats:
        away = np.linalg.norm(places[:, None, [0, 2]] - middles, axis=2).min(axis=1)
        return np.where(away < radius, 1.0, 0.1)

    photons = lattice(64) + rng.uniform(-0.15 / 64, 0.15 / 64, (64 * 64, 3)) * (1.0, 0.0, 1.0)
    light = CutLight(tree_of(photons, light_at(photons) / 64**2), 256)
    light.estimate(floor.view(lambertian=True))
    told, places = read_at(lattice(60), floor, 0.7, light)
    known = told[:, 0] > 0.0  # all but the rim
    assert known.mean() > 0.9
    return light.cut, told[known & (light_at(places) < 1.0), 0]


def test_even_light_takes_less_than_half_of_the_nodes_and_is_told_right(floor: DeviceScene) -> None:
    cut, told = read_of(floor, 0.0)
    assert cut.nodes.count.numpy()[0] < 128
    assert told.mean() == pytest.approx(0.1, rel=0.02)
    assert told.std() < 0.005


def test_light_of_small_flecks_makes_what_is_between_them_little_brighter(floor: DeviceScene) -> None:
    _, told = read_of(floor, 0.07)
    assert told.mean() < 1.9 * 0.1
