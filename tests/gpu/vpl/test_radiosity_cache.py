import numpy as np
import pytest
import warp as wp
from lit_surfaces import cluster_vpls, radiosity_cache
from scenes import box, column, grey, quad, resident_of, results, square_of_vpls

from gpu.clustering.grid import CLUSTERING_PARAMETERS, Grid
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.features import EVERYTHING
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.scene.types import Doubles, Ints, Material
from gpu.vpl.light_set import LightSetChoice
from gpu.vpl.light_sets import LightSets
from gpu.vpl.radiosity_cache import (
    CELLS_MOVED,
    RADIOSITY_PARAMETERS,
    RadiosityCache,
    RadiosityCells,
    RadiosityParameters,
    covered_radiosity_kernel,
    disk_coverage_kernel,
    neighbour_spacing_kernel,
    vpl_around,
)
from gpu.vpl.vpl_clusters import VplClusters


@wp.kernel
def around_kernel(first: int, lit: RadiosityCache, position: wp.array[wp.vec3], normal: wp.array[wp.vec3], scale: float,
                  out: wp.array[int]) -> None:  # fmt: skip
    """One thread a point: the VPL that answers for it."""
    point = first + wp.tid()
    out[point] = vpl_around(lit, position[point], normal[point], scale)


def around(lit: RadiosityCache, points: Doubles, normals: Doubles, scale: float = 1e-3) -> Ints:
    """The VPLs that answer for points, (point,)."""
    inputs = [lit, column(points, wp.vec3), column(normals, wp.vec3), scale]
    return results(around_kernel, len(points), inputs, wp.int32).astype(np.int32)


def joined(*parts: Vpls) -> Vpls:
    """All VPLs of some sets."""
    vpls = allocate_vpls(sum(part.count for part in parts), wp.get_device("cpu"))
    for name in ("position", "normal", "flux"):
        values = np.concatenate([getattr(part, name).numpy() for part in parts])
        setattr(vpls, name, column(values, wp.vec3))
    return vpls


def floors(heights: tuple[float, ...], half: float = 0.5) -> DeviceScene:
    """Floors that face up."""
    parts = [quad((-half, height, half), (2.0 * half, 0.0, 0.0), (0.0, 0.0, -2.0 * half)) for height in heights]
    return resident_of([*parts, *box(0)], [grey(0.5)])


def mapped(device_scene: DeviceScene, vpls: Vpls) -> RadiosityCache:
    return radiosity_cache(device_scene, device_scene.data, cluster_vpls(device_scene, vpls, 60, 0))


def inner(lit: RadiosityCache, half: float = 0.2) -> Doubles:
    """Which VPLs lie well inside a square."""
    return (np.abs(lit.position.numpy()[:, [0, 2]]) < half).all(axis=1)


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


def test_vpls_without_neighbours_have_no_disk() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(1))
    assert (lit.radius.numpy() == 0.0).all()
    assert (lit.radiosity.numpy() == 0.0).all()
    assert (around(lit, np.zeros((1, 3)), np.array([[0.0, 1.0, 0.0]])) == -1).all()


def test_shelves_close_above_each_other_do_not_mix() -> None:
    gap = 0.01  # about as far as VPLs on a shelf are apart
    below, above = square_of_vpls(2500, 0.0, 1.0, seed=2), square_of_vpls(2500, gap, 1000.0, seed=3)
    lit = mapped(floors((0.0, gap)), joined(below, above))
    low = (lit.position.numpy()[:, 1] < 0.5 * gap) & inner(lit)
    density = 2500 / 0.36
    assert low.sum() > 500
    assert np.average(lit.radiosity.numpy()[low, 0], weights=lit.radius.numpy()[low] ** 2) < 2.0 * density
    assert np.median(lit.radiosity.numpy()[~low & inner(lit), 0]) > 500.0 * density


def test_a_point_is_answered_by_a_vpl_near_it_on_its_surface() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(2500, seed=4))
    points = np.random.default_rng(5).uniform(-0.25, 0.25, (200, 3)) * [1.0, 0.0, 1.0]
    up = np.tile([0.0, 1.0, 0.0], (200, 1))
    found = around(lit, points, up)
    assert (found >= 0).all()
    distance = np.linalg.norm(lit.position.numpy()[found] - points, axis=1)
    assert (distance < 2.0 * lit.radius.numpy()[found]).all()
    assert (around(lit, points, -up) == -1).all()
    for away in ((0.0, 0.2, 0.0), (1.0, 0.0, 0.0)):
        assert (around(lit, points + np.array(away), up) == -1).all()


