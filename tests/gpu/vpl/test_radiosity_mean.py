"""What VPLs tell of any point of their surface."""

import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls, radiosity_cache
from scenes import box, column, grey, quad, resident_of, results, square_of_vpls

from gpu.device_scene.upload import DeviceScene
from gpu.scene.types import Doubles, Material
from gpu.vpl.radiosity_cache import RadiosityCache
from gpu.vpl.radiosity_mean import mean_irradiance

COUNT, DENSITY = 4096, 4096 / 0.36


@wp.kernel
def mean_irradiance_kernel(first: int, lit: RadiosityCache, position: wp.array[wp.vec3],
                           out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """One thread a point of a floor."""
    point = first + wp.tid()
    out[point] = mean_irradiance(lit, position[point], wp.vec3(0.0, 1.0, 0.0))


def floor_of(material: Material) -> DeviceScene:
    floor = quad((-0.5, 0.0, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), 1)
    return resident_of([*box(0), floor], [grey(0.5), material])


def lit_floor(material: Material) -> RadiosityCache:
    """A floor with VPLs of flux 1."""
    device_scene, vpls = floor_of(material), square_of_vpls(COUNT, seed=1)
    vpls.flux = column(np.ones((vpls.count, 3)), wp.vec3)
    features = device_scene.features(lambertian=False)
    return radiosity_cache(device_scene, device_scene.data, cluster_vpls(device_scene, vpls, 60, 0), features)


def irradiance(lit: RadiosityCache, points: Doubles) -> Doubles:
    """(point, 3)."""
    return results(mean_irradiance_kernel, len(points), [lit, column(points, wp.vec3)], wp.vec3)


def row(y: float = 0.0) -> Doubles:
    x = np.linspace(-0.2, 0.2, 401)
    return np.stack([x, np.full(401, y), np.full(401, 0.01)], axis=1)


def test_a_point_gets_the_light_that_its_surface_reflects_over_its_reflectance() -> None:
    assert irradiance(lit_floor(grey(0.4)), row()).mean() == pytest.approx(DENSITY / 0.4, rel=0.05)


def test_where_there_are_no_vpls_nothing_is_known() -> None:
    assert (irradiance(lit_floor(grey(0.5)), row(0.3)) == 0.0).all()


def test_channels_that_are_hardly_reflected_tell_little() -> None:
    """Of light as red as others, half is told of a hundredth that is reflected, and all of a twenty-fifth."""
    lit = lit_floor(Material(base_color=(0.5, 0.005, 0.02, 1.0), specular=0.0))
    told = irradiance(lit, row()).mean(axis=0)
    assert told / told[0] == pytest.approx([1.0, 50.0, 25.0], rel=0.02)
