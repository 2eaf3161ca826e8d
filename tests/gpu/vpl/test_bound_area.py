import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls, radiosity_cache
from scenes import box, column, grey, quad, resident_of, results, square_of_vpls

from gpu.vpl.bound_area import BOUND_AREA_PARAMETERS, BoundAreas, areas_of, bound_area, bound_areas


@wp.kernel
def bound_kernel(first: int, bounds: BoundAreas, positions: wp.array[wp.vec3], out: wp.array[float]) -> None:
    """One thread a point of a surface that faces up: its A."""
    point = first + wp.tid()
    out[point] = bound_area(bounds, positions[point], wp.vec3(0.0, 1.0, 0.0))


@pytest.mark.parametrize("count", [900, 3600])
def test_bounds_have_the_area_of_two_vpls_where_there_are_any(count: int) -> None:
    floor = quad((-0.5, 0.0, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    device_scene = resident_of([floor, *box(0)], [grey(0.5)])
    lights = cluster_vpls(device_scene, square_of_vpls(count), 60, 0)
    bounds = bound_areas(radiosity_cache(device_scene, device_scene.data, lights))
    # The twelfth-nearest of a grid's points lies on a circle that holds 10 to 14 of their areas.
    assert np.median(areas_of(lights, bounds).numpy()) == pytest.approx(2.0 * 0.36 / count, rel=0.2)
    places = column([(0.05, 0.0, 0.05), (0.05, 0.4, 0.05)], wp.vec3)
    on, off = results(bound_kernel, 2, [bounds, places], float)
    assert on == pytest.approx(2.0 * 0.36 / count, rel=0.2)
    assert off == pytest.approx(1e-4)
    assert BOUND_AREA_PARAMETERS.vpl_areas == 2.0
