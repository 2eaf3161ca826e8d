from itertools import pairwise

import numpy as np
import pytest
import warp as wp

from gpu.core.device import allocate
from gpu.indirect.gather_rays import RayEnds, coherent_order, list_unknown


@pytest.mark.parametrize(("rays", "slices"), [(1, 1), (40, 1), (256, 8), (500, 8)])
def test_rays_of_one_slice_follow_each_other(rays: int, slices: int) -> None:
    order = coherent_order(rays)
    assert sorted(order) == list(range(rays))
    changes = [one % slices != other % slices for one, other in pairwise(order)]
    assert sum(changes) == slices - 1


def test_rays_of_which_nothing_is_known_are_listed_in_order() -> None:
    """How they are traced is told in test_final_gather.py."""
    unknown = np.random.default_rng(0).integers(0, 2, 3000).astype(np.int32)
    ends = allocate(RayEnds, len(unknown), wp.get_device("cpu"))
    ends.unknown.assign(unknown)
    list_unknown(ends)
    count = ends.totals.numpy()[-1]
    assert ends.listed.numpy()[:count].tolist() == np.flatnonzero(unknown).tolist()
