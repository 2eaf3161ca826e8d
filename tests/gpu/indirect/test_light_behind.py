import numpy as np
import pytest
import warp as wp
from pictures import CAMERA, QUALITY, SIZE, curtained_room, picture
from scenes import column

from gpu.device_scene.features import EVERYTHING
from gpu.gbuffer.gbuffer import allocate_gbuffer
from gpu.gbuffer.shading_points import ShadingPoints
from gpu.indirect.light_behind import join_sides
from gpu.renderer import Renderer
from gpu.settings import Component, Method, RenderSettings


def test_sides_count_by_what_they_scatter() -> None:
    device = wp.get_device("cpu")
    gbuffer = allocate_gbuffer(2, device, EVERYTHING)
    points = ShadingPoints((2, 1), 1, device)
    points.count.fill_(2)
    points.pixels.assign([0, 1])
    gbuffer.through = column([[0.25, 0.5, 0.0], [0.0, 0.0, 0.0]], wp.vec3)
    gbuffer.albedo = column([[1.0, 0.5, 0.5], [0.5, 0.5, 0.5]], wp.vec3)
    behind = column([[8.0, 8.0, 8.0], [0.5, 0.5, 0.5]], wp.vec3)
    irradiance = column([[4.0, 4.0, 4.0], [4.0, 4.0, 4.0]], wp.vec3)
    join_sides(gbuffer, points, behind, irradiance)
    assert np.allclose(irradiance.numpy(), [[11.0, 8.0, 12.0], [4.5, 4.5, 4.5]])


@pytest.mark.parametrize("method", [Method.EXACT_VPL, Method.FUZZY_VPL, Method.RSM_DISKS, Method.PHOTON_GATHER])
def test_single_frames_show_a_lit_room_through_a_curtain(method: Method) -> None:
    room = curtained_room()
    bounces = {"bounces": 1} if method is Method.RSM_DISKS else {}
    settings = {**QUALITY, "component": Component.INDIRECT, "vpls": 20_000, "photons": 20_000, **bounces}
    seen = Renderer(room, SIZE, RenderSettings(**settings, method=method)).render(CAMERA).radiance()
    paths = picture(room, **settings, method=Method.PATH, samples=512)
    assert seen.mean() == pytest.approx(paths.mean(), rel=0.06)
    middle = np.s_[9:27, 16:32]
    assert seen[middle].mean(axis=(0, 1)) == pytest.approx(paths[middle].mean(axis=(0, 1)), rel=0.08)
