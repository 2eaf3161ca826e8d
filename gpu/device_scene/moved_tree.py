"""A tree that is fitted again and again to where its triangles are (gpu.device_scene.bvh_refit), as while somebody
drags an object, for as long as rays do not look at much more in it than before.

What the host has to know of it is read once, so that it need not wait for the device in an edit; and a GPU replays the
many small launches as a graph.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages
from gpu.core.staging_buffer import StagingBuffer
from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_refit import refit
from gpu.device_scene.data import SceneData
from gpu.device_scene.ray_cost import RAY_COST_PARAMETERS, count_looks, ray_costs
from gpu.device_scene.repeated import NO_TWIN, distinct
from gpu.scene.types import Floats, Ints

# Of what rays looked at before: where a tree that is fitted to what has moved costs them more, another is made.
MOST_COST = 1.5


@dataclass(frozen=True, eq=False)
class TreeFacts:
    """Of a tree over the scene's triangles from `begin` on: the first nodes of its levels, and after the last one how
    many nodes there are; its triangles' first vertex, and the one after their last; at how much rays look in the mean;
    twins (pair, 2, corner): the vertices of triangles that it leaves out, and of others that lay in their places.
    """

    begin: int
    levels: tuple[int, ...]
    vertices: tuple[int, int]
    usual: float
    twins: Ints

    def has_any(self, begin: int, end: int) -> bool:
        """Whether some of the vertices from `begin` to `end` may be of its triangles."""
        return begin < self.vertices[1] and end > self.vertices[0]

    def holds(self, vertices: Floats) -> bool:
        """Whether what it leaves out still lies where something else does. What has come to lie in one place since is
        in it, which shows the same.
        """
        return np.array_equal(vertices[self.twins[:, 0]], vertices[self.twins[:, 1]])


def facts_of(scene: SceneData, tree: Bvh, begin: int, end: int, *, looks: bool) -> TreeFacts:
    """Of the `tree` over the triangles from `begin` to `end` of `scene` (gpu.device_scene.trees.tree_over)."""
    triangles, corners = scene.triangles[begin:end].numpy(), np.zeros((0, 2, 3), np.int32)
    if len(tree.faces) < end - begin:
        twins = distinct(scene, begin, end, looks=looks)[1].numpy()
        left_out = np.flatnonzero(twins != NO_TWIN)
        corners = triangles[np.stack([left_out, twins[left_out]], axis=1)]
    # Levels that there are not have no nodes.
    levels = dict.fromkeys(tree.levels.numpy().tolist())
    vertices = int(triangles.min()), int(triangles.max()) + 1
    return TreeFacts(begin, tuple(levels), vertices, float(ray_costs(tree).mean()), corners)


class MovedTree:
    """Fits a tree that has these facts, and learns what rays look at in it since."""

    def __init__(self, facts: TreeFacts, device: wp.Device) -> None:
        self.facts = facts
        self._stages = Stages(device)
        self._costs = StagingBuffer(wp.zeros(RAY_COST_PARAMETERS.rays, dtype=int, device=device))
        self._counted = wp.Event(device) if device.is_cuda else None

    def fit(self, tree: Bvh, scene: SceneData) -> None:
        """Have `tree` follow the triangles of `scene`."""
        arrays = tree.bounds, tree.corners, scene.vertices, scene.triangles
        self._stages.graph_key = tuple(array.ptr for array in arrays)
        self._stages.run_untimed(lambda: self._launch(tree, scene))
        with DEVICE_SHARING.keep():  # a graph has no slices
            self._stages.flush()
        if self._counted is not None:
            wp.get_stream(tree.faces.device).record_event(self._counted)

    def _launch(self, tree: Bvh, scene: SceneData) -> None:
        refit(tree, self.facts.levels, scene.vertices, scene.triangles, self.facts.begin)
        count_looks(tree, self._costs.array)
        self._costs.download()

    def is_dear(self) -> bool:
        """Whether rays look at much more in the tree, as it was fitted last, than they did, or at too much."""
        if self._counted is not None:
            wp.synchronize_event(self._counted)
        costs = self._costs.host
        return bool(costs.max() >= RAY_COST_PARAMETERS.most or costs.mean() > MOST_COST * self.facts.usual)
