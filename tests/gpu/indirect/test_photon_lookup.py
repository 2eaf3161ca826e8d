import numpy as np
import warp as wp
from photons import photons_of

from gpu.indirect.photon_lookup import choose_every_photon, full_map
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
