"""A hall of any number of triangles: always the same shape and light, only divided more finely."""

from collections.abc import Callable

import numpy as np

from gpu.scene.assemble import assemble
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart, SceneParts
from gpu.scene.types import Doubles, Material, Scene

HALF = np.array([4.0, 1.6, 4.0])
SPHERES = [(x, 0.55, z) for x in (-2.4, 0.0, 2.4) for z in (-2.4, 0.0, 2.4)]
PATCHES = 6 + len(SPHERES)
RIPPLES = 0.06


def make_hall(triangles: int) -> Scene:
    """Six rippled walls around nine rippled spheres under a lamp, of about `triangles` triangles (60 at least)."""
    cells = max(2, round((triangles / (2 * PATCHES)) ** 0.5))
    walls = [_patch(_wall(axis, side), cells, 0) for axis in range(3) for side in (-1.0, 1.0)]
    spheres = [_patch(_sphere(centre), cells, 1) for centre in SPHERES]
    corners = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)]) * 0.8 + (0.0, HALF[1] - 0.15, 0.0)
    lamp = MeshPart(corners.astype(np.float64), np.array([[0, 1, 2], [0, 2, 3]]), material=2, name="lamp")
    materials = [
        Material("wall", base_color=(0.7, 0.68, 0.62, 1.0)),
        Material("sphere", base_color=(0.5, 0.3, 0.2, 1.0)),
        Material("lamp", emission=(12.0, 11.0, 9.0)),
    ]
    camera = look_at((-3.2, 0.4, 3.4), (0.4, -0.7, -0.4), yfov_degrees=65.0, name="corner")
    return assemble("hall", SceneParts([*walls, *spheres, lamp], materials, cameras=[camera], metres_per_unit=1.0))


def _patch(shape: Callable[[Doubles, Doubles], Doubles], cells: int, material: int) -> MeshPart:
    """The surface `shape`(u, v) over [0, 1]² as `cells`² squares; its front is ∂u × ∂v."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, cells + 1), np.linspace(0.0, 1.0, cells + 1))
    points = shape(u, v)
    step = 1e-4
    along_u = shape(u + step, v) - shape(u - step, v)
    along_v = shape(u, v + step) - shape(u, v - step)
    normals = np.cross(along_u, along_v)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    corner = ((cells + 1) * np.arange(cells)[:, None] + np.arange(cells)).reshape(-1)
    up = cells + 1
    faces = np.stack([corner, corner + 1, corner + up + 1, corner, corner + up + 1, corner + up], axis=1)
    return MeshPart(points.reshape(-1, 3), faces.reshape(-1, 3), normals.reshape(-1, 3), material=material)


def _wall(axis: int, side: float) -> Callable[[Doubles, Doubles], Doubles]:
    """The wall at `side` of `axis`, with ripples that vanish where walls meet; its front faces inwards."""
    first, second = ((axis + 1) % 3, (axis + 2) % 3) if side < 0.0 else ((axis + 2) % 3, (axis + 1) % 3)

    def shape(u: Doubles, v: Doubles) -> Doubles:
        points = np.empty((*u.shape, 3))
        points[..., first], points[..., second] = (2.0 * u - 1.0) * HALF[first], (2.0 * v - 1.0) * HALF[second]
        ripple = np.sin(31.0 * u + 7.0 * v) * np.sin(23.0 * v) * np.sin(np.pi * u) * np.sin(np.pi * v)
        points[..., axis] = side * (HALF[axis] - RIPPLES * (1.0 + ripple) * np.sin(np.pi * u) * np.sin(np.pi * v))
        return points

    return shape


def _sphere(centre: tuple[float, float, float]) -> Callable[[Doubles, Doubles], Doubles]:
    """A dented sphere on the floor, without the points of its poles."""

    def shape(u: Doubles, v: Doubles) -> Doubles:
        longitude, latitude = 2.0 * np.pi * u, (np.pi - 0.02) * (v - 0.5)
        dents = np.sin(9.0 * longitude) * np.sin(14.0 * latitude) * np.cos(latitude) ** 2
        radius = centre[1] * (1.0 + RIPPLES * dents)
        ring = radius * np.cos(latitude)
        offset = np.stack([ring * np.cos(longitude), radius * np.sin(latitude), -ring * np.sin(longitude)], axis=-1)
        return offset + np.array((centre[0], centre[1] - HALF[1], centre[2]))

    return shape
