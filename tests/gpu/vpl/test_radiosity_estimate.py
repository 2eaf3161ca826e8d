import numpy as np
import pytest
import warp as wp
from lit_surfaces import by_hand, cluster_vpls, floors, inner, joined, mapped, radiosity_cache
from scenes import box, column, grey, quad, resident_of, results, square_of_vpls

from gpu.clustering.grid import Grid
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.features import EVERYTHING
from gpu.scene.types import Ints, Material
from gpu.vpl.light_set import LightSetChoice
from gpu.vpl.light_sets import LightSets
from gpu.vpl.radiosity_cache import RADIOSITY_PARAMETERS, RadiosityCache, RadiosityParameters
from gpu.vpl.radiosity_estimate import covered_radiosity_kernel, disk_coverage_kernel, neighbour_spacing_kernel
from gpu.vpl.vpl_clusters import VplClusters


def radiosity_of(light_sets: LightSets, choice: LightSetChoice) -> RadiosityCache:
    """Around the VPLs of a choice."""
    return light_sets.radiosity(light_sets.made(choice, lambda what, fraction: None))


def test_the_map_knows_the_radiosity_of_an_evenly_lit_room() -> None:
    """Walls that emit M/π and reflect ρ have the reflected radiosity M·ρ/(1 − ρ), all over."""
    device_scene = resident_of(box(), [grey(0.5, emission=1.0 / np.pi)])
    choice = LightSetChoice(vpls=20_000, vpl_clusters=200, bounces=16, seed=0, lambertian=True)
    lit = radiosity_of(LightSets(device_scene), choice)
    area = np.pi * lit.radius.numpy() ** 2
    # By area: each VPL answers for about as much as its disk has.
    mean = (lit.radiosity.numpy() * area[:, None]).sum(axis=0) / area.sum()
    assert mean == pytest.approx(np.ones(3), rel=0.05)


def test_lighting_makes_a_map_once_and_keeps_it_with_its_vpls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu.vpl.light_sets.KEPT_VPLS", 1000)
    device_scene = resident_of(box(), [grey(0.5, emission=1.0)])
    light_sets = LightSets(device_scene)
    choices = [LightSetChoice(1000, 10, 2, seed, lambertian=True) for seed in range(2)]
    made = radiosity_of(light_sets, choices[0])
    assert radiosity_of(light_sets, choices[0]) is made
    radiosity_of(light_sets, choices[1])
    again = radiosity_of(light_sets, choices[0])
    assert again is not made
    assert again.radiosity.numpy().tobytes() == made.radiosity.numpy().tobytes()


def test_radiosity_is_flux_per_area() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(4096, flux=3.0, seed=1))
    # The density of places strewn at random; each place counts once, though sparse ones speak for more of the area.
    area = lit.radius.numpy()[inner(lit)] ** 2
    mean = (lit.radiosity.numpy()[inner(lit)] * area[:, None]).sum(axis=0) / area.sum()
    assert mean == pytest.approx(np.full(3, 3.0 * 4096 / 0.36), rel=0.05)


def test_a_vpl_that_carries_far_more_than_its_neighbours_makes_no_bright_spot() -> None:
    vpls = square_of_vpls(1024)
    flux = vpls.flux.numpy()
    middle = int(np.argmin(np.linalg.norm(vpls.position.numpy(), axis=1)))
    flux[middle] *= 100.0
    vpls.flux = column(flux, wp.vec3)
    lit = mapped(floors((0.0,)), vpls)
    radiosity = lit.radiosity.numpy()[inner(lit)]
    usual = np.median(radiosity, axis=0)
    # Of eleven that count, one counts as four of the others: without that, the most would be ten times the usual.
    assert (radiosity.max(axis=0) < 2.0 * usual).all()


def test_vpls_that_differ_as_those_of_a_room_do_lose_no_light_to_that() -> None:
    """Flux of two like events each (a gamma distribution of shape 2): its largest of twelve is 2.3 times the mean."""
    device_scene, vpls = floors((0.0,)), square_of_vpls(1024)
    flux = np.random.default_rng(1).gamma(2.0, 0.5, (vpls.count, 1))
    vpls.flux = column(np.tile(flux, (1, 3)), wp.vec3)
    clusters = cluster_vpls(device_scene, vpls, 60, 0)
    every = parameters(RadiosityParameters, most_of_mean=1e9)
    kept, whole = (
        radiosity_cache(device_scene, device_scene.data, clusters, chosen=chosen).radiosity.numpy().sum()
        for chosen in (RADIOSITY_PARAMETERS, every)
    )
    assert kept > 0.98 * whole


def test_shelves_close_above_each_other_do_not_mix() -> None:
    gap = 0.01  # about as far as VPLs on a shelf are apart
    below, above = square_of_vpls(2500, 0.0, 1.0, seed=2), square_of_vpls(2500, gap, 1000.0, seed=3)
    lit = mapped(floors((0.0, gap)), joined(below, above))
    low = (lit.position.numpy()[:, 1] < 0.5 * gap) & inner(lit)
    density = 2500 / 0.36
    assert low.sum() > 500
    assert np.average(lit.radiosity.numpy()[low, 0], weights=lit.radius.numpy()[low] ** 2) < 2.0 * density
    assert np.median(lit.radiosity.numpy()[~low & inner(lit), 0]) > 500.0 * density


