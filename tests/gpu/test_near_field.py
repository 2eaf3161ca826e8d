import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.camera import look_at
from gpu.lighting import Lighting, LightingChoice
from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.scene.types import Floats, Light, LightKind
from gpu.settings import Clustering, Component, Method, RenderSettings

SIZE = (48, 36)
FEW = {"sp_clusters": 400, "vpls": 1000, "vpl_clusters": 60}


def picture(resident: ResidentScene, **settings: object) -> Floats:
    """Linear radiance of indirect light in a corner."""
    camera = look_at((0.3, -0.1, 0.3), (-0.5, -0.5, -0.5), yfov_degrees=30.0)
    chosen = RenderSettings(**{**FEW, "component": Component.INDIRECT, "lambertian": True, "bounces": 2, **settings})
    return Renderer(resident, SIZE, chosen).render(camera).radiance()


@pytest.fixture(scope="module")
def room() -> ResidentScene:
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    return resident_of([*box(), lamp], [grey(0.7), grey(0.0, 5.0)])


@pytest.mark.parametrize("method", [Method.FUZZY_VPL, Method.EXACT_VPL])
def test_a_corner_gets_the_light_back_that_few_vpls_lose(room: ResidentScene, method: Method) -> None:
    truth = picture(room, method=Method.PATH, samples=1024).mean()
    without, restored = (
        np.mean([picture(room, method=method, near_field=near, seed=seed).mean() for seed in range(8)]) / truth
        for near in (False, True)
    )
    assert without < 0.97
    assert restored == pytest.approx(1.0, abs=0.03)


def test_the_same_seed_gives_the_same_bits_and_another_other_rays(room: ResidentScene) -> None:
    def added(seed: int) -> Floats:
        return picture(room, seed=seed) - picture(room, seed=seed, near_field=False)

    assert added(0).tobytes() == added(0).tobytes() != added(1).tobytes()
    assert added(0).min() >= 0.0 < added(0).max()


@pytest.mark.parametrize("clustering", list(Clustering))
def test_every_ablation_counts_the_points_that_found_light(room: ResidentScene, clustering: Clustering) -> None:
    def found(**settings: object) -> int:
        chosen = RenderSettings(**{**FEW, "clustering": clustering, **settings})
        return Renderer(room, SIZE, chosen).render(look_at((0.3, -0.1, 0.3), (-0.5, -0.5, -0.5))).stats.counts["near"]

    assert 0.8 * SIZE[0] * SIZE[1] < found() <= SIZE[0] * SIZE[1]
    assert found(near_field=False) == found(component=Component.DIRECT) == 0


def test_the_map_knows_the_radiosity_of_an_evenly_lit_room() -> None:
    """Walls that emit M/π and reflect ρ have the reflected radiosity M·ρ/(1 − ρ), all over."""
    resident = resident_of(box(), [grey(0.5, emission=1.0 / np.pi)])
    choice = LightingChoice(vpls=20_000, vpl_clusters=200, bounces=16, seed=0, lambertian=True)
    lit = Lighting(resident).radiosity(choice, lambda what, fraction: None)
    area = np.pi * lit.vpls.spacing.numpy() ** 2
    # By area: each VPL answers for about as much as its disk has.
    mean = (lit.radiosity.numpy() * area[:, None]).sum(axis=0) / area.sum()
    assert mean == pytest.approx(np.ones(3), rel=0.05)


def test_nothing_lit_stays_black() -> None:
    away = Light("away", LightKind.SPOT, (5.0, 5.0, 5.0), (0.0, 0.0, 2.0), (0.0, 0.0, 1.0), 0.99, 0.9)
    assert (picture(resident_of(box(), [grey(0.5)], lights=[away])) == 0.0).all()
