import numpy as np
import pytest
import warp as wp
from scenes import results

from gpu.core.parameters import parameters
from gpu.lights.sun_map import SunMapParameters, SunMaps, image_place, no_sun_maps, sun_maps, sun_place
from gpu.sampling.sobol import Pair, sobol_pair
from gpu.scene.types import Doubles

COUNT, SIDE = 1 << 14, 16


@wp.kernel
def sun_place_kernel(first: int, maps: SunMaps, light: int, out: wp.array[float]) -> None:
    """Column, row and density of each path's place."""
    path = first + wp.tid()
    place = sun_place(maps, light, sobol_pair(path, 0, 1), sobol_pair(path, 1, 1))
    out[3 * path] = place.point[0]
    out[3 * path + 1] = place.point[1]
    out[3 * path + 2] = place.density


def places(maps: SunMaps, light: int = 0) -> Doubles:
    """(path, 3): column, row, density."""
    return results(sun_place_kernel, COUNT, [maps, light], float, width=3).reshape(-1, 3)


def one_cell(row: int, column: int, **chosen: float) -> SunMaps:
    """Maps of two lights: of the second one cell was seen, of the first none."""
    seen = np.zeros((2, SIDE, SIDE), np.int32)
    seen[1, row, column] = 7
    return sun_maps(seen, wp.get_device("cpu"), parameters(SunMapParameters, side=SIDE, **chosen))


def test_most_paths_begin_where_light_was_seen_to_matter_and_next_to_it() -> None:
    place = places(one_cell(4, 11), 1)
    cell = np.floor((place[:, :2] + 1.0) * SIDE / 2.0)
    beside = (np.abs(cell - [11, 4]) <= 1).all(axis=1)
    anywhere = 0.3 * 9.0 * (4.0 / SIDE**2) / np.pi
    assert beside.mean() == pytest.approx(0.7 + anywhere, abs=0.005)
    assert np.hypot(*place[:, :2].T)[~beside].max() <= 1.0


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_densities_are_those_that_paths_have(share: float) -> None:
    maps = one_cell(7, 8, uniform_share=share)
    column, row, density = places(maps, 1).T
    # Weighed by what they are too many, paths lie as evenly as if they began anywhere alike.
    weight = 1.0 / density
    assert weight.mean() == pytest.approx(1.0, abs=0.01)
    for quadrant in (column > 0.0, row > 0.0, np.hypot(column, row) < np.sqrt(0.5)):
        assert (weight * quadrant).mean() == pytest.approx(0.5, abs=0.015)
    assert density.min() == pytest.approx(share)


def test_lights_of_which_nothing_was_seen_or_that_have_no_map_begin_anywhere() -> None:
    for maps, light in ((one_cell(3, 3), 0), (one_cell(3, 3), 2), (no_sun_maps(wp.get_device("cpu")), 0)):
        column, row, density = places(maps, light).T
        assert (density == 1.0).all()
        assert np.hypot(column, row).max() <= 1.0
        assert (np.hypot(column, row) < np.sqrt(0.5)).mean() == pytest.approx(0.5, abs=0.01)


@wp.kernel
def image_place_kernel(first: int, maps: SunMaps, light: int, side: int, out: wp.array[float]) -> None:
    """Column, row and density of the place of each pixel of an image."""
    pixel = first + wp.tid()
    within = Pair()
    within.x = (float(pixel % side) + 0.5) / float(side)
    within.y = (float(pixel // side) + 0.5) / float(side)
    place = image_place(maps, light, within)
    out[3 * pixel] = place.point[0]
    out[3 * pixel + 1] = place.point[1]
    out[3 * pixel + 2] = place.density


def image_of(maps: SunMaps, side: int = 128) -> Doubles:
    """(row, column, 3): column, row and density of pixels' places, of the second light."""
    inputs = [maps, 1, side]
    return results(image_place_kernel, side * side, inputs, float, width=3).reshape(side, side, 3)


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_images_have_most_pixels_where_light_was_seen_to_matter_and_keep_their_order(share: float) -> None:
    image = image_of(one_cell(7, 8, uniform_share=share))
    x, y, density = np.moveaxis(image, 2, 0)
    assert (np.diff(x, axis=1) > 0.0).all()
    assert (np.diff(y, axis=0) >= 0.0).all()
    cell = np.floor((image[..., :2] + 1.0) * SIDE / 2.0)
    beside = (np.abs(cell - [8, 7]) <= 1).all(axis=2)
    assert beside.mean() == pytest.approx(1.0 - share + share * 9.0 / SIDE**2, abs=0.02)
    # Weighed, the pixels that meet the disk lie in it as evenly as if they began anywhere alike.
    weight = (np.hypot(x, y) <= 1.0) / density
    assert weight.mean() == pytest.approx(1.0, abs=0.02)
    for half in (x > 0.0, y > 0.0, np.hypot(x, y) < np.sqrt(0.5)):
        assert (weight * half).mean() == pytest.approx(0.5, abs=0.02)


def test_an_image_without_a_map_has_the_disk_alike() -> None:
    x, y, density = np.moveaxis(image_of(no_sun_maps(wp.get_device("cpu"))), 2, 0)
    assert (density == 1.0).all()
    assert np.hypot(x, y).max() <= 1.0
