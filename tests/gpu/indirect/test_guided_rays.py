import numpy as np
import pytest
import warp as wp
from photons import tree_of
from scenes import box, column, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.indirect.bright_photons import BRIGHT_PARAMETERS
from gpu.indirect.final_gather import FinalGather
from gpu.indirect.photon_lookup import FullMapLight
from gpu.lights.build import build_light_table
from gpu.scene.types import Doubles, Floats
from gpu.sp.centres import ShadingClusters

ALBEDO, RAYS, CENTRES, SIDE = 0.7, 64, 300, 0.03


def gathered(wall: float | None = None, *, square: bool = True) -> tuple[Doubles, Floats]:
    """Irradiance that centres which look down from all over the middle of a box find of a floor in light of 1 W, and as
    much on a small `square` in its middle; and the centres. wall: the height of a lid over the square, if it has one.
    """
    lid = [] if wall is None else [quad((-0.1, wall - 0.5, -0.1), (0.2, 0, 0), (0, 0, 0.2))]
    room = resident_of([*box(), *lid], [grey(ALBEDO)])
    rng = np.random.default_rng(5)
    places = rng.uniform(-0.5, 0.5, (8000, 3)) * (1.0, 0.0, 1.0)
    places[4000:] *= SIDE
    places = places[: 8000 if square else 4000] - (0.0, 0.5, 0.0)
    light = FullMapLight(tree_of(places, np.full(len(places), 1.0 / 4000.0)))
    light.estimate(room.view(lambertian=True))
    clusters = allocate(ShadingClusters, CENTRES, wp.get_device("cpu"))
    centres = rng.uniform(-0.4, 0.4, (CENTRES, 3)) * (1.0, 0.0, 1.0)
    clusters.position = column(centres, wp.vec3)
    clusters.normal = clusters.geometric_normal = column(np.tile((0.0, -1.0, 0.0), (CENTRES, 1)), wp.vec3)
    clusters.spacing.fill_(0.1)
    gather = FinalGather(clusters, RAYS, light, build_light_table(room), bounces=0)
    seen = room.view(lambertian=True), wp.zeros(1, dtype=int, device="cpu"), room.features(lambertian=True)
    gather.trace(*seen)
    gather.read(*seen)
    return gather.gathered.irradiance.numpy()[:, 0].astype(float), centres


def of_square(centres: Floats) -> Doubles:
    """What the square, far off for its size, brings."""
    squared = 0.25 + (centres**2).sum(axis=1)
    return ALBEDO / np.pi * 0.25 / squared**2


def test_all_centres_find_a_small_bright_place(monkeypatch: pytest.MonkeyPatch) -> None:
    light, centres = gathered()
    light -= of_square(centres)
    without, _ = gathered(square=False)
    assert light.mean() == pytest.approx(without.mean(), rel=0.04)
    assert np.abs(light - without).max() < 0.25
    monkeypatch.setattr(BRIGHT_PARAMETERS, "least", 1e9)
    by_cosine, _ = gathered()
    assert (by_cosine - of_square(centres)).std() > 1.0


def test_what_hides_a_bright_place_hides_it_from_rays_towards_it() -> None:
    light, _ = gathered(wall=0.1)
    without, _ = gathered(wall=0.1, square=False)
    assert light == pytest.approx(without, abs=0.05)
