import numpy as np
import pytest
import warp as wp
from photons import tree_of
from scenes import column, grey, quad, resident_of, results

from gpu.indirect.bright_photons import BrightPhotons, allocate_bright, draw_bright, find_bright, ray_share
from gpu.indirect.photon_lookup import FullMapLight
from gpu.scene.types import Floats

RAYS, COUNT, SIDE = 64, 8000, 0.05
CENTRE = (0.2, 0.0, -0.1)


def floor_light(share: float) -> tuple[FullMapLight, Floats, BrightPhotons]:
    """A floor of one square metre in light of 1 W, and as much of `share` watts on a small square of it; its photons'
    positions, and those of them that are bright.
    """
    rng = np.random.default_rng(3)
    few = int(share * COUNT)
    places = rng.uniform(-0.5, 0.5, (COUNT + few, 3)) * (1.0, 0.0, 1.0)
    places[COUNT:] = places[COUNT:] * SIDE + CENTRE
    light = FullMapLight(tree_of(places, np.full(len(places), 1.0 / COUNT)))
    light.estimate(resident_of([quad((-0.5, 0.0, -0.5), (0, 0, 1), (1, 0, 0))], [grey(0.7)]).view(lambertian=True))
    bright = allocate_bright(light, RAYS)
    find_bright(light, bright)
    return light, light.lit.tree.photons.position.numpy(), bright


@wp.kernel
def draw_kernel(first: int, bright: BrightPhotons, out: wp.array[int]) -> None:
    index = first + wp.tid()
    out[index] = draw_bright(bright, wp.uint32(index) << wp.uint32(20))


@wp.kernel
def share_kernel(first: int, bright: BrightPhotons, ratio: float, irradiance: wp.array[float], way: wp.array[wp.vec3],
                 out: wp.array[float]) -> None:  # fmt: skip
    index = first + wp.tid()
    light = wp.vec3(irradiance[index], irradiance[index], irradiance[index])
    down, up = wp.vec3(0.0, -1.0, 0.0), wp.vec3(0.0, 1.0, 0.0)
    out[index] = ray_share(bright, light, way[index], down, up, ratio)


def test_photons_are_drawn_where_light_is_densest_alone() -> None:
    """There it is 201 times what is all around, and a quarter of that as the mean of both would be."""
    _, positions, bright = floor_light(0.5)
    drawn = positions[results(draw_kernel, 4096, [bright], int).astype(int)]
    assert np.abs(drawn - CENTRE).max() < 0.8 * SIDE
    assert drawn.mean(axis=0) == pytest.approx(CENTRE, abs=0.1 * SIDE)
    assert drawn[:, 0].std() == pytest.approx(SIDE / np.sqrt(12.0), rel=0.1)


def test_even_light_has_none_that_are_bright() -> None:
    *_, bright = floor_light(0.0)
    assert not bright.totals.numpy().any()
    assert results(share_kernel, 1, [bright, 0.1, column([1e6], float), column([[0, -1, 0]], wp.vec3)], float) == 1.0


def test_a_ray_counts_by_how_often_both_ways_draw_it() -> None:
    *_, bright = floor_light(0.5)
    ways = np.array([[0.0, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, -0.02, 0.0], [0.0, -0.5, 0.0]])
    light, ratio = np.array([200.0, 200.0, 200.0, 2.0]), 0.125
    shares = results(share_kernel, 4, [bright, ratio, column(light, float), column(ways, wp.vec3)], float)
    squared = (ways**2).sum(axis=1)
    cosine = np.abs(ways[:, 1]) / np.sqrt(squared)
    by_cosine, towards = cosine / np.pi, light / 0.5 * squared / cosine
    wanted = by_cosine / (by_cosine + ratio * towards)
    assert shares[:3] == pytest.approx(wanted[:3], rel=0.1)
    assert shares[3] == 1.0
