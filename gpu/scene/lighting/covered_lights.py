"""Lights that a small closed surface covers, such as bulbs that are modelled opaque: nothing around gets their light.

Viewers without shadows show them shining all the same, so that whoever has made the file may not know.
"""

import numpy as np

from gpu.scene.geometry.boxes import lengths
from gpu.scene.geometry.host_rays import HostRays, solid_triangles
from gpu.scene.remarks import Remarks
from gpu.scene.types import Doubles, LightKind, Scene

_REACH = 0.05  # of what covers a light, in parts of the scene's extent
_WAYS = 64
_MOST_LIGHTS, _MOST_DISTANCES = 64, 5e7  # that are looked at, and of triangles from all of these


def covered_lights(scene: Scene) -> tuple[str, ...]:
    """What is to be said of lights that are covered, and by which object."""
    lights = [it for it in scene.lights if it.kind is not LightKind.DIRECTIONAL and max(it.intensity) > 0.0]
    lets_through = np.array([material.transmission > 0.0 for material in scene.materials])
    triangles = scene.triangles[solid_triangles(scene) & ~lets_through[scene.triangle_material]]
    notes, first = Remarks(), scene.vertices[triangles[:, 0]].astype(np.float64) if lights else np.zeros((0, 3))
    ways = np.random.default_rng(0).normal(size=(_WAYS, 3))
    ways /= lengths(ways)[:, None]
    for light in lights[: int(np.clip(_MOST_DISTANCES / max(len(triangles), 1), 1, _MOST_LIGHTS))]:
        place = np.asarray(light.position)
        near = triangles[_squares(first - place) < _REACH**2]
        near = near[(_squares(scene.vertices[near] - place) < _REACH**2).all(axis=1)]
        rays = HostRays(scene.vertices, near)
        hits = [rays.first(place, way)[1] for way in ways] if len(near) else [-1]
        if min(hits) >= 0:
            object_ = scene.objects[int(scene.vertex_object[near[hits[0], 0]])]
            problem = (
                f"it is covered by “{object_}”, which lets none of its light out: hide that, or have it be of glass"
            )
            notes.add(problem, light.name, kind="covered")
    return notes.sentences()


def _squares(vectors: Doubles) -> Doubles:
    return np.asarray((vectors * vectors).sum(axis=-1))
