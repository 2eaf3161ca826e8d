import numpy as np
import pytest
import warp as wp
from photons import lattice, photons_of, read_at, tree_of
from scenes import grey, quad, resident_of

from gpu.indirect.photon_lookup import FullMapLight, choose_every_photon, full_map
from gpu.lights.photon_density import DENSITY_PARAMETERS, allocate_sites
from gpu.lights.photon_tree import allocate_tree


def test_all_photons_there_are_are_sites() -> None:
    """How they answer is told in test_final_gather.py."""
    tree = allocate_tree(photons_of(np.zeros((9, 3)), np.zeros((9, 3)), np.zeros((9, 3))))
    tree.photons.count.fill_(7)
    sites = allocate_sites(9, wp.get_device("cpu"))
    choose_every_photon(tree, sites)
    assert sites.count.numpy()[0] == 7
    assert sites.photon.numpy().tolist() == list(range(9))
    assert full_map(tree, sites).most_radius == np.float32(DENSITY_PARAMETERS.most_radius)


@pytest.mark.parametrize("count", [500, 2000])
def test_a_fleck_of_light_is_no_brighter_or_darker_for_its_edges(count: int) -> None:
    """What its photons bring is what is read all over the floor."""
    fleck = np.random.default_rng(1).uniform(-0.2, 0.2, (count, 3)) * (1.0, 0.0, 1.0)
    light = FullMapLight(tree_of(fleck, np.full(count, 1.0 / count)))
    floor = resident_of([quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))], [grey(0.7)])
    light.estimate(floor.view(lambertian=True))
    irradiance, _ = read_at(lattice(60), floor, 0.7, light)
    assert irradiance.mean() == pytest.approx(1.0, abs=0.07)
