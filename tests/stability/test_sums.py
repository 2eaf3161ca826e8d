"""Sums of very many VPLs in float32 against the same sums in float64."""

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from lit_surfaces import cluster_vpls
from scenes import column, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.indirect.clustered_light import clustered_light
from gpu.indirect.exact_gather import gather
from gpu.indirect.far_field import FarSums
from gpu.indirect.fuzzy_shading import shade
from gpu.indirect.visibility import Visibility
from gpu.lights.light_paths import Vpls, allocate_vpls
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Floats
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.build import unclustered
from gpu.vpl.vpl_clusters import VplClusters

COUNT = 100_000


@pytest.fixture(scope="module")
def view(device: str) -> FrameView:
    """A floor seen from above, two dozen SPs."""
    device_scene = resident_of([quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0))], [grey(0.6)], device=device)
    view = FrameView(device_scene, (6, 4), lambertian=True)
    view.set_camera(look_at((0.0, 0.4, 0.1), (0.0, 0.0, 0.0)))
    view.find_shading_points()
    return view


@pytest.fixture(scope="module")
def vpls(view: FrameView) -> Vpls:
    """VPLs at random places over the floor, facing down."""
    rng = np.random.default_rng(1)
    vpls = allocate_vpls(COUNT, view.device)
    vpls.position = column(rng.uniform((-0.5, 0.3, -0.5), (0.5, 0.5, 0.5), (COUNT, 3)), wp.vec3, view.device)
    vpls.normal = column(np.tile((0.0, -1.0, 0.0), (COUNT, 1)), wp.vec3, view.device)
    vpls.flux = column(rng.uniform(0.0, 1e-3, (COUNT, 3)), wp.vec3, view.device)
    return vpls


@pytest.fixture(scope="module")
def cluster(view: FrameView, vpls: Vpls) -> VplClusters:
    """All of them as one cluster."""
    return cluster_vpls(view.device_scene, vpls, 1, 0)


def expected(view: FrameView, cluster: VplClusters, weight: Doubles | float = 1.0) -> Doubles:
    """The irradiance of each pixel in float64, each VPL with a `weight` (vpl,) of its own."""
    members = cluster.members
    place = view.gbuffer.position.numpy().astype(np.float64)
    ways = members.position.numpy().astype(np.float64)[None] - place[:, None]
    squared = (ways**2).sum(axis=2)
    flux = members.flux.numpy().astype(np.float64)
    area = float(cluster.disks.numpy()["area"][0]) * flux.sum(axis=1) / flux.sum()
    share = weight * ways[..., 1] ** 2 / (squared * (np.pi * squared + area))
    return np.asarray(share @ flux)


def error(picture: Floats, reference: Doubles) -> float:
    """The largest relative error of a channel of a pixel."""
    return float(np.abs(picture / reference - 1.0).max())


def test_the_flux_of_a_cluster(vpls: Vpls, cluster: VplClusters) -> None:
    assert error(cluster.disks.numpy()["flux"], vpls.flux.numpy().sum(axis=0, dtype=np.float64)[None]) < 1e-6


def test_rays_to_every_vpl(view: FrameView, cluster: VplClusters) -> None:
    singles = unclustered(view.device_scene, cluster)
    for run in (COUNT, 7):
        for begin in range(0, COUNT, run):
            gather(
                view.scene, view.gbuffer, view.shading_points, singles, begin, min(begin + run, COUNT), view.indirect
            )
        assert error(view.indirect.irradiance.numpy(), expected(view, cluster)) < 1e-6


def test_the_members_of_a_cluster_that_is_near(view: FrameView, cluster: VplClusters) -> None:
    gather(view.scene, view.gbuffer, view.shading_points, cluster, 0, 1, view.indirect)
    # Twigs stand for those of them that are farther away.
    assert error(view.indirect.irradiance.numpy(), expected(view, cluster)) < 1e-4


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_clusters_of_shading_points_that_see_different_vpls(
    view: FrameView, cluster: VplClusters, share: float
) -> None:
    """Every SP has `share` of a cluster that sees all and the rest of one that sees every other VPL."""
    singles, sps = unclustered(view.device_scene, cluster), view.shading_points
    visibility = Visibility(2, COUNT, view.device)
    words = np.full((2, COUNT // 32), 0xFFFFFFFF, np.uint32)
    words[1] = 0x55555555
    visibility.words.assign(words)
    clusters: SpClusters = allocate(SpClusters, 2, view.device)
    clusters.cluster = wp.zeros((2, view.pixels), dtype=int, device=view.device)
    clusters.weight = wp.zeros((2, view.pixels), dtype=float, device=view.device)
    clusters.cluster.assign(np.tile([[0], [1]], (1, view.pixels)).astype(np.int32))
    clusters.weight.assign(np.tile([[share], [1.0 - share]], (1, view.pixels)).astype(np.float32))
    clusters.used.fill_(1)
    clusters.fresh.fill_(2)
    clusters.order.assign(np.arange(2, dtype=np.int32))
    far = FarSums(2, COUNT, view.device, enabled=False)
    far.run(clusters, visibility.words, singles, few=False)
    known = clustered_light(clusters, visibility.words, singles, far.data)
    shade(2, view.gbuffer, sps, known, view.seed, view.indirect)
    weight = np.where(np.arange(COUNT) % 2 == 0, 1.0, share)
    assert error(view.indirect.irradiance.numpy(), expected(view, cluster, weight)) < 1e-6
