import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls, radiosity_cache
from pipeline import Pipeline
from scenes import box, column, grey, quad, resident_of, slats, square_of_vpls

from gpu.core.device import allocate, launch
from gpu.device_scene.features import EVERYTHING
from gpu.device_scene.rays import blocking
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.indirect.near_field import (
    NEAR_FIELD_PARAMETERS,
    NearField,
    NearRays,
    near_field_light_kernel,
    near_field_vpl_kernel,
)
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Floats, Light, LightKind
from gpu.settings import Clustering, Component, Method, RenderSettings
from gpu.vpl.light_sets import LightSets
from gpu.vpl.radiosity_cache import RADIOSITY_PARAMETERS, RadiosityCache, RadiosityCells

SIZE = (32, 24)
FEW = {"sp_clusters": 200, "vpls": 1000, "vpl_clusters": 60}


CORNER = look_at((0.3, -0.1, 0.3), (-0.5, -0.5, -0.5), yfov_degrees=30.0)


def picture(device_scene: DeviceScene, camera: Camera = CORNER, **settings: object) -> Floats:
    """Linear radiance of indirect light, in a corner if no camera says otherwise."""
    chosen = RenderSettings(**{**FEW, "component": Component.INDIRECT, "lambertian": True, "bounces": 2, **settings})
    return Renderer(device_scene, SIZE, chosen).render(camera).radiance()


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    return resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])


@pytest.fixture(scope="module")
def truth(room: DeviceScene) -> float:
    """The mean of the path-traced picture of the corner."""
    return float(picture(room, method=Method.PATH, samples=128).mean())


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL])
def test_a_corner_gets_the_light_back_that_few_vpls_lose(room: DeviceScene, truth: float, method: Method) -> None:
    without, restored = (
        np.mean([picture(room, method=method, near_field=near, seed=seed).mean() for seed in range(8)]) / truth
        for near in (False, True)
    )
    assert without < 0.97
    assert restored == pytest.approx(1.0, abs=0.03)


def test_close_to_a_corner_what_comes_back_is_what_was_lost(room: DeviceScene) -> None:
    camera = look_at((-0.2, -0.2, -0.2), (-0.5, -0.5, -0.5), yfov_degrees=20.0)
    truth = picture(room, camera, method=Method.PATH, samples=128).mean()
    # So many seeds as a few VPLs in a corner need for a mean that is good to 1.5 %.
    without, restored = (
        np.mean([picture(room, camera, near_field=near, seed=seed).mean() for seed in range(seeds)]) / truth
        for near, seeds in ((False, 12), (True, 48))
    )
    assert without < 0.85
    assert restored == pytest.approx(1.0, abs=0.03)


def test_the_same_seed_gives_the_same_bits_and_another_other_rays(room: DeviceScene) -> None:
    def kahan_add(seed: int) -> Floats:
        return picture(room, seed=seed) - picture(room, seed=seed, near_field=False)

    assert kahan_add(0).tobytes() == kahan_add(0).tobytes() != kahan_add(1).tobytes()
    assert kahan_add(0).min() >= 0.0 < kahan_add(0).max()


@pytest.mark.parametrize("clustering", list(Clustering))
def test_every_ablation_counts_the_points_that_found_light(room: DeviceScene, clustering: Clustering) -> None:
    def counts(**settings: object) -> dict[str, int]:
        chosen = RenderSettings(**{**FEW, "clustering": clustering, **settings})
        return Renderer(room, SIZE, chosen).render(look_at((0.3, -0.1, 0.3), (-0.5, -0.5, -0.5))).stats.counts

    usual = counts()
    points = SIZE[0] * SIZE[1] if clustering is Clustering.VPLS else usual["shaded"]
    assert 0.2 * points < usual["near"] < 0.5 * points  # most surfaces are far, and one in four looks there
    assert counts(near_field=False)["near"] == counts(component=Component.DIRECT)["near"] == 0


def test_less_is_given_back_in_the_middle_of_a_floor_than_in_its_corner(room: DeviceScene) -> None:
    def gained(eye: tuple[float, float, float], target: tuple[float, float, float]) -> float:
        settings = RenderSettings(**FEW, component=Component.INDIRECT, lambertian=True, bounces=2)
        camera = look_at(eye, target, yfov_degrees=8.0)
        usual, without = (
            Renderer(room, SIZE, settings.model_copy(update={"near_field": near})).render(camera).radiance().mean()
            for near in (True, False)
        )
        return float(usual / without - 1.0)

    corner = gained((0.0, 0.0, 0.0), (-0.49, -0.49, -0.49))
    assert corner > 0.05
    assert 0.0 <= gained((0.0, 0.3, 0.1), (0.0, -0.5, 0.0)) < 0.2 * corner


