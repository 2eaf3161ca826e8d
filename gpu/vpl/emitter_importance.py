"""Which emitters light what the cameras see: of fifty lamps those next door have most of the power, and would have most
of the light paths.

Random walks from the scene's cameras look for an emitter at each vertex, as importance is transported as light is (P.
Christensen, Adjoints and Importance in Rendering, 2003). Bounces lose nothing, so that rooms next door count, too.
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.color import brightness
from gpu.core.constants import RAY_LENGTH
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.rays import closest_hit, connected, offset_origin
from gpu.device_scene.surface import surface_at
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.camera_rays import CameraData, camera_data, camera_ray
from gpu.lights.build import power_cdf
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable, PowerCdf, choose_emitter
from gpu.sampling.sobol import sobol_pair
from gpu.sampling.warps import cosine_direction

PAIRS_A_VERTEX = wp.constant(3)


@wp.struct
@dataclass
class ImportanceParameters:
    """walks: from all cameras together, of `length` vertices each; power_share: of the choice that goes by power alone,
    since other places may see what those do not.
    """

    walks: int = 32_768
    length: int = 4
    power_share: float = 0.3


IMPORTANCE_PARAMETERS: ImportanceParameters = parameters(ImportanceParameters)


@wp.kernel
def lit_walk_kernel(first: int, scene: SceneData, table: LightTable, cameras: wp.array[CameraData], length: int,
                    emitter: wp.array[int], worth: wp.array[float]) -> None:  # fmt: skip
    """One thread a random walk from a camera: an emitter for each of its vertices, and its irradiance there [W/m²].

    emitter, worth (walk · vertex,): worth is 0 where nothing is lit.
    """
    walk = first + wp.tid()
    place = sobol_pair(walk, 0, 0)
    ray = camera_ray(cameras[walk % cameras.shape[0]], place.x, place.y)
    origin = ray.origin
    direction = ray.direction
    for vertex in range(length):
        hit = closest_hit(scene, origin, direction, RAY_LENGTH)
        if hit.face == NO_HIT:
            return
        surface = surface_at(scene, hit, direction)
        normal = surface.geometric_normal
        pair = 1 + PAIRS_A_VERTEX * vertex
        pick = sobol_pair(walk, pair, 0)
        sample = sample_light(scene, table, table.all_emitters, surface.position, pick.a, sobol_pair(walk, pair + 1, 0))
        cosine = wp.dot(sample.direction, normal)
        if cosine > 0.0:
            reached = connected(scene, surface.position, normal, sample.point, sample.normal)
            if reached:
                emitter[walk * length + vertex] = choose_emitter(table.all_emitters, pick.a).index
                worth[walk * length + vertex] = brightness(sample.irradiance) * cosine
        bounce = sobol_pair(walk, pair + 2, 0)
        direction = cosine_direction(normal, bounce.x, bounce.y)
        origin = offset_origin(surface.position, normal, direction)


def important_emitters(
    device_scene: DeviceScene, scene: SceneData, table: LightTable, chosen: ImportanceParameters = IMPORTANCE_PARAMETERS
) -> PowerCdf:
    """A choice among all emitters of `table` by what they bring to where the cameras of `device_scene` look."""
    device, count = device_scene.device, table.count
    power = np.diff(table.all_emitters.cumulative.numpy().astype(np.float64), prepend=0.0)
    cameras = device_scene.scene.cameras
    if count < 2 or not cameras:
        return power_cdf(power, device)
    views = [camera_data(camera, device_scene.scene.placement, 1.0) for camera in cameras]
    found = chosen.walks * chosen.length
    emitter, worth = (wp.zeros(found, dtype=dtype, device=device) for dtype in (int, float))
    inputs = [scene, table, wp.array(views, dtype=CameraData, device=device), chosen.length, emitter, worth]
    launch(lit_walk_kernel, chosen.walks, inputs, device)
    importance = np.bincount(emitter.numpy(), worth.numpy().astype(np.float64), minlength=count)
    if importance.sum() == 0.0:
        return power_cdf(power, device)
    by_power, by_worth = chosen.power_share * power / power.sum(), (1.0 - chosen.power_share) * importance
    return power_cdf(by_power + by_worth / importance.sum(), device)
