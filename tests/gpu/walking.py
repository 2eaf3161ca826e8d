"""A room that a camera walks through, and what its SP clusters see."""

from dataclasses import dataclass, field

import numpy as np
import pytest
import warp as wp
from frame_view import FrameView
from lit_surfaces import cluster_vpls
from scenes import box, column, grey, quad, resident_of, traced_vpls

from gpu.device_scene.upload import DeviceScene
from gpu.indirect.visibility import Visibility
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles
from gpu.sp.budget import ClusterBudget
from gpu.sp.sp_clustering import SpClustering
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT, SpClusters
from gpu.vpl.vpl_clusters import VplClusters

SIZE = (64, 48)


def pose(step: float) -> Camera:
    """A camera on a path to the right that turns to the left."""
    return look_at((0.01 * step, 0.0, 0.45), (-0.03 * step, -0.1, -0.5), yfov_degrees=75.0)


def slow_pose(step: float) -> Camera:
    """A camera that turns and steps aside: half a pixel a step, about."""
    return look_at((0.003 * step, 0.0, 0.45), (-0.006 * step, -0.1, -0.5), yfov_degrees=75.0)


def furnished() -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)])


def budget_of(wanted: int, accepted_distance: float, max_new: int = 1000, extent: int = 0) -> ClusterBudget:
    """A walk's budget of so many clusters."""
    budget = ClusterBudget()
    budget.wanted, budget.base, budget.max_new, budget.extent = (
        column([number], wp.int32) for number in (wanted, wanted, max_new, extent)
    )
    budget.spacing_scale, budget.accepted_distance = column([1.0], float), column([accepted_distance], float)
    return budget


@dataclass
class Walk:
    """A walk's clusters, for which there is a little room more, and what they see."""

    device_scene: DeviceScene
    size: tuple[int, int] = SIZE
    count: int = 300
    most: int = 300
    view: FrameView = field(init=False)
    clustering: SpClustering = field(init=False)
    lights: VplClusters = field(init=False)
    visibility: Visibility = field(init=False)

    def __post_init__(self) -> None:
        self.view = FrameView(self.device_scene, self.size, lambertian=True)
        self.clustering = SpClustering(self.view.shading_points, self.most, 6, by_distance=True)
        self.clustering.use(self.count)
        vpls = traced_vpls(self.device_scene, self.view.scene, 2000, 3)
        self.lights = cluster_vpls(self.device_scene, vpls, 70, 0)
        self.visibility = Visibility(self.most, max(self.lights.count, 1), self.view.device)

    def step(self, camera: Camera, *, begins: bool = False) -> None:
        """One frame, the first or one that goes on."""
        view = self.view
        view.set_camera(camera)
        view.find_shading_points()
        if begins:
            self.clustering.run(view.gbuffer, 0)
        else:
            self.clustering.go_on(view.gbuffer, view.camera, view.size)
        self.visibility.trace(view.scene, self.clustering.clusters, self.lights)

    @property
    def clusters(self) -> SpClusters:
        return self.clustering.clusters

    @property
    def used(self) -> np.ndarray:
        return np.asarray(self.clusters.used.numpy(), bool)

    @property
    def fresh(self) -> np.ndarray:
        """The clusters that are new, in order."""
        return np.asarray(self.clusters.order.numpy()[: int(self.clusters.fresh.numpy()[0])])

    @property
    def kept(self) -> np.ndarray:
        """Which clusters are of the frame before."""
        kept = self.used
        kept[self.fresh] = False
        return kept

    def spacing(self) -> Doubles:
        """Of each cluster in this view."""
        return np.asarray(self.clustering._kept.grid.data.spacing.numpy(), np.float64)

    @property
    def accepted_distance(self) -> float:
        """The distance from its nearest representative that an SP accepts [spacings]."""
        return float(self.clustering._kept.budget.accepted_distance.numpy()[0])

    def assert_served(self) -> None:
        """Every SP has clusters in use whose shares add up to 1."""
        sps = int(self.view.shading_points.count.numpy()[0])
        cluster, weight = self.clusters.cluster.numpy()[:, :sps], self.clusters.weight.numpy()[:, :sps]
        assert weight.sum(axis=0) == pytest.approx(1.0, abs=1e-5)
        assert self.used[cluster[weight > 0.0]].all()
        assert (self.clustering.deficit.numpy()[:sps] < int(UNASSIGNED_DEFICIT)).all()
