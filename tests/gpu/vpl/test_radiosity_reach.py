import pytest
import warp as wp
from scenes import box, column, grey, quad, resident_of, results

from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import occluded
from gpu.vpl.radiosity_reach import is_apart_of

is_apart = is_apart_of(occluded)


@wp.kernel
def apart_kernel(first: int, scene: SceneData, position: wp.array[wp.vec3], distance: float,
                 out: wp.array[int]) -> None:  # fmt: skip
    """One thread: whether the second point of a floor is apart from the first, which a ray of `distance` met."""
    up = wp.vec3(0.0, 1.0, 0.0)
    out[wp.tid()] = int(is_apart(scene, position[0], up, distance, position[1], 0.1))


@pytest.mark.parametrize(("height", "distance", "apart"), [(0.012, 0.3, False), (0.03, 0.3, True), (0.012, 0.02, True)])
def test_points_are_apart_where_a_slat_reaches_a_tenth_of_their_distance_or_half_the_rays(
    height: float, distance: float, apart: bool
) -> None:
    """They are 0.2 apart."""
    slat = quad((0.0, -0.5, -0.4), (0.0, 0.0, 0.8), (0.0, height, 0.0))
    scene = resident_of([*box(), slat], [grey(0.5)]).data
    places = column([(-0.1, -0.5, 0.0), (0.1, -0.5, 0.0)], wp.vec3)
    assert results(apart_kernel, 1, [scene, places, distance], wp.int32)[0] == apart
