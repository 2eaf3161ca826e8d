import pytest
import warp as wp
from scenes import box, column, grey, quad, resident_of, results

from gpu.device_scene.data import SceneData
from gpu.device_scene.rays import occluded
from gpu.vpl.radiosity_reach import is_apart_of

is_apart = is_apart_of(occluded)


@wp.kernel
def apart_kernel(first: int, scene: SceneData, position: wp.array[wp.vec3], out: wp.array[int]) -> None:
    """One thread: whether the second point of a floor is apart from the first, which a ray from the third met."""
    up = wp.vec3(0.0, 1.0, 0.0)
    out[wp.tid()] = int(is_apart(scene, position[0], up, position[2], position[1], 0.1))


@pytest.mark.parametrize(
    ("height", "seen_from", "apart"),
    [(0.012, (0.0, 0.3), False), (0.03, (0.0, 0.3), True), (0.012, (0.0, 0.02), True), (0.012, (0.3, 0.02), True)],
)
def test_points_are_apart_where_a_slat_reaches_a_tenth_of_their_distance_or_half_as_high_as_the_ray(
    height: float, seen_from: tuple[float, float], apart: bool
) -> None:
    """They are 0.2 apart. Rays along a gap are no higher for being long. seen_from: how far along the slat, and up."""
    slat = quad((0.0, -0.5, -0.4), (0.0, 0.0, 0.8), (0.0, height, 0.0))
    scene = resident_of([*box(), slat], [grey(0.5)]).data
    along, up = seen_from
    places = column([(-0.1, -0.5, 0.0), (0.1, -0.5, 0.0), (-0.1, -0.5 + up, along)], wp.vec3)
    assert results(apart_kernel, 1, [scene, places], wp.int32)[0] == apart