def test_a_wall_between_keeps_light_from_crossing() -> None:
    """A thin wall parts a room; one part is lit. VPLs there are near to points beyond, on walls that go on."""
    lamp = quad((-0.4, 0.49, -0.2), (0.3, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    # Not where cells of the search begin, which would not cross it anyway.
    left = quad((0.099, -0.5, -0.5), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    right = quad((0.101, -0.5, -0.5), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    device_scene = resident_of([*box(), lamp, left, right], [grey(0.7), grey(0.0, 5.0)])
    camera = look_at((0.3, -0.2, -0.2), (0.1, -0.5, -0.5), yfov_degrees=40.0)
    assert (Renderer(device_scene, SIZE, RenderSettings(**FEW)).render(camera).radiance() == 0.0).all()


def test_nothing_lit_stays_black() -> None:
    away = Light("away", LightKind.SPOT, (5.0, 5.0, 5.0), (0.0, 0.0, 2.0), (0.0, 0.0, 1.0), 0.99, 0.9)
    assert (picture(resident_of(box(), [grey(0.5)], lights=[away])) == 0.0).all()


def test_one_ray_in_four_looks_far_and_of_known_points_one_in_three_looks_at_all() -> None:
    device_scene, camera, size = slats((24, 18))
    fuzzy = Pipeline(device_scene, camera, size, sp_clusters=20)
    view, count = fuzzy.view, fuzzy.sp_count
    sent = LightSets(device_scene).table, view.features, 2
    near = NearField(view.pixels, view.smoothing, view.device, *sent)
    cache = radiosity_cache(device_scene, view.scene, fuzzy.lights)

    def lengths(frames: int, seed: int) -> Floats:
        view.seed.fill_(seed)
        known = wp.full(view.pixels, frames, dtype=int, device=view.device)
        near.trace(view.scene, view.gbuffer, view.shading_points, fuzzy.lights, cache, view.seed, known)
        return np.asarray(near._rays.distance.numpy()[:count].copy())

    for frames, period in ((0, 1), (5, 3)):
        found = np.concatenate([lengths(frames, seed) for seed in range(24)])
        turn = np.concatenate([np.arange(count) + seed for seed in range(24)])
        assert not found[turn % period != 0].any()
        assert found[turn % (2 * period) == period].any()
        assert 0.045 < found[turn % (4 * period) != 0].max() < 0.0501
        assert found[turn % (8 * period) == 4 * period].max() > 0.1


CPU = wp.get_device("cpu")


def rays_to(position: tuple[float, float, float], distance: float) -> NearRays:
    """One ray, which met a floor."""
    rays: NearRays = allocate(NearRays, 1, CPU)
    rays.position, rays.normal = column([position], wp.vec3), column([(0.0, 1.0, 0.0)], wp.vec3)
    rays.distance.fill_(distance)
    return rays


@pytest.mark.parametrize(
    ("height", "covered", "vpls", "tells"),
    [(0.012, 3, 7_000, True), (0.012, 2, 7_000, False), (0.012, 2, 6_000, True), (0.03, 3, 100_000, False)],
)
def test_what_stands_up_by_a_tenth_of_the_way_to_a_vpl_hides_it_and_one_of_many_tells_nothing_of_narrow_surfaces(
    height: float, covered: int, vpls: int, tells: bool
) -> None:
    """The VPL is 0.2 away, so the ray runs at a height of 0.02. Where it tells nothing, the ray goes on."""
    slat = quad((0.0, -0.5, -0.4), (0.0, 0.0, 0.8), (0.0, height, 0.0))
    device_scene = resident_of([*box(), slat], [grey(0.5)])
    rays = rays_to((-0.1, -0.5, 0.0), 0.3)
    rays.vpl.zero_()
    clusters = cluster_vpls(device_scene, square_of_vpls(9, -0.5), 1, 0)
    cache = RadiosityCache()
    cache.chosen, cache.covered = RADIOSITY_PARAMETERS, column([covered], wp.int32)
    cache.usual_area = RADIOSITY_PARAMETERS.most_area / vpls
    cache.position, cache.radiosity = column([(0.1, -0.5, 0.0)], wp.vec3), column([(1.0, 1.0, 1.0)], wp.vec3)
    gbuffer: GBuffer = allocate(GBuffer, 1, CPU)
    points = PointList()
    points.pixels, points.numbers, points.count = (column([value], wp.int32) for value in (0, 0, 1))
    frames = wp.zeros(1, dtype=int, device=CPU)
    inputs = [device_scene.data, gbuffer, points, clusters, cache, frames, NEAR_FIELD_PARAMETERS, rays]
    launch(near_field_light_kernel(EVERYTHING, blocking(device_scene.data)), 1, inputs, CPU)
    assert rays.found.numpy()[0] == (1 if tells else 0)
    assert (rays.light.numpy()[0] > 0.0).all() == tells
    assert (rays.share.numpy()[0] > 0.0) != tells


@pytest.mark.parametrize(("radii", "answers"), [(38.0, True), (58.0, False)])
def test_vpls_of_radii_far_below_the_distance_are_not_asked(radii: float, answers: bool) -> None:
    """A VPL stands in the cells of 0.75 to 6 radii, and 0.06 of the distance is looked for in cells of 1.5 of that."""
    device_scene = resident_of(box(), [grey(0.5)])
    cache = radiosity_cache(device_scene, device_scene.data, cluster_vpls(device_scene, square_of_vpls(2500), 60, 0))
    radius = 0.0148  # in the middle of a level
    cache.radius.fill_(radius)
    RadiosityCells(cache, CPU).sort()
    rays = rays_to((0.0, 0.0, 0.0), radii * radius)
    launch(near_field_vpl_kernel, 1, [cache, NEAR_FIELD_PARAMETERS, rays], CPU)
    assert (rays.vpl.numpy()[0] >= 0) == answers
