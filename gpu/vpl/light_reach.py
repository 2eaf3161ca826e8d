"""How much of the power of a scene's kinds of emitters arrives where random walks from the cameras go
(gpu.vpl.camera_walks): of a sky's power, through a sphere around the scene, little comes into a room with a lamp.
"""

import numpy as np
import warp as wp

from gpu.core.device import duplicate, launch
from gpu.device_scene.specialisation import part_glass_of
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import power_cdf, probabilities
from gpu.lights.light_table import LightTable
from gpu.lights.path_light import kinds_of
from gpu.scene.types import Doubles
from gpu.vpl.camera_walks import walk_from_cameras
from gpu.vpl.emitter_importance import IMPORTANCE_PARAMETERS, lit_vertex_kernel

# Power tells of emitters as long as of no kind more than so many times its share arrives.
LEAST_CHANGE = 2.0


def light_reach(device_scene: DeviceScene, table: LightTable) -> Doubles | None:
    """Irradiance of walks' vertices for each part of all power, by `kinds_of` (kind,); of kinds without power, the most
    that others have. None where nothing is to be chosen by it: without a sky, with nothing else, without a camera, or
    where power tells as much.
    """
    if table.sky_count == 0 or table.count < 2 or not device_scene.scene.cameras:
        return None
    power, kinds, device = probabilities(table.all_emitters), kinds_of(table), device_scene.device
    scene = device_scene.view(lambertian=False)
    vertices = walk_from_cameras(device_scene, scene, IMPORTANCE_PARAMETERS.walks, IMPORTANCE_PARAMETERS.length)
    reach = np.full(3, -1.0)
    for kind in np.unique(kinds):
        own = np.where(kinds == kind, power, 0.0)
        if own.sum() == 0.0:
            continue
        alone = duplicate(LightTable, table)
        alone.all_emitters = power_cdf(own, device)
        emitter, worth, point = (
            wp.zeros(vertices.shape, dtype=dtype, device=device) for dtype in (int, float, wp.vec3)
        )
        inputs = [scene, alone, vertices, emitter, worth, point]
        launch(lit_vertex_kernel(part_glass_of(scene)), vertices.size, inputs, device)
        reach[kind] = worth.numpy().astype(np.float64).mean() / own.sum()
    reach = np.where(reach < 0.0, reach.max(), reach)
    return reach if reach[kinds].max() > LEAST_CHANGE * (power * reach[kinds]).sum() else None
