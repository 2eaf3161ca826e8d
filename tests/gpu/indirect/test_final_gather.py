import numpy as np
import pytest
import warp as wp
from photons import photons_of
from scenes import box, column, grey, resident_of

from gpu.core.device import allocate
from gpu.core.parameters import parameters
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.final_gather import FinalGather, Gathered
from gpu.indirect.photon_lookup import FullMapLight, LookupParameters, choose_sites
from gpu.lights.build import build_light_table
from gpu.lights.photon_tree import allocate_tree, build_tree
from gpu.scene.types import Floats
from gpu.sp.centres import ShadingClusters

CPU = wp.get_device("cpu")
RAYS, ALBEDO, RADIUS = 256, 0.7, 0.09


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return resident_of(box(), [grey(ALBEDO)])


def floor_photons() -> Floats:
    """A lattice, on the floor of the box alone."""
    x, z = np.meshgrid(*2 * [np.linspace(-0.49, 0.49, 40)])
    return np.stack([x.ravel(), np.full(x.size, -0.5), z.ravel()], axis=1)


def gathered(room: DeviceScene, normal: tuple[float, float, float], **chosen: float) -> Gathered:
    """What a centre in the middle of the box finds of a floor with an irradiance of 1, 2, 3; and one not in use."""
    positions = floor_photons()
    photons = photons_of(positions, np.tile((0.0, 1.0, 0.0), (len(positions), 1)), np.ones((len(positions), 3)))
    tree = allocate_tree(photons)
    build_tree(tree)
    light = FullMapLight(tree, chosen=parameters(LookupParameters, **chosen))
    choose_sites(tree, light.lit.sites)
    light.lit.sites.radius.fill_(RADIUS)
    light.lit.sites.free.fill_(RADIUS)
    light.lit.sites.irradiance.fill_(wp.vec3(1.0, 2.0, 3.0))
    light.sort()
    clusters = allocate(ShadingClusters, 2, CPU)
    clusters.normal = clusters.geometric_normal = column([normal, normal], wp.vec3)
    clusters.spacing = column([0.1, 0.0], float)
    gather = FinalGather(clusters, RAYS, light, build_light_table(room), bounces=0)
    seed = wp.zeros(1, dtype=int, device=CPU)
    seen = room.view(lambertian=True), seed, room.features(lambertian=True)
    gather.trace(*seen)
    gather.read(*seen)
    return gather.gathered


def test_irradiance_is_the_form_factor_times_what_the_floor_reflects(room: DeviceScene) -> None:
    found = gathered(room, (0.0, -1.0, 0.0))
    # Of a unit square seen from half a unit above its middle (Siegel and Howell, configuration 4 of a corner).
    a = 0.5 / np.hypot(0.5, 0.5)
    form_factor = 4.0 / np.pi * a * np.arctan(a)
    wanted = form_factor * ALBEDO * np.array([1.0, 2.0, 3.0])
    assert found.irradiance.numpy()[0] == pytest.approx(wanted, rel=0.03)
    assert found.irradiance.numpy()[1] == pytest.approx(0.0)
    # Straight down is a ray of half a unit, and no point of the box is nearer.
    assert found.least_distance.numpy()[0] == pytest.approx(0.5, rel=0.01)


def test_what_faces_away_finds_nothing_and_far_photons_do_not_answer(room: DeviceScene) -> None:
    assert gathered(room, (0.0, 1.0, 0.0)).irradiance.numpy()[0] == pytest.approx(0.0)
    some = gathered(room, (0.0, -1.0, 0.0), reach=0.1).irradiance.numpy()[0, 0]
    all_light = gathered(room, (0.0, -1.0, 0.0)).irradiance.numpy()[0, 0]
    # Around every fourth photon of the lattice, a disk of 0.1 radii answers.
    assert some / all_light == pytest.approx(0.25 * np.pi * (0.1 * RADIUS * 39.0 / 0.98) ** 2, rel=0.15)
