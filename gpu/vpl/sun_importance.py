"""Which of a sun's light matters: that which arrives where random walks from the cameras go (gpu.vpl.camera_walks)."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

from gpu.core.device import launch_together
from gpu.core.parameters import parameters
from gpu.device_scene.data import SceneData
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.rays import occluded
from gpu.device_scene.specialisation import made_for, part_glass_of, specialisation
from gpu.device_scene.upload import DeviceScene
from gpu.lights.light_table import DIRECTIONAL, FAR, LightTable
from gpu.lights.sun_map import SUN_MAP_PARAMETERS, SunMaps, cell_of, no_sun_maps, sun_maps
from gpu.sampling.warps import orthonormal
from gpu.scene.types import LightKind, Scene
from gpu.vpl.camera_walks import WalkVertex, has_ended, walk_from_cameras

# What a vertex that the sun meets head on counts, in whole numbers, whose sums do not depend on their order.
WHOLE = wp.constant(256.0)


@wp.struct
@dataclass
class WalkParameters:
    """walks: from all cameras together, of `length` vertices each; most_lights: so many first lights have maps."""

    walks: int = 32_768
    length: int = 6
    most_lights: int = 4


WALK_PARAMETERS: WalkParameters = parameters(WalkParameters)


@made_for("part_glass")
def sunlit_vertex_kernel(features: SceneFeatures) -> wp.Kernel:
    """The kernel for scenes of these `features`."""
    specialise = specialisation(features)

    @wp.kernel(module="unique")
    def sunlit_vertex_kernel(first: int, scene: SceneData, table: LightTable, vertices: wp.array2d[WalkVertex],
                             side: int, seen: wp.array2d[int]) -> None:  # fmt: skip
        """One thread a vertex of a walk: counts, in the cells of directional lights' maps, what these light of it.

        vertices (walk, vertex); seen: (light, cell) of side² cells, in WHOLE units of the cosine.
        """
        scene = specialise(scene)
        index = first + wp.tid()
        vertex = vertices[index // vertices.shape[1], index % vertices.shape[1]]
        if has_ended(vertex):
            return
        for light in range(seen.shape[0]):
            sun = table.lights[light]
            cosine = -wp.dot(vertex.normal, sun.direction)
            if sun.kind == DIRECTIONAL and cosine > 0.0:
                towards = offset_origin(vertex.position, vertex.normal, -sun.direction)
                if not occluded(scene, towards, -sun.direction, 2.0 * FAR):
                    at = wp.transpose(orthonormal(sun.direction)) * vertex.position / table.radius[0]
                    cell = cell_of(wp.vec2(at[0], at[1]), side)
                    wp.atomic_add(seen, light, cell, int(wp.ceil(WHOLE * cosine)))

    return sunlit_vertex_kernel


def suns_of(scene: Scene) -> tuple[Sequence[Any], Hashable]:
    """What maps of the lights of `scene` depend on besides its geometry: what suns there are, and what cameras see."""
    suns = [one.kind is LightKind.DIRECTIONAL and one.direction for one in scene.lights[: WALK_PARAMETERS.most_lights]]
    return tuple(suns), any(suns) and tuple(camera.view_key for camera in scene.cameras)


def sun_maps_of(device_scene: DeviceScene, table: LightTable, chosen: WalkParameters = WALK_PARAMETERS) -> SunMaps:
    """Maps of the directional lights among the first of `table`, by what the scene's cameras see; none without them."""
    scene, device = device_scene.scene, device_scene.device
    lights, side = scene.lights[: chosen.most_lights], SUN_MAP_PARAMETERS.side
    if not (scene.cameras and any(light.kind is LightKind.DIRECTIONAL for light in lights)):
        return no_sun_maps(device)
    data = device_scene.view(lambertian=False)
    vertices = walk_from_cameras(device_scene, data, chosen.walks, chosen.length)
    seen = wp.zeros((len(lights), side * side), dtype=int, device=device)
    inputs = [data, table, vertices, side, seen]
    launch_together(sunlit_vertex_kernel(part_glass_of(data)), vertices.size, inputs, device)
    return sun_maps(seen.numpy().reshape(len(lights), side, side), device)
