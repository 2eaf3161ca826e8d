"""What tests ask of the built-in scenes."""

from functools import cache

import numpy as np

from gpu.scene.load import load_scene
from gpu.scene.types import Doubles, Scene


@cache
def scene_of(name: str) -> Scene:
    return load_scene(name)


def world_corners(scene: Scene) -> Doubles:
    """Triangles' corners (triangle, 3, 3) in metres."""
    world = scene.vertices.astype(np.float64) / scene.placement.scale + scene.placement.centre
    return world[scene.triangles]


def face_normals(corners: Doubles) -> Doubles:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def nearest_hit(corners: Doubles, origin: Doubles, direction: Doubles) -> tuple[float, int]:
    """Distance and triangle of the first hit (Möller and Trumbore 1997); infinity and −1 for none."""
    a, e, f = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, f)
    determinant = np.einsum("tc,tc->t", e, p)
    inverse = 1.0 / np.where(np.abs(determinant) < 1e-15, np.inf, determinant)
    s = origin - a
    u = np.einsum("tc,tc->t", s, p) * inverse
    q = np.cross(s, e)
    v = q @ direction * inverse
    distance = np.einsum("tc,tc->t", f, q) * inverse
    hit = (inverse != 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0)
    if not hit.any():
        return np.inf, -1
    index = int(np.argmin(np.where(hit, distance, np.inf)))
    return float(distance[index]), index


def is_closed_and_shows_fronts(scene: Scene, sheets: tuple[str, ...]) -> bool:
    """Whether rays from the first camera all end at a surface, at its front; sheets: materials of two sides."""
    corners = world_corners(scene)
    normals = face_normals(corners)
    both = [number for number, material in enumerate(scene.materials) if material.name in sheets]
    directions = np.random.default_rng(1).standard_normal((12, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for direction in [*np.eye(3), *-np.eye(3), *directions]:
        distance, index = nearest_hit(corners, scene.cameras[0].to_world[:3, 3], direction)
        if not np.isfinite(distance):
            return False
        if scene.triangle_material[index] not in both and normals[index] @ direction >= 0.0:
            return False
    return True


def heights(scene: Scene, material: str) -> tuple[float, float]:
    """The lowest and the highest point of what is of the material [m]."""
    (number,) = (n for n, one in enumerate(scene.materials) if one.name == material)
    y = world_corners(scene)[scene.triangle_material == number][..., 1]
    return float(y.min()), float(y.max())
