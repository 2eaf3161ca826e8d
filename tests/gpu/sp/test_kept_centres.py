from collections.abc import Iterator

import numpy as np
import pytest
from pictures import CAMERA, SIZE, lamp_room, mirror_room

from gpu.device_scene.upload import DeviceScene
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.gather_view_state import GatherViewState
from gpu.scene.camera import rotated
from gpu.scene.types import Floats
from gpu.sp.shading_clusters import ShadingClustering

CLUSTERS, DEGREES = 200, 2.0


class Walk:
    """Frames of a viewer that turns; what centres there are after each."""

    def __init__(self, room: DeviceScene, *, lambertian: bool = True) -> None:
        self.frame = FrameArrays(room, SIZE, lambertian=lambertian)
        self.view = GatherViewState(room, SIZE, CLUSTERS)
        self.clustering = ShadingClustering(self.frame.shading_points, CLUSTERS)

    def step(self, degrees: float, *, begins: bool = False) -> None:
        frame, view = self.frame, self.view
        view.set_camera(rotated(CAMERA, degrees))
        frame.trace_primary_rays(view.camera)
        frame.shading_points.find(frame.gbuffer)
        if begins:
            self.clustering.run(frame.gbuffer, frame.seed, view.centres)
        else:
            self.clustering.go_on(frame.gbuffer, frame.seed, view.centres, view.camera, SIZE)

    @property
    def centres(self) -> tuple[Floats, Floats]:
        """Positions of all clusters (cluster, 3), and which of them are in use."""
        clusters = self.clustering.clusters
        return clusters.position.numpy().copy(), clusters.spacing.numpy() > 0.0

    def distances(self) -> Floats:
        """Of each SP from the nearest centre, in spacings there."""
        positions, used = self.centres
        points, count = self.clustering.points, int(self.clustering.points.count.numpy()[0])
        way = points.position.numpy()[:count, None] - positions[used]
        return np.linalg.norm(way, axis=2).min(axis=1) / points.spacing.numpy()[:count]

    def kept_shares(self, steps: int) -> Iterator[float]:
        """Of the centres of each frame, the share that was there in the one before, by number and position."""
        self.step(0.0, begins=True)
        for number in range(1, steps):
            before, used_before = self.centres
            self.step(DEGREES * number)
            positions, used = self.centres
            kept = used & used_before & (positions == before).all(axis=1)
            yield float(kept.sum() / used.sum())


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return lamp_room()


def test_a_walk_keeps_its_centres_and_they_go_on_to_serve_all(room: DeviceScene) -> None:
    walk = Walk(room)
    walk.step(0.0, begins=True)
    begun = walk.distances()
    assert min(walk.kept_shares(9)) > 0.85
    _, used = walk.centres
    assert 0.8 * CLUSTERS < used.sum() <= CLUSTERS
    assert np.percentile(walk.distances(), 95) < 1.5 * np.percentile(begun, 95)


def test_a_view_of_another_wall_keeps_what_it_sees_of_the_first(room: DeviceScene) -> None:
    walk = Walk(room)
    walk.step(0.0, begins=True)
    before, _ = walk.centres
    walk.step(60.0)
    positions, used = walk.centres
    kept = used & (positions == before).all(axis=1)
    assert 0.05 * CLUSTERS < kept.sum() < 0.5 * CLUSTERS
    seen = walk.frame.gbuffer.position.numpy()
    away = np.linalg.norm(seen[None] - positions[used][:, None], axis=2).min(axis=1)
    assert (away < 2.0 * walk.clustering.points.spacing.numpy().max()).all()


def test_what_a_plane_mirror_shows_keeps_its_centres() -> None:
    walk = Walk(mirror_room(), lambertian=False)
    assert walk.frame.features.specular
    assert min(walk.kept_shares(5)) > 0.85


def test_centres_that_come_too_close_are_thinned_out(room: DeviceScene) -> None:
    """As many as before in a picture that shows them half as wide, of which some must go so that others can come."""
    walk = Walk(room)
    walk.step(0.0, begins=True)
    kept = walk.view.centres
    kept.position[CLUSTERS // 2 :].assign(kept.position.numpy()[: CLUSTERS - CLUSTERS // 2])
    for name in ("normal", "geometric_normal", "apparent", "used"):
        array = getattr(kept, name)
        array[CLUSTERS // 2 :].assign(array.numpy()[: CLUSTERS - CLUSTERS // 2])
    walk.step(0.0)
    positions, used = walk.centres
    assert len(np.unique(positions[used], axis=0)) > 0.9 * used.sum()
