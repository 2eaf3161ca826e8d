import numpy as np
import pytest
import warp as wp
from lit_surfaces import radiosity_cache
from pipeline import Pipeline
from scenes import box, camera_of, grey, quad, resident_of

from gpu.core.parameters import parameters
from gpu.correction.bias_compensation import CompensationPaths, compensate_bias
from gpu.correction.vpl_connections import Connections, connect
from gpu.direct.path_tracing import PathSamples, trace_paths
from gpu.indirect.irradiance import CHECKS
from gpu.lights.build import build_light_table
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles
from gpu.vpl.bound_area import BoundAreaParameters, areas_of, bound_areas
from gpu.vpl.shadow_rays import shadow_rays

SIZE, SAMPLES, BOUNCES = (16, 12), 64, 3
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.2, -0.5), yfov_degrees=75.0)


@pytest.fixture(scope="module")
def room() -> Pipeline:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    device_scene = resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)])
    return Pipeline(device_scene, CAMERA, SIZE, 80, vpls=8000, vpl_clusters=200, far_field_sums=True)


@pytest.fixture(scope="module")
def traced(room: Pipeline) -> Doubles:
    """Mean indirect radiance by path tracing."""
    mean = wp.zeros(SIZE[0] * SIZE[1], dtype=wp.vec3, device="cpu")
    paths = parameters(PathSamples, count=512, bounces=BOUNCES, direct=False, indirect=True)
    camera = camera_of(room.device_scene, CAMERA, SIZE)
    trace_paths(room.view.scene, build_light_table(room.device_scene), camera, SIZE, paths, mean)
    return np.asarray(mean.numpy().mean(axis=1), np.float64)


@pytest.mark.parametrize("vpl_areas", [2.0, 60.0, 1e9])
def test_bounded_vpls_and_paths_are_together_what_path_tracing_finds(
    room: Pipeline, traced: Doubles, vpl_areas: float
) -> None:
    """Whatever the bound is: of one without end, VPLs send nothing."""
    view, scene = room.view, room.device_scene
    lit = radiosity_cache(scene, scene.data, room.lights)
    bounds = bound_areas(lit, parameters(BoundAreaParameters, vpl_areas=vpl_areas, unlit=vpl_areas * 1e-4))
    rays = shadow_rays(view.pixels, CHECKS, view.device, side_by_side=True, control_variate=False)
    these, paths = Connections(), CompensationPaths()
    these.passes, these.areas = 3, areas_of(room.lights, bounds)
    paths.bounds, paths.areas, paths.bounces = bounds, these.areas, BOUNCES
    sent, given_back = np.zeros(view.pixels), np.zeros(view.pixels)
    albedo = view.gbuffer.albedo.numpy().mean(axis=1)
    irradiance = view.indirect.irradiance
    for sample in range(SAMPLES):
        room.shade(sample)
        these.seed = paths.sample = sample
        inputs = view.scene, view.gbuffer, view.shading_points
        connect(*inputs, room.known, view.indirect, rays, these)
        bounded = irradiance.numpy().mean(axis=1) * albedo / np.pi
        table = build_light_table(scene)
        compensate_bias(view.scene, table, *inputs[1:], room.lights, paths, irradiance, view.frame.features)
        sent += bounded / SAMPLES
        given_back += (irradiance.numpy().mean(axis=1) * albedo / np.pi - bounded) / SAMPLES
    # One light set is off by a per cent or so.
    assert (sent + given_back).mean() == pytest.approx(traced.mean(), rel=0.03)
    tiles = [light.reshape(4, 3, 4, 4).mean(axis=(1, 3)) for light in (sent + given_back, traced)]
    assert np.allclose(*tiles, rtol=0.12)
    share = given_back.mean() / traced.mean()
    assert {2.0: 0.0 < share < 0.2, 60.0: 0.1 < share < 0.8, 1e9: share > 0.95}[vpl_areas]


def test_paths_go_on_where_a_wide_bound_takes_much_away(room: Pipeline) -> None:
    """So of nine in ten SPs a path finds some light, and no single path finds far more than others."""
    view, table, scene = room.view, build_light_table(room.device_scene), room.device_scene
    lit = radiosity_cache(scene, scene.data, room.lights)
    bounds = bound_areas(lit, parameters(BoundAreaParameters, vpl_areas=60.0, unlit=60e-4))
    paths, found = CompensationPaths(), []
    paths.bounds, paths.areas, paths.bounces = bounds, areas_of(room.lights, bounds), BOUNCES
    room.shade()
    for sample in range(SAMPLES):
        paths.sample = sample
        view.indirect.irradiance.zero_()
        inputs = view.gbuffer, view.shading_points, room.lights, paths, view.indirect.irradiance
        compensate_bias(view.scene, table, *inputs, view.frame.features)
        found.append(view.indirect.irradiance.numpy().mean(axis=1)[room.pixels])
    light = np.array(found, np.float64)
    assert 0.89 < np.mean(light > 0.0) < 0.925
    assert light.max() < 20.0 * light.mean()
