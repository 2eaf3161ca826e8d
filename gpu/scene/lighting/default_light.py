"""Light for a scene that has none: a soft sky where it reaches what a camera sees, else a lamp among that."""

from dataclasses import dataclass, replace

import numpy as np

from gpu.scene.geometry.host_rays import HostRays, solid_triangles
from gpu.scene.types import Camera, Doubles, Light, LightKind, Mask, Rgb, Scene, Sky

SOFT_SKY = Sky((1.0, 1.0, 1.0))
_ACROSS, _DOWN = 6, 4  # places in the picture that are looked at
_WAYS = 6  # from each to the sky
_LAMPS = 5  # places that a lamp is tried at, besides the camera's
_TESTS = 2e8  # of rays against triangles: as many rays as these allow, but so many at least
_NEARLY = 0.8
_LEAST_SEEN = 4
_LIFT = 1e-5
_NO_LIGHT = "the scene has no light"


@dataclass(frozen=True, eq=False)
class _Seen:
    """A point that a camera sees, in unit space, and the unit normal of its side."""

    position: Doubles
    normal: Doubles


def with_default_light(scene: Scene) -> Scene:
    """`scene`, in which nothing emits, with a light that reaches what its first camera sees; its notes say which."""
    kept = solid_triangles(scene)
    rays = HostRays(scene.vertices, scene.triangles[kept])
    one_sided = np.array([m.double_sided is False for m in scene.materials])[scene.triangle_material[kept]]
    count = int(np.clip(_TESTS / len(scene.triangles) / (_WAYS + _LAMPS + 2), _LEAST_SEEN, _ACROSS * _DOWN))
    seen = _seen(scene, rays, one_sided, count)
    if not seen or _sky_reaches(rays, seen):
        return _noted(replace(scene, sky=SOFT_SKY), f"{_NO_LIGHT}: a soft sky from above was added")
    lamp = _lamp(rays, seen, _eye(scene))
    where = " ".join(
        f"{value:.4g}" for value in np.array(lamp.position) / scene.placement.scale + scene.placement.centre
    )
    said = f"{_NO_LIGHT}, and no sky would reach what its camera sees: a lamp was added at {where}"
    return _noted(replace(scene, lights=(lamp,)), said)


def without_default_light(scene: Scene) -> Scene:
    """`scene` without what `with_default_light` added to it, if that did."""
    notes = tuple(note for note in scene.report.notes if not note.startswith(_NO_LIGHT))
    if len(notes) == len(scene.report.notes):
        return scene
    return replace(scene, lights=(), sky=None, report=replace(scene.report, notes=notes))


def _noted(scene: Scene, sentence: str) -> Scene:
    return replace(scene, report=replace(scene.report, notes=(*scene.report.notes, sentence)))


def _eye(scene: Scene) -> Doubles:
    camera = scene.cameras[0]
    return np.asarray((camera.to_world[:3, 3] - scene.placement.centre) * scene.placement.scale)


def _seen(scene: Scene, rays: HostRays, one_sided: Mask, count: int) -> list[_Seen]:
    """Points that the first camera sees, at `count` places of its picture at the most."""
    camera, eye, points = scene.cameras[0], _eye(scene), []
    places = [(x, y) for y in range(_DOWN) for x in range(_ACROSS)]
    for x, y in (places[number] for number in np.linspace(0, len(places) - 1, count).astype(int)):
        origin, direction = _ray(camera, eye, scene.placement.scale, (x + 0.5) / _ACROSS, (y + 0.5) / _DOWN)
        distance, face = rays.first(origin, direction, one_sided)
        if face >= 0:
            normal = rays.normal(face)
            normal = -normal if normal @ direction > 0.0 else normal
            points.append(_Seen(origin + distance * direction + _LIFT * normal, normal))
    return points


def _ray(camera: Camera, eye: Doubles, scale: float, x: float, y: float) -> tuple[Doubles, Doubles]:
    """Origin and unit direction of the camera's ray through (x, y) in [0, 1]² of its picture, in unit space."""
    axes = camera.to_world[:3, :3] / np.linalg.norm(camera.to_world[:3, :3], axis=0)
    aside = np.array([(2.0 * x - 1.0) * camera.aspect, 1.0 - 2.0 * y, 0.0]) * camera.half_height
    if camera.orthographic:
        return eye + axes @ (aside * scale) - axes[:, 2] * camera.near * scale, -axes[:, 2]
    ahead = aside - [0.0, 0.0, 1.0]
    return eye + axes @ ahead * camera.near * scale, axes @ ahead / np.linalg.norm(ahead)


def _sky_reaches(rays: HostRays, seen: list[_Seen]) -> bool:
    """Whether the sky, of which there is nothing straight below, is seen from any of the points that are seen."""
    random = np.random.default_rng(0)
    for _ in range(_WAYS):
        for point in seen:
            way = random.normal(size=3)
            way = way / np.linalg.norm(way) + 1.001 * point.normal
            way /= np.linalg.norm(way)
            if way[1] > -0.5 and rays.first(point.position, way)[1] < 0:
                return True
    return False


def _lamp(rays: HostRays, seen: list[_Seen], eye: Doubles) -> Light:
    """A lamp that points which are `seen` see: at the camera, or half-way from one of them to what it faces.

    Of the places that nearly as many see as the best one, it is at that with most room: light of a lamp beside a wall
    would nearly all be a spot on that.
    """
    places = [eye]
    for point in seen[:: max(1, len(seen) // _LAMPS)]:
        distance, _ = rays.first(point.position, point.normal)
        places.append(point.position + point.normal * min(distance, 1.0) / 2.0)
    lit = [[_distance(rays, point, place) for point in seen] for place in places]
    reached = np.array([sum(distance > 0.0 for distance in distances) for distances in lit])
    best = max(np.flatnonzero(reached >= _NEARLY * reached.max()), key=lambda place: _room(rays, places[place]))
    typical = float(np.median([distance for distance in lit[best] if distance > 0.0] or [1.0]))
    position: Rgb = (float(places[best][0]), float(places[best][1]), float(places[best][2]))
    return Light("added lamp", LightKind.POINT, (np.pi * typical**2,) * 3, position)


def _room(rays: HostRays, place: Doubles) -> float:
    """How far it is from a place to the nearest thing along the axes."""
    return min(rays.first(place, way)[0] for way in (*np.eye(3), *-np.eye(3)))


def _distance(rays: HostRays, point: _Seen, place: Doubles) -> float:
    """How far `place` is from a point that sees it, 0 where it does not."""
    way = place - point.position
    distance = float(np.linalg.norm(way))
    if distance == 0.0 or way @ point.normal <= 0.0 or rays.first(point.position, way / distance)[0] < distance:
        return 0.0
    return distance
