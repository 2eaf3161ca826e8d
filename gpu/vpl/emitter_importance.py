"""Which emitters light what the cameras see: of fifty lamps those next door have most of the power, and would have most
of the light paths.

At each vertex of random walks from the scene's cameras an emitter is looked for (gpu.vpl.camera_walks).
"""

from dataclasses import dataclass

import numpy as np
import warp as wp

from gpu.core.color import brightness
from gpu.core.device import launch
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.rays import connected
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import power_cdf, probabilities
from gpu.lights.light_sampling import sample_light
from gpu.lights.light_table import LightTable, PowerCdf, choose_emitter
from gpu.sampling.sobol import sobol_pair
from gpu.vpl.camera_walks import WalkVertex, has_ended, walk_from_cameras


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


@made_for("part_glass")
def lit_vertex_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def lit_vertex_kernel(first: int, scene: SceneData, table: LightTable, vertices: wp.array2d[WalkVertex],
                          emitter: wp.array2d[int], worth: wp.array2d[float],
                          point: wp.array2d[wp.vec3]) -> None:  # fmt: skip
        """One thread a vertex of a walk: an emitter for it, its irradiance there [W/m²], and the point it is from.

        vertices, emitter, worth, point (walk, vertex): worth is left as it is where nothing is lit.
        """
        scene = specialise(scene)
        length = vertices.shape[1]
        walk = (first + wp.tid()) // length
        place = (first + wp.tid()) % length
        vertex = vertices[walk, place]
        if has_ended(vertex):
            return
        pair = 1 + length + 2 * place  # those of the walk itself come before
        pick = sobol_pair(walk, pair, 0)
        sample = sample_light(scene, table, table.all_emitters, vertex.position, pick.a, sobol_pair(walk, pair + 1, 0))
        cosine = wp.dot(sample.direction, vertex.normal)
        if cosine > 0.0:
            reached = connected(scene, vertex.position, vertex.normal, sample.point, sample.normal)
            if reached:
                emitter[walk, place] = choose_emitter(table.all_emitters, pick.a).index
                worth[walk, place] = brightness(sample.irradiance) * cosine
                point[walk, place] = sample.point

    return lit_vertex_kernel


def important_emitters(device_scene: DeviceScene, scene: SceneData, table: LightTable) -> PowerCdf:
    """A choice among all emitters of `table` by what they bring to where the cameras of `device_scene` look."""
    device, count, chosen = device_scene.device, table.count, IMPORTANCE_PARAMETERS
    power = probabilities(table.all_emitters)
    if count < 2 or not device_scene.scene.cameras:
        return power_cdf(power, device)
    vertices = walk_from_cameras(device_scene, scene, chosen.walks, chosen.length)
    emitter, worth, point = (wp.zeros(vertices.shape, dtype=dtype, device=device) for dtype in (int, float, wp.vec3))
    inputs = [scene, table, vertices, emitter, worth, point]
    launch(lit_vertex_kernel(part_glass_of(scene)), vertices.size, inputs, device)
    found = worth.numpy().astype(np.float64)
    importance = np.bincount(emitter.numpy().ravel(), found.ravel(), minlength=count)
    if importance.sum() == 0.0:
        return power_cdf(power, device)
    by_power, by_worth = chosen.power_share * power / power.sum(), (1.0 - chosen.power_share) * importance
    return power_cdf(by_power + by_worth / importance.sum(), device)
