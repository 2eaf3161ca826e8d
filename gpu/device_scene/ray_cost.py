"""What a ray has to look at in the worst places of a tree.

Where many triangles lie in nearly one place, their boxes overlap and no tree tells them apart: a million of them, in a
file of a few megabytes, would take each ray a million tests. Equal ones are left out (gpu.device_scene.repeated); what
all others cost is counted by rays that meet some of them. Rooms and halls take 20 to 460.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.constants import RAY_LENGTH
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.bvh import Bvh, looks
from gpu.errors import SceneError
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cone_direction
from gpu.scene.types import Ints, Scene

# Rays begin so far from what they meet, in unit space: some behind all that may hide it, some within it.
NEAREST, TIMES, DISTANCES = wp.constant(0.001), wp.constant(8.0), wp.constant(4)


@wp.struct
@dataclass
class RayCostParameters:
    """rays: that are traced, each to a triangle of its own; most: nodes and triangles that one may have to look at."""

    rays: int = 2048
    most: int = 8192


RAY_COST_PARAMETERS: RayCostParameters = parameters(RayCostParameters)


@wp.kernel
def ray_cost_kernel(first: int, bvh: Bvh, most: int, costs: wp.array[int]) -> None:
    """One thread a ray to the middle of a triangle, from some direction: at how much it looks. costs (ray,)."""
    ray = first + wp.tid()
    place = int(wp.int64(ray) * wp.int64(bvh.faces.shape[0]) / wp.int64(costs.shape[0]))
    corners = bvh.corners[3 * place] + bvh.corners[3 * place + 1] + bvh.corners[3 * place + 2]
    point = sobol_pair(ray, 0, 0)
    direction = cone_direction(wp.vec3(0.0, 0.0, 1.0), -1.0, point.x, point.y)
    distance = NEAREST * wp.pow(TIMES, float(ray % DISTANCES))
    origin = wp.vec3(corners[0], corners[1], corners[2]) / 3.0 - direction * distance
    costs[ray] = looks(bvh, origin, direction, RAY_LENGTH, False, False, most)


def ray_costs(bvh: Bvh) -> Ints:
    """At how many nodes and triangles of a tree rays to its triangles look, shape (ray,), as far as it is counted."""
    costs = wp.zeros(RAY_COST_PARAMETERS.rays, dtype=int, device=bvh.faces.device)
    count_looks(bvh, costs)
    return np.asarray(costs.numpy())


def count_looks(bvh: Bvh, costs: wp.array) -> None:
    """As `ray_costs`, into an array of a device (ray,)."""
    launch(ray_cost_kernel, RAY_COST_PARAMETERS.rays, [bvh, RAY_COST_PARAMETERS.most, costs], bvh.faces.device)


def check_ray_cost(scene: Scene, bvh: Bvh) -> None:
    """Raise SceneError where a ray has to look at too much in a tree over triangles of `scene`."""
    costs = ray_costs(bvh)
    worst = int(costs.argmax())
    if costs[worst] < RAY_COST_PARAMETERS.most:
        return
    place = worst * len(bvh.faces) // len(costs)
    middle = bvh.corners[3 * place : 3 * place + 3].numpy()[:, :3].mean(axis=0).astype(float)
    x, y, z = scene.frame.to_file(middle / scene.placement.scale + np.array(scene.placement.centre))
    raise SceneError(
        scene.name,
        f"triangles around ({x:.6g}, {y:.6g}, {z:.6g})",
        f"thousands overlap there, so that a ray has to look at more than {RAY_COST_PARAMETERS.most:,}: leave one of "
        "those that lie in nearly one place",
    )
