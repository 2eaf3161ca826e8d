import numpy as np
import pytest
import warp as wp
from scenes import column, grey, quad, resident_of, results

from gpu.device_scene.features import EVERYTHING
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction
from gpu.scene.types import Doubles, Material
from gpu.vpl.vpl_lobes import VplLobes, by_lobe, lobes_of

COUNT = 1 << 12
TO_LIGHT = np.array([0.8, 0.6, 0.0])


@wp.kernel
def sent_kernel(first: int, vpls: Vpls, lobes: VplLobes, out: wp.array[wp.vec2]) -> None:
    """(share, whether it is on the other side of the normal than the light) in directions by their cosine."""
    index = first + wp.tid()
    place = sobol_pair(index, 0, 1)
    direction = cosine_direction(vpls.normal[0], place.x, place.y)
    away = wp.where(wp.dot(direction, vpls.to_light[0]) < 0.0, 1.0, 0.0)
    out[index] = wp.vec2(by_lobe(lobes, vpls, 0, direction)[0], away)


def sent(material: Material, *, lambertian: bool = False) -> Doubles:
    """What `sent_kernel` tells of a VPL on a sheet that faces up, lit askew."""
    sheet = quad([-0.5, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    device_scene = resident_of([sheet], [material])
    vpls = allocate_vpls(1, wp.get_device("cpu"))
    vpls.position, vpls.normal = column([[0.1, 0.0, 0.1]], wp.vec3), column([[0.0, 1.0, 0.0]], wp.vec3)
    vpls.to_light = column([TO_LIGHT], wp.vec3)
    lobes = lobes_of(device_scene.view(lambertian=lambertian), EVERYTHING, vpls)
    return results(sent_kernel, COUNT, [vpls, lobes], wp.vec2)


@pytest.mark.parametrize("material", [Material(roughness=0.5), Material(metallic=1.0, roughness=0.6)])
def test_a_lobe_sends_as_much_as_it_would_evenly_but_away_from_the_light(material: Material) -> None:
    share, away = sent(material).T
    assert share.mean() == pytest.approx(1.0, abs=0.03)
    assert share[away > 0.0].mean() > 1.1 * share[away == 0.0].mean()


def test_narrow_lobes_are_widened() -> None:
    assert np.allclose(sent(Material(roughness=0.05)), sent(Material(roughness=0.5)))


@pytest.mark.parametrize(
    "material",
    [
        grey(0.5),
        Material(metallic=1.0, roughness=0.2),
        Material(roughness=0.5, sheen_color=(0.5, 0.5, 0.5)),
        Material(roughness=0.5, transmission=1.0),
        Material(roughness=0.5, diffuse_transmission=0.5),
    ],
)
def test_without_a_lobe_or_where_caustics_have_it_light_is_even(material: Material) -> None:
    assert (sent(material)[:, 0] == 1.0).all()


def test_lambertian_surfaces_have_none() -> None:
    assert (sent(Material(roughness=0.5), lambertian=True)[:, 0] == 1.0).all()
