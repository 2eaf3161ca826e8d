import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls
from scenes import box, column, grey, quad, resident_of, results, square_of_vpls

from gpu.adaptive.probe_gather import (
    AS_ONE,
    BY_MEMBERS,
    NOT,
    PROBE_LIGHT_PARAMETERS,
    RAYS,
    ProbeLight,
    ProbeLightParameters,
    way_to_look,
)
from gpu.gbuffer.point_list import PointList
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import Material
from gpu.settings import Component, Method, RenderSettings
from gpu.vpl.shadow_rays import NO_RAY
from gpu.vpl.vpl_clusters import VplClusters

SIZE = (32, 24)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
CHOICE = {"component": Component.INDIRECT, "near_field": False, "vpls": 2000, "vpl_clusters": 96, "sp_clusters": 300}
FRAMES = 150


@wp.kernel
def look_kernel(first: int, position: wp.array[wp.vec3], vpls: VplClusters, by: ProbeLightParameters,
                out: wp.array[int]) -> None:  # fmt: skip
    """One thread a point that faces down: how it looks at the first cluster."""
    point = first + wp.tid()
    out[point] = way_to_look(position[point], wp.vec3(0.0, -1.0, 0.0), vpls, 0, by)


def test_a_cluster_is_one_share_of_the_light_from_four_times_its_extent_on() -> None:
    vpls = cluster_vpls(resident_of(box(), [grey(0.5)]), square_of_vpls(100), 1, 0)
    places = vpls.disks.numpy()["position"] + np.outer([-0.1, 3.9, 4.1], [0.0, vpls.extent.numpy()[0], 0.0])
    ways = results(look_kernel, 3, [column(places, wp.vec3), vpls, PROBE_LIGHT_PARAMETERS], wp.int32)
    assert ways.tolist() == [int(NOT), int(BY_MEMBERS), int(AS_ONE)]


@pytest.mark.parametrize(
    "block", [grey(0.4), Material(transmission=1.0, roughness=0.0, base_color=(0.9, 0.4, 0.1, 1.0))]
)
def test_rays_find_the_light_of_all_vpls_and_each_has_a_step(block: Material) -> None:
    """In a closed box with a block, whose shadows hide VPLs, or a pane, which colours their light."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    sheet = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    room = resident_of([*box(), lamp, sheet], [grey(0.7), grey(0.0, 5.0), block])
    renderer = Renderer(room, SIZE, RenderSettings(**CHOICE))
    renderer.render(CAMERA)
    view, vpls = renderer._method._frame, renderer._method.lights.vpls  # type: ignore[attr-defined]
    pixels = np.arange(0, view.pixels, 7, dtype=np.int32)
    light = ProbeLight(len(pixels), view.device, tinted=view.features.part_glass)
    points, frame = PointList(), wp.zeros(1, dtype=int, device="cpu")
    points.pixels = wp.array(pixels, dtype=int, device="cpu")
    points.count = wp.full(1, len(pixels), dtype=int, device="cpu")
    seen = []
    for number in range(FRAMES):
        frame.fill_(number)
        light.gather(view.scene, view.gbuffer, points, frame, vpls)
        seen.append(light.light.numpy().reshape(len(pixels), 2, 3).copy())
    every = np.array(seen, dtype=np.float64)
    exact = Renderer(room, SIZE, RenderSettings(**CHOICE, method=Method.EXACT_VPL))
    exact.render(CAMERA)
    truth = exact._method._frame.indirect.irradiance.numpy()[pixels]
    assert every.mean(axis=(0, 2)) == pytest.approx(truth, rel=0.05, abs=0.02 * float(truth.mean()))
    assert every.mean(axis=(0, 1, 2)) == pytest.approx(truth.mean(axis=0), rel=0.003)
    one, other = every[:, :, 0].mean(axis=2), every[:, :, 1].mean(axis=2)
    together = [np.corrcoef(one[:, probe], other[:, probe])[0, 1] for probe in range(len(pixels))]
    assert abs(np.nanmean(together)) < 0.02, "the two estimates are independent"
    assert np.all(light._rays.vpl.numpy() != int(NO_RAY))
    steps = np.array(light._rays.share.numpy()).reshape(len(pixels), -1)
    alone = np.isclose(steps, light._parts.cdf.numpy()[-1][:, None] / int(RAYS))
    assert 0.1 < alone.mean() < 0.9, "some clusters are one share of the light, some are not"
