import numpy as np
import pytest
from pictures import CAMERA, SIZE, lamp_room

from gpu.core.parameters import parameters
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.view_state import ViewState
from gpu.sp.shading_clusters import ShadingClustering
from gpu.sp.variation_tree import SeedingParameters

CLUSTERS = 200


@pytest.fixture(scope="module")
def frame() -> FrameArrays:
    room = lamp_room()
    arrays, view = FrameArrays(room, SIZE, lambertian=True), ViewState(room, SIZE)
    view.set_camera(CAMERA)
    arrays.trace_primary_rays(view.camera)
    arrays.shading_points.find(arrays.gbuffer)
    return arrays


def clustered(frame: FrameArrays, **chosen: float) -> ShadingClustering:
    clustering = ShadingClustering(frame.shading_points, CLUSTERS, parameters(SeedingParameters, **chosen))
    clustering.run(frame.gbuffer, frame.seed)
    return clustering


def test_centres_are_shading_points_that_serve_all(frame: FrameArrays) -> None:
    clusters = clustered(frame).clusters
    used = clusters.spacing.numpy() > 0.0
    assert 0.9 * CLUSTERS < used.sum() <= CLUSTERS
    positions = frame.gbuffer.position.numpy()
    for name in ("position", "normal", "geometric_normal"):
        assert np.isfinite(getattr(clusters, name).numpy()[used]).all()
    away = np.linalg.norm(positions[:, None] - clusters.position.numpy()[used][None], axis=2)
    assert away.min(axis=0).max() == 0.0
    assert away.min(axis=1).max() < 0.25


def test_more_of_them_lie_at_edges_the_less_are_spread_evenly(frame: FrameArrays) -> None:
    """By the smaller spacing of those clusters whose points are few."""
    spread = {}
    for even in (0.0, 1.0):
        spacing = clustered(frame, even_share=even).clusters.spacing.numpy()
        used = spacing[spacing > 0.0]
        spread[even] = np.percentile(used, 90) / np.percentile(used, 10)
    assert spread[0.0] > 1.5 * spread[1.0]
