import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.clustering.grid import Grid
from gpu.clustering.points import Points
from gpu.core.device import allocate, launch
from gpu.core.parameters import parameters
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.point_list import PointList
from gpu.scene.types import Floats
from gpu.sp.shading_clusters import run_spacing_kernel, variation_seed_kernel
from gpu.sp.variation_tree import SeedingParameters, allocate_variation_tree, build_variation_tree

CPU = wp.get_device("cpu")
COUNT = 500


def bent_sheet() -> tuple[Points, Floats, Floats]:
    """Points along a line: flat for the first half, then rolled up."""
    x = np.linspace(-0.5, 0.5, COUNT)
    angle = np.where(x < 0.0, 0.0, 12.0 * x)
    positions = np.stack([x, np.zeros(COUNT), np.zeros(COUNT)], axis=1)
    normals = np.stack([np.sin(angle), np.cos(angle), np.zeros(COUNT)], axis=1)
    points = Points()
    points.position, points.normal = column(positions, wp.vec3), column(normals, wp.vec3)
    points.count = column([COUNT], wp.int32)
    return points, positions, normals


def seeded(seeds: int, random: int, **chosen: float) -> tuple[Floats, Floats]:
    """How many points share a seed with each of them, and the points that are seeds."""
    points, positions, _ = bent_sheet()
    tree = allocate_variation_tree(COUNT, CPU)
    build_variation_tree(points, tree)
    parameter, drawn = parameters(SeedingParameters, **chosen), column([random], wp.int32)
    gbuffer, listed = allocate(GBuffer, COUNT, CPU), PointList()
    gbuffer.spacing.fill_(1.0)
    for directions in (gbuffer.geometric_normal, gbuffer.to_camera):
        directions.fill_(wp.vec3(0.0, 1.0, 0.0))
    listed.pixels, listed.count = column(np.arange(COUNT), wp.int32), points.count
    points.spacing = wp.zeros(COUNT, dtype=float, device=CPU)
    by_pixel = wp.zeros(COUNT, dtype=float, device=CPU)
    launch(run_spacing_kernel, COUNT, [gbuffer, listed, parameter, tree, seeds, drawn, points, by_pixel], CPU)
    clusters = Grid(seeds, CPU).data
    launch(variation_seed_kernel, seeds, [points, parameter, tree, drawn, clusters], CPU)
    at = np.asarray(clusters.position.numpy()[clusters.spacing.numpy() > 0.0, 0])
    return np.rint(points.spacing.numpy() ** 2).astype(int), np.abs(positions[:, :1] - at).argmin(axis=0)


def test_nodes_have_the_moments_of_their_points() -> None:
    points, positions, normals = bent_sheet()
    tree = allocate_variation_tree(COUNT, CPU)
    build_variation_tree(points, tree)
    for level in range(tree.levels + 1):
        for number in range(1 << level):
            run = slice(number * COUNT >> level, (number + 1) * COUNT >> level)
            node = (1 << level) + number
            mean = positions[run].mean(axis=0)
            assert tree.mean.numpy()[node] == pytest.approx(mean, abs=1e-5)
            assert tree.normal.numpy()[node] == pytest.approx(normals[run].mean(axis=0), abs=1e-5)
            assert tree.squares.numpy()[node] == pytest.approx(((positions[run] - mean) ** 2).sum(), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("seeds", [1, 2, 37, 250, COUNT])
def test_every_seed_and_every_point_know_of_each_other(seeds: int) -> None:
    sizes, at = seeded(seeds, 5)
    assert (0.9 if seeds < COUNT else 0.7) * seeds < len(at) <= seeds
    assert len(set(at)) == len(at)
    away = np.abs(np.arange(COUNT)[:, None] - at).min(axis=1)
    assert (away < sizes).all()
    assert sizes[at].sum() == pytest.approx(COUNT, rel=0.3)  # the rest is nearest to them, but in no run of theirs


def test_seeds_go_where_geometry_varies_and_some_are_even() -> None:
    rolled = {
        even: np.mean([(seeded(40, random, even_share=even)[1] >= COUNT // 2).mean() for random in range(8)])
        for even in (0.0, 0.5, 1.0)
    }
    assert rolled[0.0] > 0.85
    assert rolled[1.0] == pytest.approx(0.5, abs=0.03)
    assert rolled[0.5] == pytest.approx(0.5 * (rolled[0.0] + rolled[1.0]), abs=0.03)
