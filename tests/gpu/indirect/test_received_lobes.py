import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.device_scene.even_light import even_reflectance
from gpu.device_scene.features import EVERYTHING
from gpu.gbuffer.gbuffer import GBuffer, allocate_gbuffer, surface_of
from gpu.indirect.received_lobes import received_by_lobe
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.scene.types import Doubles

COUNT = 1 << 12


@wp.kernel
def even_kernel(first: int, gbuffer: GBuffer, out: wp.array[wp.vec3]) -> None:
    surface = surface_of(gbuffer, 0)
    out[first + wp.tid()] = even_reflectance(surface, gbuffer.to_camera[0])


@wp.kernel
def shown_kernel(first: int, gbuffer: GBuffer, out: wp.array[wp.vec2]) -> None:
    """(share, whether light comes from the other side of the normal than the camera) of directions by their cosine."""
    index = first + wp.tid()
    place = sobol_pair(index, 0, 1)
    to_light = cosine_direction(gbuffer.normal[0], place.x, place.y)
    opposite = wp.where(wp.dot(to_light, gbuffer.to_camera[0]) < 0.0, 1.0, 0.0)
    out[index] = wp.vec2(received_by_lobe(gbuffer, 0, to_light)[0], opposite)


def shown(diffuse: float, roughness: float, f90: float = 1.0, through: float = 0.0) -> Doubles:
    """What `shown_kernel` tells of a surface that is seen askew."""
    gbuffer = allocate_gbuffer(1, wp.get_device("cpu"), EVERYTHING)
    for name in ("normal", "geometric_normal"):
        setattr(gbuffer, name, column([[0.0, 1.0, 0.0]], wp.vec3))
    gbuffer.to_camera = column([[0.8, 0.6, 0.0]], wp.vec3)
    gbuffer.diffuse, gbuffer.f0 = column([[diffuse] * 3], wp.vec3), column([[0.04 * f90] * 3], wp.vec3)
    gbuffer.through = column([[through] * 3], wp.vec3)
    gbuffer.f90, gbuffer.roughness = column([f90], float), column([roughness], float)
    gbuffer.albedo = column(results(even_kernel, 1, [gbuffer], wp.vec3), wp.vec3)
    return results(shown_kernel, COUNT, [gbuffer], wp.vec2)


@pytest.mark.parametrize("roughness", [0.5, 0.8])
def test_rough_lobes_show_as_much_of_even_light_but_more_of_light_from_where_they_point(roughness: float) -> None:
    share, opposite = shown(0.6, roughness).T
    assert share.mean() == pytest.approx(1.0, abs=0.03)
    assert share[opposite > 0.0].mean() > 1.05 * share[opposite == 0.0].mean()


@pytest.mark.parametrize(("diffuse", "roughness", "f90"), [(0.6, 0.4, 1.0), (0.0, 0.8, 1.0), (0.6, 0.8, 0.0)])
def test_what_frames_look_along_and_what_has_no_lobe_is_even(diffuse: float, roughness: float, f90: float) -> None:
    assert np.allclose(shown(diffuse, roughness, f90)[:, 0], 1.0)


def test_light_of_the_viewers_side_counts_by_what_that_reflects() -> None:
    """What is translucent has in its albedo what it lets through, too."""
    assert np.allclose(shown(0.3, 0.6, through=0.4), shown(0.3, 0.6), rtol=1e-4)
