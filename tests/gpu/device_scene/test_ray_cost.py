from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from devices import DEVICES

from gpu.device_scene.bvh import Bvh
from gpu.device_scene.bvh_build import build
from gpu.device_scene.ray_cost import check_ray_cost, ray_costs
from gpu.errors import SceneError
from gpu.scene.file_frame import FileFrame
from gpu.scene.load import load_scene
from gpu.scene.types import Doubles, Placement

CORNERS = np.array([[-0.3, -0.3, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0]])
ROOM = replace(
    load_scene("cornell-box"),
    name="hall",
    placement=Placement((1.0, 0.0, 0.0), 0.1),
    frame=FileFrame("y", 0.001, (500.0, 0.0, 0.0)),
)


def stacked(count: int, apart: float, device: str = "cpu") -> Bvh:
    """A tree over triangles in nearly one place."""
    moves = np.random.default_rng(count).uniform(-apart, apart, (count, 3, 3))
    return tree(CORNERS + moves, device)


def tree(triangles: Doubles, device: str = "cpu") -> Bvh:
    vertices = wp.array(triangles.reshape(-1, 3).astype(np.float32), dtype=wp.vec3, device=device)
    indices = wp.array(np.arange(3 * len(triangles)), dtype=int, device=device)
    return build(vertices, indices, wp.zeros(len(triangles), dtype=float, device=device))


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("apart", [0.0, 1e-6, 1e-3])
def test_rays_look_at_all_triangles_that_lie_in_nearly_one_place(apart: float, device: str) -> None:
    costs = ray_costs(stacked(500, apart, device))
    assert 450 <= costs.max() <= 750  # but those that lie beside others, and at the nodes above them
    assert len(costs) == 2048


def test_triangles_that_lie_apart_cost_little() -> None:
    moves = np.random.default_rng(1).uniform(-0.5, 0.5, (5000, 1, 3))
    assert ray_costs(tree(0.02 * CORNERS + moves)).max() < 200
    assert ray_costs(tree(CORNERS[None])).tolist() == [2] * 2048  # the root, and the triangle


@pytest.mark.parametrize("apart", [0.0, 1e-6])
def test_thousands_that_overlap_are_refused_with_their_place(apart: float) -> None:
    """The place in the file's coordinates: a unit of the scene is 10 m, 1 m from the world's middle."""
    check_ray_cost(ROOM, stacked(5000, apart))
    with pytest.raises(SceneError, match=r"^hall: triangles around \((1500|1[45]\d\d\.\S*), .*more than 8,192"):
        check_ray_cost(ROOM, stacked(10_000, apart))
