"""Light at its limits: powers of no reasonable size, VPLs where the light is looked at, counts that do not fit."""

from functools import cache

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from scenes import box, column, grey, quad, resident_of
from stress import render

from gpu.core.device import allocate
from gpu.device_scene.upload import DeviceScene
from gpu.film.metrics import rel_mse
from gpu.indirect.clustered_light import clustered_light
from gpu.indirect.exact_gather import gather
from gpu.indirect.far_field import FarSums
from gpu.indirect.fuzzy_shading import shade
from gpu.indirect.visibility import Visibility
from gpu.lights.light_paths import allocate_vpls
from gpu.scene.camera import look_at
from gpu.scene.types import Floats, Light, LightKind, Material
from gpu.settings import Component, Method
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.build import unclustered
from gpu.vpl.disk_light import Disk
from gpu.vpl.vpl_clusters import VplClusters

SIZE = (24, 18)
CAMERA = look_at((0.1, 0.05, 0.42), (-0.05, -0.1, -0.5), yfov_degrees=75.0)
LAMP = quad((-0.2, 0.48, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
METHODS = pytest.mark.parametrize("method", list(Method))


@cache
def lit(device: str, method: Method, power: float) -> Floats:
    """A room lit by a lamp and by a bulb of `power` times one."""
    bulb = Light("bulb", LightKind.POINT, (0.1 * power,) * 3, (0.3, 0.2, 0.1))
    device_scene = resident_of([*box(), LAMP], [grey(0.6), grey(0.0, power)], lights=[bulb], device=device)
    return render(device_scene, CAMERA, SIZE, method=method, samples=4)


@cache
def lamp_room(device: str) -> DeviceScene:
    """A room lit by a lamp alone."""
    return resident_of([*box(), LAMP], [grey(0.6), grey(0.0, 1.0)], device=device)


@METHODS
@pytest.mark.parametrize("power", [1e-12, 1e12])
def test_power_scales_the_picture_and_nothing_else(device: str, power: float, method: Method) -> None:
    assert rel_mse(lit(device, method, power) / power, lit(device, method, 1.0)) < 1e-6


@METHODS
def test_a_candle_beside_the_sun(device: str, method: Method) -> None:
    """24 orders of magnitude apart in one scene: the lamp of 10¹² is right, the other cannot be told."""
    materials = [grey(0.6), grey(0.0, 1e12), grey(0.0, 1e-12)]
    candle = quad((-0.4, -0.3, -0.4), (0.0, 0.0, 0.1), (0.1, 0.0, 0.0), 2)
    device_scene = resident_of([*box(), LAMP, candle], materials, device=device)
    alone = resident_of([*box(), LAMP, candle], [grey(0.6), grey(0.0, 1.0), grey(0.0)], device=device)
    both, one = (render(r, CAMERA, SIZE, method=method, samples=4) for r in (device_scene, alone))
    assert (both / 1e12).mean() == pytest.approx(one.mean(), rel=0.02)


@METHODS
@pytest.mark.parametrize("colour", [(0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 1.0)])
def test_walls_that_reflect_nothing_or_everything(
    device: str, colour: tuple[float, float, float, float], method: Method
) -> None:
    device_scene = resident_of(
        [*box(), LAMP], [Material(base_color=colour, specular=0.0), grey(0.0, 1.0)], device=device
    )
    picture = render(device_scene, CAMERA, SIZE, method=method, component=Component.INDIRECT, samples=4, bounces=16)
    dark = [number for number, value in enumerate(colour[:3]) if value == 0.0]
    assert not picture[..., dark].any()
    assert all(picture[..., number].mean() > 0.0 for number in range(3) if number not in dark)


@METHODS
def test_a_light_in_the_plane_of_a_wall_and_one_on_its_corner(device: str, method: Method) -> None:
    lights = [Light("in", LightKind.POINT, (1.0,) * 3, (0.0, -0.5, 0.0)),
              Light("corner", LightKind.POINT, (1.0,) * 3, (0.5, 0.5, 0.5))]  # fmt: skip
    device_scene = resident_of(box(), [grey(0.5)], lights=lights, device=device)
    assert render(device_scene, CAMERA, SIZE, method=method, samples=4).max() < 1e6


@METHODS
@pytest.mark.parametrize("counts", [{"vpl_clusters": 5000}, {"vpl_clusters": 1}, {"sp_clusters": 5000},
                                    {"sp_clusters": 1}, {"vpls": 1, "vpl_clusters": 50}])  # fmt: skip
def test_more_clusters_than_points_and_one_of_all(device: str, counts: dict[str, int], method: Method) -> None:
    """Also tests/gpu/test_renderer.py, which has all of these at once."""
    assert render(lamp_room(device), CAMERA, SIZE, method=method, **counts).mean() > 0.0


@METHODS
def test_one_shading_point(device: str, method: Method) -> None:
    assert render(lamp_room(device), CAMERA, (1, 1), method=method).mean() > 0.0
    speck = resident_of([quad((0.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.0, 0.01, 0.0)), LAMP],
                        [grey(0.6), grey(0.0, 1.0)], device=device)  # fmt: skip
    render(speck, look_at((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)), (9, 9), method=method)


@pytest.fixture(scope="module")
def floor(device: str) -> FrameView:
    """A floor of albedo 0.6 seen from above, two dozen SPs."""
    device_scene = resident_of([quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0))], [grey(0.6)], device=device)
    view = FrameView(device_scene, (6, 4), lambertian=True)
    view.set_camera(look_at((0.0, 0.4, 0.1), (0.0, 0.0, 0.0)))
    view.find_shading_points()
    return view


