"""Rays do not meet the surface that they leave."""

import numpy as np
import warp as wp
from scenes import column, grey, resident_of, results

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.rays import closest_hit
from gpu.device_scene.sides import triangle_normal
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles


@wp.kernel
def leave_kernel(first: int, scene: SceneData, faces: wp.array[int], places: wp.array[wp.vec2],
                 directions: wp.array[wp.vec3], out: wp.array[int]) -> None:  # fmt: skip
    """The face that a ray meets which leaves a triangle's point."""
    index = first + wp.tid()
    corner = scene.triangles[faces[index]]
    place = places[index]
    position = (
        scene.vertices[corner[0]] * place[0]
        + scene.vertices[corner[1]] * place[1]
        + scene.vertices[corner[2]] * (1.0 - place[0] - place[1])
    )
    origin = offset_origin(position, triangle_normal(scene, faces[index]), directions[index])
    out[index] = closest_hit(scene, origin, directions[index], 10.0).face


def soup(rng: np.random.Generator, centre: Doubles, size: float, count: int = 300) -> MeshPart:
    """Random triangles of about `size` around `centre`."""
    points = centre + size * (rng.random((count, 1, 3)) - 0.5) + size * 0.3 * (rng.random((count, 3, 3)) - 0.5)
    return MeshPart(points.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def test_no_ray_meets_the_triangle_that_it_leaves() -> None:
    rng = np.random.default_rng(1)
    parts = [soup(rng, np.zeros(3), 1.0), soup(rng, np.full(3, 0.45), 0.01), soup(rng, np.zeros(3), 1e-4)]
    device_scene = resident_of(parts, [grey(0.5)])
    count, faces = 20_000, len(device_scene.triangle_order)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    places = np.sort(rng.random((count, 2)), axis=1)
    places[:, 1] -= places[:, 0]
    left = rng.integers(0, faces, count)
    inputs = [column(left, wp.int32), column(places, wp.vec2), column(directions, wp.vec3)]
    intersect = results(leave_kernel, count, [device_scene.data, *inputs], int)
    assert (intersect != left).all()
    assert (intersect != int(NO_HIT)).sum() > 0


def test_nor_do_rays_from_near_the_origin_where_floats_are_finer() -> None:
    rng = np.random.default_rng(2)
    corners = rng.normal(size=(100, 3, 3))
    corners -= corners.mean(axis=1, keepdims=True)  # large triangles through the origin
    corners = np.concatenate([corners, -corners])  # whose box is about it, too
    device_scene = resident_of([MeshPart(corners.reshape(-1, 3), np.arange(600).reshape(-1, 3))], [grey(0.5)])
    middle = -np.asarray(device_scene.scene.placement.centre) * device_scene.scene.placement.scale
    assert np.abs(middle).max() < 1e-6
    count = 20_000
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    left, places = rng.integers(0, 200, count), 1.0 / 3.0 + rng.normal(0.0, 1e-4, (count, 2))
    inputs = [column(left, wp.int32), column(places, wp.vec2), column(directions, wp.vec3)]
    assert (results(leave_kernel, count, [device_scene.data, *inputs], int) != left).all()
