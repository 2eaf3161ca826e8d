"""Whether the light of a scene stays within it, as that of lamps in a room without windows does."""

from collections.abc import Iterator

import numpy as np

from gpu.scene.geometry.boxes import lengths
from gpu.scene.geometry.host_rays import HostRays, solid_triangles
from gpu.scene.geometry.normals import area_vectors
from gpu.scene.lighting.added_daylight import has_sun
from gpu.scene.types import Doubles, Scene

_LAMPS = 8  # the largest emissive triangles, and as many lights
_MOST_WAYS, _LEAST_WAYS = 32, 4  # from each lamp
_TESTS = 2e8  # of rays against triangles, if so many ways leave more than the least
_LIFT = 1e-5


def is_shut_in(scene: Scene) -> bool:
    """Whether there are lamps, and all ways from them end at surfaces that stop light; a sky and a sun are outside."""
    if scene.sky is not None or has_sun(scene):
        return False
    rays = HostRays(scene.vertices, scene.triangles[solid_triangles(scene)])
    ways = int(np.clip(_TESTS / len(scene.triangles) / _LAMPS, _LEAST_WAYS, _MOST_WAYS))
    origin = None
    for origin, direction in _ways_from_lamps(scene, ways):
        if rays.first(origin, direction)[1] < 0:
            return False
    return origin is not None


def _ways_from_lamps(scene: Scene, count: int) -> Iterator[tuple[Doubles, Doubles]]:
    """Points of lamps, and unit directions of light from there, `count` of each lamp."""
    random = np.random.default_rng(0)
    places = [(np.asarray(light.position), None) for light in scene.lights[:_LAMPS] if max(light.intensity) > 0.0]
    emits = np.array([material.emits and not material.backdrop for material in scene.materials])
    lamps = scene.triangles[emits[scene.triangle_material]]
    faces = area_vectors(scene.vertices.astype(np.float64), lamps)
    areas = lengths(faces)
    for number in np.argsort(areas)[::-1][:_LAMPS].tolist():
        normal = faces[number] / areas[number]
        places.append((scene.vertices[lamps[number]].astype(np.float64).mean(axis=0) + _LIFT * normal, normal))
    for place, normal in places:
        for _ in range(count):
            way = random.normal(size=3)
            if normal is not None and way @ normal < 0.0:
                way = -way
            yield place, way / np.linalg.norm(way)