def singles_at(view: FrameView, height: float, normal: float, area: float) -> VplClusters:
    """A VPL of flux 1 W and an `area` at `height` over each SP, that faces up (1) or down (−1)."""
    count = view.pixels
    vpls: VplClusters = allocate(VplClusters, count, view.device)
    vpls.count = count
    places = view.gbuffer.position.numpy() + np.array([0.0, height, 0.0], np.float32)
    vpls.members = allocate_vpls(count, view.device)
    vpls.members.position = column(places, wp.vec3, str(view.device))
    vpls.members.normal = column([[0.0, normal, 0.0]] * count, wp.vec3, str(view.device))
    vpls.members.flux = column(np.ones((count, 3)), wp.vec3, str(view.device))
    disks = np.zeros(count, vpls.disks.numpy().dtype)
    disks["area"] = area
    vpls.disks = wp.array(disks, dtype=Disk, device=view.device)
    vpls.member_area = column([area] * count, float, str(view.device))
    vpls.starts = wp.array(np.arange(count + 1), dtype=int, device=view.device)
    return unclustered(view.device_scene, vpls)


@pytest.mark.parametrize("area", [0.0, 1e-4])
@pytest.mark.parametrize(("height", "normal"), [(0.0, 1.0), (0.0, -1.0), (1e-6, 1.0), (1e-6, -1.0)])
def test_vpls_on_shading_points_and_a_millionth_above(
    floor: FrameView, height: float, normal: float, area: float
) -> None:
    """Gathered exactly and through clusters: finite, nothing from one's own plane, and no more than a disk sends."""
    vpls = singles_at(floor, height, normal, area)
    gather(floor.scene, floor.gbuffer, floor.shading_points, vpls, 0, vpls.count, floor.indirect)
    exact = floor.indirect.irradiance.numpy()
    visibility = Visibility(1, vpls.count, floor.device)
    visibility.words.fill_(wp.uint32((1 << vpls.count) - 1))
    clusters: SpClusters = allocate(SpClusters, 1, floor.device)
    clusters.cluster = wp.zeros((1, floor.pixels), dtype=int, device=floor.device)
    clusters.weight = wp.zeros((1, floor.pixels), dtype=float, device=floor.device)
    clusters.weight.fill_(1.0)
    clusters.used.fill_(1)
    clusters.fresh.fill_(1)
    far = FarSums(1, vpls.count, floor.device, enabled=False)
    far.run(clusters, visibility.words, vpls, few=False)
    known = clustered_light(clusters, visibility.words, vpls, far.data)
    shade(1, floor.gbuffer, floor.shading_points, known, floor.seed, floor.indirect)
    for irradiance in (exact, floor.indirect.irradiance.numpy()):
        assert np.isfinite(irradiance).all()
        if height == 0.0 or normal > 0.0:
            assert not irradiance.any()
        elif area > 0.0:
            assert (irradiance <= 1.001 / area).all()
            assert (irradiance > 0.0).all()
