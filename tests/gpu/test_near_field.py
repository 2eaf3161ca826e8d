import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.camera import look_at
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
    def counts(**settings: object) -> dict[str, int]:
        chosen = RenderSettings(**{**FEW, "clustering": clustering, **settings})
        return Renderer(room, SIZE, chosen).render(look_at((0.3, -0.1, 0.3), (-0.5, -0.5, -0.5))).stats.counts

    usual = counts()
    points = SIZE[0] * SIZE[1] if clustering is Clustering.VPLS else usual["shaded"]
    assert 0.8 * points < usual["near"] <= points
    assert counts(near_field=False)["near"] == counts(component=Component.DIRECT)["near"] == 0


def test_less_is_given_back_in_the_middle_of_a_floor_than_in_its_corner(room: ResidentScene) -> None:
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
    """A room is parted by a thin wall. One half is lit; on the floor of the other nothing is given back."""
    lamp = quad((-0.4, 0.49, -0.2), (0.3, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    wall = [quad((x, -0.5, -0.5), *edges) for x, edges in ((-0.001, ((0, 0, 1), (0, 1, 0))),
                                                           (0.001, ((0, 1, 0), (0, 0, 1))))]  # fmt: skip
    resident = resident_of([*box(), lamp, *wall], [grey(0.7), grey(0.0, 5.0)])
    camera = look_at((0.4, 0.2, 0.3), (0.0, -0.5, 0.0), yfov_degrees=40.0)
    dark = Renderer(resident, SIZE, RenderSettings(**FEW)).render(camera).radiance()
    assert (dark == 0.0).all()


def test_nothing_lit_stays_black() -> None:
    away = Light("away", LightKind.SPOT, (5.0, 5.0, 5.0), (0.0, 0.0, 2.0), (0.0, 0.0, 1.0), 0.99, 0.9)
    assert (picture(resident_of(box(), [grey(0.5)], lights=[away])) == 0.0).all()
