"""Direct light by what tiles' probes find of lights, beside that by power alone, on a floor under two lamps."""

import numpy as np
import pytest
import warp as wp
from scenes import camera_of, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.device_scene.upload import DeviceScene
from gpu.direct.direct_light import add_soft_light, direct_samples, trace_direct_light
from gpu.direct.light_selection import BINS, SELECTION_PARAMETERS, LightProbes
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import chain_samples
from gpu.lights.build import build_light_table
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles

SIZE = (20, 20)  # the last tiles are cut


def lamp(z: float, material: int) -> object:
    """One above the floor, which looks down."""
    return quad([-0.1, 0.4, z], [0.2, 0.0, 0.0], [0.0, 0.0, 0.1], material)


def lit_floor(bright: float) -> DeviceScene:
    """A floor under a lamp, and under another of such a radiance in a shade, which all of the picture lies behind."""
    floor = quad([-0.5, 0.0, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    shade = quad([-0.2, 0.35, 0.1], [0.4, 0.0, 0.0], [0.0, 0.0, 0.3])
    materials = [grey(0.5), grey(0.0, emission=2.0), grey(0.0, emission=bright)]
    return resident_of([floor, shade, lamp(-0.3, 1), lamp(0.2, 2)], materials)


@pytest.fixture(scope="module")
def shaded() -> DeviceScene:
    """The lamp that is hidden has three times the power of the other one."""
    return lit_floor(6.0)


BELOW_THE_SHADE = Camera("down", look_at((0.0, 0.1, 0.2), (0.0, 0.0, 0.2)).to_world, 0.02, orthographic=True)


def direct(device_scene: DeviceScene, camera: Camera, seed: int, *, learnt: bool = True) -> tuple[Doubles, LightProbes]:
    """Direct light of four samples a pixel, (pixel, 3), and the probes that tell where the lights are."""
    gbuffer = allocate(GBuffer, SIZE[0] * SIZE[1], device_scene.device)
    scene = device_scene.view(lambertian=True)
    trace_primary_rays(scene, camera_of(device_scene, camera, SIZE), SIZE, gbuffer, chain_samples(device_scene.device))
    out, moment = wp.zeros(SIZE[0] * SIZE[1], dtype=wp.vec3, device="cpu"), wp.zeros(1, dtype=int, device="cpu")
    soft, probes = wp.zeros_like(out), LightProbes(SIZE, device_scene.device)
    table = build_light_table(device_scene)
    probes.run(scene, table, gbuffer, seed)
    samples = direct_samples(4, moment, seed, probes if learnt else None)
    trace_direct_light(scene, table, gbuffer, SIZE, samples, out, soft, device_scene.features(lambertian=True))
    add_soft_light(gbuffer, soft, out)
    return np.asarray(out.numpy(), np.float64), probes


def test_light_that_is_not_hidden_is_sampled_with_the_same_mean(shaded: DeviceScene) -> None:
    learnt, by_power = (
        np.stack([direct(shaded, BELOW_THE_SHADE, seed, learnt=learnt)[0][:, 0] for seed in range(16)])
        for learnt in (True, False)
    )
    alone, _ = direct(lit_floor(0.0), BELOW_THE_SHADE, 0, learnt=False)
    assert learnt.mean() == pytest.approx(alone[:, 0].mean(), rel=0.02)
    assert learnt.var() < by_power.var() / 4.0


def test_as_many_samples_as_are_wanted_still_go_by_power(shaded: DeviceScene) -> None:
    _, probes = direct(shaded, BELOW_THE_SHADE, 0)
    shares = np.diff(probes.selection.ends.numpy().reshape(-1, int(BINS)), axis=1, prepend=0.0)
    quarter = int(BINS) // 4
    assert np.allclose(shares[:, quarter + 1 :], SELECTION_PARAMETERS.by_power / int(BINS), atol=1e-6)
    assert np.allclose(shares.sum(axis=1), 1.0)
    visible = probes.selection.visible.numpy().reshape(-1, int(BINS))
    assert np.all(visible[:, :quarter] == 1.0)
    assert np.allclose(visible[:, quarter + 1 :], SELECTION_PARAMETERS.least_visible)


def test_where_no_light_was_found_all_go_by_power(shaded: DeviceScene) -> None:
    """The camera sees the floor from below, where no light comes."""
    from_below = look_at((0.0, -0.1, 0.0), (0.0, 0.0, 0.0))
    light, probes = direct(shaded, from_below, 0)
    assert not light.any()
    even = np.arange(1, int(BINS) + 1) / int(BINS)
    assert np.allclose(probes.selection.ends.numpy().reshape(-1, int(BINS)), even)
