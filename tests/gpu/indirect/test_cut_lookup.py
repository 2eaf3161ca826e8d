import numpy as np
import pytest
import warp as wp
from photons import STRETCH, photons_of, two_sided_square
from scenes import column, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.device_scene.features import scene_features
from gpu.indirect.cut_lookup import CutLight
from gpu.indirect.final_gather import FinalGather
from gpu.lights.photon_density import NEIGHBOURS
from gpu.lights.photon_tree import allocate_tree, build_tree
from gpu.scene.types import Floats
from gpu.sp.shading_clusters import ShadingClusters

CPU = wp.get_device("cpu")
COUNT, POINTS, ALBEDO = 2000, 40, 0.7


def weighted(light: CutLight, position: Floats, normal: Floats) -> Floats:
    """Eq. 4 and 5 over all nodes of the cut, and the tail."""
    lit, photons = light.lit, light.lit.tree.photons
    count = light.cut.nodes.count.numpy()[0]
    photon, node = lit.sites.photon.numpy()[:count], light.cut.nodes.node.numpy()[:count]
    nodes = lit.tree.nodes.numpy()[node]
    sides = (nodes["upper"] - nodes["lower"]).max(axis=1)
    radius = lit.sites.radius.numpy()[:count]
    own = COUNT / 2.0 ** light.cut.nodes.level.numpy()[:count]
    widest = lit.chosen.most_radii * radius * np.sqrt(np.maximum(own / NEIGHBOURS, 1.0))
    reach = lit.chosen.reach * np.clip(sides, radius, widest)
    normals = photons.normal.numpy()[photon]
    way = photons.position.numpy()[photon] - position
    plane = np.maximum(np.abs(way @ normal), np.abs((way * normals).sum(axis=1)))
    share = np.sqrt((way**2).sum(axis=1) + (STRETCH**2 - 1.0) * plane**2) / reach
    tail = lit.chosen.tail_weight * (1.0 - (share / lit.chosen.tail_reach) ** 2)
    weight = np.maximum(np.maximum(1.0 - share**2, 0.0) + tail, 0.0) * np.maximum(normals @ normal, 0.0)
    return weight @ lit.sites.irradiance.numpy()[:count] / max(weight.sum(), 1e-12)


def test_a_ray_reads_the_mean_of_the_nodes_around() -> None:
    """From close to the surface, so that it ends below where it begins."""
    positions, normals = two_sided_square(COUNT)
    rng = np.random.default_rng(3)
    tree = allocate_tree(photons_of(positions, normals, rng.uniform(size=(COUNT, 3))))
    build_tree(tree)
    light = CutLight(tree, 256)
    square = resident_of([quad((-0.5, 0.0, -0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))], [grey(ALBEDO)])
    scene = square.view(lambertian=True)
    light.estimate(scene)
    places = rng.uniform(-0.45, 0.45, (POINTS, 3)) * (1.0, 0.0, 1.0)
    clusters: ShadingClusters = allocate(ShadingClusters, POINTS, CPU)
    clusters.position = column(places + np.float32([0.0, 1e-3, 0.0]), wp.vec3)
    clusters.normal = clusters.geometric_normal = column(np.tile((0.0, -1.0, 0.0), (POINTS, 1)), wp.vec3)
    clusters.spacing.fill_(1.0)
    gather = FinalGather(clusters, 1, light)
    gather.run(scene, wp.zeros(1, dtype=int, device=CPU), scene_features(square.scene, lambertian=True))
    near = gather.gathered.nearness.numpy() > 1.0 / 0.004
    assert near.sum() > 0.8 * POINTS
    told = gather.gathered.radiance.numpy()[near] * np.pi / ALBEDO
    wanted = np.stack([weighted(light, place, np.float32([0.0, 1.0, 0.0])) for place in places[near]])
    assert told == pytest.approx(wanted, rel=0.03)
    assert wanted.max() > 1.2 * wanted.min()
