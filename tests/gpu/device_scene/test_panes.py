"""What clear panes leave of light, in closed form, and how often paths cross them."""

import numpy as np
import pytest
import warp as wp
from scenes import grey, quad, resident_of, results

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.panes import meet, met_surface, transmittance
from gpu.device_scene.upload import DeviceScene
from gpu.sampling.sobol import hashed
from gpu.scene.types import AlphaMode, Material

COUNT = 1 << 14
SLANTED = np.array([0.0, 0.6, -0.8])
COLOUR = (0.9, 0.6, 0.3)
PANE = Material(base_color=(*COLOUR, 1.0), transmission=1.0, roughness=0.0)
WALL = quad([-2.0, -2.0, -1.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 1)


@wp.kernel
def between_kernel(first: int, scene: SceneData, p: wp.vec3, q: wp.vec3, out: wp.array[wp.vec3]) -> None:
    index = first + wp.tid()
    out[index] = transmittance(scene, p, wp.vec3(0.0, 0.0, 0.0), q, wp.vec3(0.0, 0.0, 0.0))


@wp.kernel
def meet_kernel(first: int, scene: SceneData, origin: wp.vec3, direction: wp.vec3, out: wp.array[wp.vec4]) -> None:
    """(triangle, distance, green of the tint, share of glass where a ray ends) of a ray."""
    index = first + wp.tid()
    scene.coverage = hashed(wp.uint32(index)) | wp.uint32(1)
    met = meet(scene, origin, direction, False)
    share = float(0.0)
    if met.hit.face != NO_HIT:
        share = met_surface(scene, met.hit, direction).glass
    out[index] = wp.vec4(float(met.hit.face), met.hit.t, met.tint[1], share)


def window(count: int = 1, **change: object) -> DeviceScene:
    """Panes in planes z = 0, 0.1, …, before a wall at z = −1, in the world's lengths."""
    panes = [quad([-2.0, -2.0, 0.1 * k], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 0) for k in range(count)]
    material = Material(**{**vars(PANE), **change})
    return resident_of([*panes, WALL], [material, grey(0.5)])


def through(cosine: float, ior: float = 1.5) -> float:
    """What an untinted pane lets through, of both polarisations."""
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / ior**2)
    face = 0.5 * (((ior * cosine - inner) / (ior * cosine + inner)) ** 2
                  + ((cosine - ior * inner) / (cosine + ior * inner)) ** 2)  # fmt: skip
    return float(1.0 - 2.0 * face / (1.0 + face))


def unit(device_scene: DeviceScene, point: list[float]) -> wp.vec3:
    placement = device_scene.scene.placement
    return wp.vec3(*((np.array(point) - placement.centre) * placement.scale))


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("back", [False, True])
def test_panes_dim_and_tint_what_passes(count: int, back: bool) -> None:
    device_scene = window(count)
    ends = [unit(device_scene, [0.0, 0.0, 0.8]), unit(device_scene, [0.0, 0.6, -0.05])]
    ends = ends[::-1] if back else ends
    way = np.array([0.0, 0.6, -0.85])
    found = results(between_kernel, 1, [device_scene.data, *ends], wp.vec3)[0]
    expected = (np.array(COLOUR) * through(abs(way[2]) / np.linalg.norm(way))) ** count
    assert np.allclose(found, expected, rtol=1e-4)


@pytest.mark.parametrize(("mode", "left"), [(AlphaMode.BLEND, 0.7 * 0.7), (AlphaMode.MASK, 1.0)])
def test_blended_surfaces_dim_what_passes_by_what_is_there(mode: AlphaMode, left: float) -> None:
    """Two of them, before a pane."""
    veils = [quad([-2.0, -2.0, z], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 2) for z in (0.2, 0.3)]
    pane = quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 0)
    veil = Material(base_color=(1.0, 1.0, 1.0, 0.3), alpha_mode=mode)
    device_scene = resident_of([pane, *veils, WALL], [PANE, grey(0.5), veil])
    ends = [unit(device_scene, [0.0, 0.0, 0.8]), unit(device_scene, [0.0, 0.0, -0.5])]
    found = results(between_kernel, 1, [device_scene.data, *ends], wp.vec3)[0]
    assert np.allclose(found, left * np.array(COLOUR) * through(1.0), rtol=1e-4)
    behind = [ends[0], unit(device_scene, [0.0, 0.0, -1.5])]
    assert not results(between_kernel, 1, [device_scene.data, *behind], wp.vec3).any()


def test_lambertian_views_take_panes_for_solid() -> None:
    device_scene = window()
    ends = [unit(device_scene, [0.0, 0.0, 0.5]), unit(device_scene, [0.0, 0.0, -0.5])]
    assert not results(between_kernel, 1, [device_scene.view(lambertian=True), *ends], wp.vec3).any()
    assert results(between_kernel, 1, [device_scene.view(lambertian=False), *ends], wp.vec3).all()


@pytest.mark.parametrize("transmission", [1.0, 0.6])
def test_paths_cross_panes_as_often_as_light_does(transmission: float) -> None:
    device_scene = window(2, transmission=transmission)
    inputs = [device_scene.data, unit(device_scene, [0.0, 0.0, 0.5]), wp.vec3(*SLANTED)]
    face, distance, tint, share = results(meet_kernel, COUNT, inputs, wp.vec4).T
    crossing, scale = transmission * through(0.8), device_scene.scene.placement.scale
    at_wall = np.isclose(distance, 1.5 / 0.8 * scale, rtol=1e-3)
    assert at_wall.mean() == pytest.approx(crossing**2, abs=0.012)
    assert np.allclose(tint[at_wall], COLOUR[1] ** 2)
    nearest = np.isclose(distance, 0.4 / 0.8 * scale, rtol=1e-3)
    assert nearest.mean() == pytest.approx(1.0 - crossing, abs=0.012)
    assert np.allclose(tint[nearest], 1.0)
    # What is met does not let light through: it is the mirror's part, and what is not glass.
    assert np.allclose(share[~at_wall], (transmission - crossing) / (1.0 - crossing), atol=1e-4)
    assert (share[at_wall] == 0.0).all()
    assert np.isin(face[at_wall], [0, 1]).all()


@pytest.mark.parametrize("change", [{"roughness": 0.3}, {"transmission": 0.0}, {"metallic": 1.0}])
def test_what_is_no_clear_glass_stops_rays(change: dict[str, float]) -> None:
    device_scene = window(1, **change)
    assert device_scene.data.pane_count == 0
    ends = [unit(device_scene, [0.0, 0.0, 0.5]), unit(device_scene, [0.0, 0.0, -0.5])]
    assert not results(between_kernel, 1, [device_scene.data, *ends], wp.vec3).any()


@pytest.mark.parametrize("back", [False, True])
def test_bodies_stop_shadow_rays(back: bool) -> None:
    """What they refract comes by caustics."""
    glass = Material(**{**vars(PANE), "thickness": 1.0})
    faces = [quad([-2, -2, 0.1], [4, 0, 0], [0, 4, 0], 0), quad([-2, -2, -0.1], [0, 4, 0], [4, 0, 0], 0)]
    device_scene = resident_of([*faces, WALL], [glass, grey(0.5)])
    ends = [unit(device_scene, (SLANTED * (k - 0.5)).tolist()) for k in (0.0, 1.0)]
    assert not results(between_kernel, 1, [device_scene.data, *(ends[::-1] if back else ends)], wp.vec3).any()
