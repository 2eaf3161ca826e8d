import numpy as np
import pytest
from photons import lattice, photons_of, read_at, tree_of
from scenes import grey, quad, resident_of

from gpu.indirect.photon_lookup import FullMapLight, choose_sites
from gpu.lights.photon_tree import allocate_tree

FLOOR = [quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))]


@pytest.mark.parametrize(("count", "usual", "wanted"), [(7, None, [1, 5]), (12, None, [2, 6, 10]), (12, 8, [3, 9])])
def test_every_fourth_photon_is_a_site_or_as_many_as_there_is_room_for(
    count: int, usual: int | None, wanted: list[int]
) -> None:
    """How they answer is told in test_final_gather.py."""
    tree = allocate_tree(photons_of(np.zeros((12, 3)), np.zeros((12, 3)), np.zeros((12, 3))))
    tree.photons.count.fill_(count)
    sites = FullMapLight(tree, usual).lit.sites
    choose_sites(tree, sites)
    assert sites.photon.numpy()[: sites.count.numpy()[0]].tolist() == wanted


@pytest.mark.parametrize("count", [500, 2000])
def test_a_fleck_of_light_is_no_brighter_or_darker_for_its_edges(count: int) -> None:
    """What its photons bring is what is read all over the floor."""
    fleck = np.random.default_rng(1).uniform(-0.2, 0.2, (count, 3)) * (1.0, 0.0, 1.0)
    light = FullMapLight(tree_of(fleck, np.full(count, 1.0 / count)))
    floor = resident_of(FLOOR, [grey(0.7)])
    light.estimate(floor.view(lambertian=True))
    irradiance, _ = read_at(lattice(60), floor, 0.7, light)
    assert irradiance.mean() == pytest.approx(1.0, abs=0.07)


def test_all_of_a_bright_place_is_known() -> None:
    """Of points one in some hundred is not, where light is as elsewhere."""
    rng = np.random.default_rng(1)
    places = rng.uniform(-0.5, 0.5, (6000, 3)) * (1.0, 0.0, 1.0)
    places[3000:] *= 0.1
    light = FullMapLight(tree_of(places, np.ones(6000)))
    floor = resident_of(FLOOR, [grey(0.7)])
    light.estimate(floor.view(lambertian=True))
    within, without = (read_at(lattice(80) * share, floor, 0.7, light)[0][:, 0] for share in (0.098, 0.98))
    assert (within > 0.0).all()
    assert 0.9 < (without > 0.0).mean() < 0.999