def test_of_a_surface_that_is_there_in_part_the_radiosity_is_that_of_what_is_there() -> None:
    lit = by_hand(np.zeros((2, 3)), 0.1)
    covered, share = column(np.ones(16), wp.int32), column([1.0, 0.25], float)
    launch(covered_radiosity_kernel, 2, [covered, share, lit], wp.get_device("cpu"))
    assert lit.radiosity.numpy()[:, 0] == pytest.approx([1.0, 4.0])


def test_less_than_three_of_eight_places_that_are_surface_are_not_believed() -> None:
    covered = np.tri(9, 8, -1, dtype=np.int32)
    lit = by_hand(np.zeros((9, 3)), 0.1)
    inputs = [column(covered.ravel(), wp.int32), wp.zeros(0, float, device="cpu"), lit]
    launch(covered_radiosity_kernel, 9, inputs, wp.get_device("cpu"))
    expected = [8.0 / max(number, 3) for number in range(9)]
    assert lit.radiosity.numpy()[:, 0] == pytest.approx(expected)
    assert lit.covered.numpy().tolist() == list(range(9))


@pytest.mark.parametrize(("area", "taken"), [(0.5, 0.5), (40.0, 16.0)])
def test_twelve_neighbours_are_searched_no_farther_than_sixteen_unit_squares_hold(area: float, taken: float) -> None:
    """Of 100 VPLs in one cluster, a search reaches 2/3 of the radius that twelve of them fill."""
    clusters: VplClusters = cluster_vpls(floors((0.0,)), square_of_vpls(100), 1, 0)
    disks = clusters.disks.numpy()
    disks["area"] = area
    clusters.disks = wp.array(disks, dtype=clusters.disks.dtype, device="cpu")
    vpls = Grid(100, wp.get_device("cpu")).data
    inputs = [clusters, RADIOSITY_PARAMETERS.most_area, column([100], wp.int32), 1, vpls]
    launch(neighbour_spacing_kernel, 1, inputs, wp.get_device("cpu"))
    assert vpls.spacing.numpy() == pytest.approx(2.0 / 3.0 * np.sqrt(12.0 * taken / 100.0 / np.pi), rel=1e-5)


def covered_places(edge: float, depth: float) -> Ints:
    """Which places around a VPL at the origin, of a disk of radius 0.1, show a floor so deep that ends at x = edge."""
    floor = quad((-0.5, -depth, 0.5), (0.5 + edge, 0.0, 0.0), (0.0, 0.0, -1.0))
    device_scene = resident_of([floor, *box(0)], [grey(0.5)])
    inputs = [device_scene.data, by_hand(np.zeros((1, 3)), 0.1)]
    return results(disk_coverage_kernel(EVERYTHING), 8, inputs, wp.int32).astype(np.int32)


def test_a_surface_is_looked_for_at_the_middle_of_a_disks_area() -> None:
    assert covered_places(0.09, 0.0).all()
    assert not covered_places(0.05, 0.0).all()


def test_what_is_off_by_more_than_a_quarter_of_a_disks_radius_is_another_surface() -> None:
    assert covered_places(0.5, 0.024).all()
    assert not covered_places(0.5, 0.027).any()


def test_frosted_glass_before_a_wall_adds_nothing_to_the_light_of_the_wall() -> None:
    """What comes back through it faces the way of the wall, nearer than VPLs are apart."""
    sheet = quad((-0.5, -0.497, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), 1)
    glass = Material(transmission=1.0, roughness=0.3, specular=0.0)
    device_scene = resident_of([*box(), sheet], [grey(0.5, emission=1.0 / np.pi), glass]).generalised()
    sets = LightSets(device_scene)
    lit = sets.radiosity(sets.made(LightSetChoice(4000, 100, 8, 0, lambertian=False), lambda what, fraction: None))
    position, reflects = lit.position.numpy(), lit.reflectance.numpy()[:, 0]
    up = lit.normal.numpy()[:, 1] > 0.9
    on_glass = (np.abs(position[:, 1] + 0.497) < 1e-4) & (np.abs(lit.normal.numpy()[:, 1]) > 0.9)
    assert (up & on_glass).sum() > 100
    assert not lit.radius.numpy()[on_glass].any()
    floor = up & ~on_glass & (lit.radius.numpy() > 0.0)
    assert reflects[floor] == pytest.approx(0.5)
    middle = floor & (np.abs(position[:, [0, 2]]).max(axis=1) < 0.4)
    # 1, and a quarter more, since there are more VPLs where estimates of few are high; with the glass' it would be 3.
    assert lit.radiosity.numpy()[middle].mean() == pytest.approx(1.1, abs=0.3)
