import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline, weight_kernel
from scenes import column, results, slats

from gpu.core.device import allocate
from gpu.gbuffer.gbuffer import GBuffer
from gpu.indirect.clustered_light import GUIDE_PARAMETERS, ClusteredLight, clustered_light
from gpu.indirect.far_field import FarLight
from gpu.sp.sp_clusters import SpClusters
from gpu.vpl.vpl_clusters import VplClusters

CPU = wp.get_device("cpu")


@pytest.fixture(scope="module")
def fuzzy() -> Pipeline:
    device_scene, camera, size = slats((24, 18))
    return Pipeline(device_scene, camera, size, sp_clusters=60)


def test_a_representative_that_is_turned_away_or_far_away_does_not_tell_an_sps_light(fuzzy: Pipeline) -> None:
    shares, clusters, count = fuzzy.shares(), fuzzy.clustering.clusters, fuzzy.sp_count
    weight = clusters.weight.numpy()[:, :count]
    plain = np.einsum("fs,fsv->sv", weight, fuzzy.beliefs()[clusters.cluster.numpy()[:, :count]])
    own, place = clusters.cluster.numpy()[:, :count], fuzzy.view.gbuffer.position.numpy()[fuzzy.pixels]
    off = np.linalg.norm(clusters.position.numpy()[own] - place[None], axis=2)
    normal = fuzzy.view.gbuffer.normal.numpy()[fuzzy.pixels]
    alike = (clusters.normal.numpy()[own] * normal[None]).sum(axis=2)
    knows = (off <= GUIDE_PARAMETERS.farthest * clusters.spacing.numpy()[own]) & (
        alike >= GUIDE_PARAMETERS.least_cosine
    )
    all_know = (knows | (weight == 0.0)).all(axis=0)
    assert 0.1 < all_know.mean() < 1.0
    assert np.allclose(shares[all_know], plain[all_know], atol=1e-5)
    some = ~all_know & (knows & (weight > 0.0)).any(axis=0)
    assert not np.allclose(shares[some], plain[some], atol=1e-2)


@pytest.mark.parametrize(
    ("spacings", "degrees", "share"),
    [(2.9, 0.0, 0.5), (3.1, 0.0, 0.0), (0.0, 36.0, 0.5), (0.0, 38.0, 0.0)],
)
def test_a_representative_knows_within_three_spacings_and_37_degrees(
    spacings: float, degrees: float, share: float
) -> None:
    gbuffer: GBuffer = allocate(GBuffer, 1, CPU)
    gbuffer.normal.fill_(wp.vec3(0.0, 1.0, 0.0))
    clusters: SpClusters = allocate(SpClusters, 2, CPU, 2)
    clusters.spacing.fill_(0.1)
    clusters.position.assign([[0.0, 0.0, 0.0], [0.1 * spacings, 0.0, 0.0]])
    turn = np.radians(degrees)
    clusters.normal.assign([[0.0, 1.0, 0.0], [np.sin(turn), np.cos(turn), 0.0]])
    clusters.cluster = wp.array([[0], [1]], dtype=int, device=CPU)
    clusters.weight = wp.array([[0.5], [0.5]], dtype=float, device=CPU)
    words = wp.zeros((2, 1), dtype=wp.uint32, device=CPU)
    known: ClusteredLight = clustered_light(clusters, words, VplClusters(), FarLight())
    weights = results(weight_kernel(2), 1, [gbuffer, column([0], int), known, 1], float, 2)
    assert weights.ravel() == pytest.approx([1.0 - share, share])