def test_surfaces_of_dense_and_of_sparse_vpls_both_answer() -> None:
    heights = (0.0, 0.3)
    dense, sparse = square_of_vpls(10_000, heights[0], seed=4), square_of_vpls(100, heights[1], seed=5)
    lit = mapped(floors(heights), joined(dense, sparse))
    points = np.random.default_rng(6).uniform(-0.2, 0.2, (200, 3)) * [1.0, 0.0, 1.0]
    up = np.tile([0.0, 1.0, 0.0], (200, 1))
    for height in heights:
        found = around(lit, points + np.array([0.0, height, 0.0]), up)
        assert (found >= 0).all()
        assert lit.position.numpy()[found, 1] == pytest.approx(np.full(200, height))


def test_of_many_vpls_in_a_cell_those_that_are_read_lie_all_over_it() -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(10_000))  # row after row
    points = np.random.default_rng(5).uniform(-0.25, 0.25, (500, 3)) * [1.0, 0.0, 1.0]
    found = around(lit, points, np.tile([0.0, 1.0, 0.0], (500, 1)), 0.015)
    assert (found >= 0).all()
    distance = np.linalg.norm(lit.position.numpy()[found] - points, axis=1)
    assert np.quantile(distance / lit.radius.numpy()[found], 0.9) < 1.0


@pytest.mark.parametrize("scale", [1.0, 1e-6])
def test_vpls_of_radii_far_from_what_is_asked_for_are_not_found(scale: float) -> None:
    lit = mapped(floors((0.0,)), square_of_vpls(2500, seed=4))
    up = np.array([[0.0, 1.0, 0.0]])
    assert around(lit, np.zeros((1, 3)), up)[0] >= 0
    assert around(lit, np.zeros((1, 3)), up, scale)[0] == -1


# Where cells begin.
CORNER = -np.array([[*CELLS_MOVED]], np.float64)


def by_hand(positions: Doubles, radius: float) -> RadiosityCache:
    """A cache of VPLs that face up, of estimates' disks of a radius."""
    count, lit = len(positions), RadiosityCache()
    lit.chosen, lit.alike = RADIOSITY_PARAMETERS, CLUSTERING_PARAMETERS
    lit.position, lit.normal = column(positions, wp.vec3), column(np.tile([0.0, 1.0, 0.0], (count, 1)), wp.vec3)
    lit.radius, lit.radiosity = column(np.full(count, radius), float), column(np.ones((count, 3)), wp.vec3)
    lit.covered = wp.zeros(count, dtype=int, device="cpu")
    RadiosityCells(lit, wp.get_device("cpu")).sort()
    return lit


@pytest.mark.parametrize(("radii", "answers"), [(0.1, True), (1.9, True), (2.1, False)])
def test_a_vpl_answers_within_two_of_its_radii(radii: float, answers: bool) -> None:
    radius = 0.0148
    # The largest of its cells are of 4.2 radii.
    begin = CORNER + 1e-3 * radius
    point = begin + np.array([radii * radius, 0.0, 0.0])
    assert (around(by_hand(begin, radius), point, np.array([[0.0, 1.0, 0.0]]))[0] == 0) == answers


@pytest.mark.parametrize(("scale", "answers"), [(2.6, True), (3.1, False), (1.0 / 900.0, False), (1.0 / 600.0, True)])
def test_a_vpl_stands_in_cells_of_three_sizes_and_nine_are_searched(scale: float, answers: bool) -> None:
    radius = 0.0148
    point = CORNER + 1e-3 * radius
    assert (around(by_hand(point, radius), point, np.array([[0.0, 1.0, 0.0]]), scale * radius)[0] == 0) == answers


def test_points_of_a_wall_at_the_end_of_unit_space_are_in_one_cell_whatever_rounding_makes_of_them() -> None:
    wall = np.array([[0.2, -0.5, 0.1]])
    for size in (0.0148, 0.1):
        for towards in (-1.0, 0.0):
            point = np.array([[0.2, float(np.nextafter(np.float32(-0.5), np.float32(towards))), 0.1]])
            assert around(by_hand(wall, size), point, np.array([[0.0, 1.0, 0.0]]))[0] == 0


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


@pytest.mark.parametrize(("count", "read"), [(12, 12), (24, 12)])
def test_twelve_vpls_of_a_cell_are_read_at_most(count: int, read: int) -> None:
    positions = CORNER + np.random.default_rng(2).uniform(0.001, 0.015, (count, 3)) * [1.0, 0.0, 1.0] + [0.0, 1e-4, 0.0]
    found = around(by_hand(positions, 0.0148), positions, np.tile([0.0, 1.0, 0.0], (count, 1)))
    assert (found == np.arange(count)).sum() == read


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
