"""Rays that meet the surface they leave, and rays that slip through one: there must be none."""

import numpy as np
import pytest
import warp as wp
from scenes import column, grey, resident_of, results
from scipy.spatial.transform import Rotation

from gpu.device_scene.data import NO_HIT, SceneData
from gpu.device_scene.offsets import offset_origin
from gpu.device_scene.rays import closest_hit, connected
from gpu.device_scene.sides import triangle_normal
from gpu.device_scene.upload import DeviceScene
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Doubles, Integers

COUNT = 200_000
# Scale, and distance from the origin in extents of the scene.
CASES = [(1.0, 0.0), (1e-12, 0.0), (1e-6, 0.0), (1e3, 0.0), (1e6, 0.0), (1.0, 1e3), (1.0, 1e6)]
FAR = wp.constant(10.0)
# Steps along a wall's edges, and its triangles.
STEPS = 8
OF_WALL = 2 * STEPS**2


@wp.func
def point_of(scene: SceneData, face: int, place: wp.vec2) -> wp.vec3:
    """A triangle's point, computed as for a hit."""
    corner = scene.triangles[face]
    return (
        scene.vertices[corner[0]] * place[0]
        + scene.vertices[corner[1]] * place[1]
        + scene.vertices[corner[2]] * (1.0 - place[0] - place[1])
    )


@wp.kernel
def leave_kernel(first: int, scene: SceneData, faces: wp.array[int], places: wp.array[wp.vec2],
                 targets: wp.array[wp.vec3], out: wp.array[int]) -> None:  # fmt: skip
    """The face that a ray from a point of a triangle towards a target meets."""
    index = first + wp.tid()
    start = point_of(scene, faces[index], places[index])
    way = targets[index] - start
    origin = offset_origin(start, triangle_normal(scene, faces[index]), way)
    out[index] = closest_hit(scene, origin, wp.normalize(way), FAR).face


@wp.kernel
def pair_kernel(first: int, scene: SceneData, faces: wp.array2d[int], places: wp.array2d[wp.vec2],
                out: wp.array[int]) -> None:  # fmt: skip
    """Whether the fronts of two points of triangles see each other."""
    index = first + wp.tid()
    p_face = faces[index, 0]
    q_face = faces[index, 1]
    p = point_of(scene, p_face, places[index, 0])
    q = point_of(scene, q_face, places[index, 1])
    out[index] = int(connected(scene, p, triangle_normal(scene, p_face), q, triangle_normal(scene, q_face)))


def walls(half: float) -> MeshPart:
    """A closed cube whose fronts are inside, wall by wall."""
    ticks = np.linspace(-half, half, STEPS + 1)
    grid = np.stack(np.meshgrid(ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = (np.arange(STEPS)[:, None] * (STEPS + 1) + np.arange(STEPS)).ravel()
    first = np.stack([corner, corner + STEPS + 1, corner + STEPS + 2], axis=1)
    second = np.stack([corner, corner + STEPS + 2, corner + 1], axis=1)
    positions, triangles = [], []
    for axis in range(3):
        for side in (-half, half):
            wall = np.empty((len(grid), 3))
            wall[:, axis], wall[:, (axis + 1) % 3], wall[:, (axis + 2) % 3] = side, grid[:, 0], grid[:, 1]
            faces = np.concatenate([first, second]) + sum(map(len, positions))
            positions.append(wall)
            triangles.append(faces if side < 0.0 else faces[:, ::-1])
    return MeshPart(np.concatenate(positions), np.concatenate(triangles))


def soup(rng: np.random.Generator, count: int) -> MeshPart:
    """Random triangles of all sizes in the cube of half a unit."""
    sizes = 10.0 ** rng.uniform(-3.0, -0.5, (count, 1, 1))
    points = rng.uniform(-0.3, 0.3, (count, 1, 3)) + sizes * rng.uniform(-0.5, 0.5, (count, 3, 3))
    return MeshPart(points.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def placed(part: MeshPart, scale: float, extents: float) -> MeshPart:
    """A part turned, scaled and moved."""
    rotated = Rotation.from_rotvec((0.3, -0.5, 0.7)).apply(part.positions)
    return MeshPart((rotated + extents * np.array([0.8, -0.6, 1.0])) * scale, part.triangles)


def scene_at(parts: list[MeshPart], scale: float, extents: float, device: str) -> DeviceScene:
    return resident_of([placed(part, scale, extents) for part in parts], [grey(0.5)], device=device)


class Places:
    """Random points of random triangles of a scene: `faces` (point,), `places` (point, 2) barycentrics."""

    def __init__(self, rng: np.random.Generator, faces: Integers) -> None:
        self.faces = faces
        self.places = np.sort(rng.random((COUNT, 2)), axis=1)
        self.places[:, 1] -= self.places[:, 0]

    def points(self, device_scene: DeviceScene) -> Doubles:
        """Where they are, (point, 3)."""
        corners = device_scene.scene.vertices.astype(np.float64)[device_scene.scene.triangles[self.faces]]
        weights = np.append(self.places, 1.0 - self.places.sum(axis=1, keepdims=True), axis=1)
        return np.asarray(np.einsum("nk,nkc->nc", weights, corners))


def on_other_walls(rng: np.random.Generator, faces: Integers) -> Integers:
    """Random triangles of `walls`, none in the wall of the triangle that it is chosen for."""
    first = (faces // OF_WALL + 1) * OF_WALL
    return np.asarray((first + rng.integers(0, 5 * OF_WALL, COUNT)) % (6 * OF_WALL))


@pytest.mark.parametrize(("scale", "extents"), CASES)
def test_no_ray_meets_the_triangle_that_it_leaves_and_none_gets_out_of_a_closed_room(
    device: str, scale: float, extents: float
) -> None:
    rng = np.random.default_rng(1)
    device_scene = scene_at([walls(0.5), soup(rng, 6 * OF_WALL)], scale, extents, device)
    starts = Places(rng, rng.integers(0, len(device_scene.triangle_order), COUNT))
    in_wall = starts.faces < 6 * OF_WALL
    ends = np.where(in_wall, on_other_walls(rng, starts.faces), rng.integers(0, 6 * OF_WALL, COUNT))
    targets = column(Places(rng, ends).points(device_scene), wp.vec3, device)
    inputs = [column(starts.faces, wp.int32, device), column(starts.places, wp.vec2, device), targets]
    met = results(leave_kernel, COUNT, [device_scene.data, *inputs], int, device=device)
    self_hits, leaks = np.count_nonzero(met == starts.faces), np.count_nonzero(met == int(NO_HIT))
    assert (self_hits, leaks) == (0, 0)
    assert np.count_nonzero(met >= 6 * OF_WALL) > COUNT / 20  # the room is not empty


@pytest.mark.parametrize(("scale", "extents"), CASES)
def test_all_walls_of_a_room_see_each_other_and_none_sees_what_is_outside(
    device: str, scale: float, extents: float
) -> None:
    rng = np.random.default_rng(2)
    room = 6 * OF_WALL
    device_scene = scene_at([walls(0.3), walls(0.5)], scale, extents, device)
    starts = Places(rng, rng.integers(0, room, COUNT))
    for outside, seen in ((0, COUNT), (room, 0)):
        ends = Places(rng, outside + on_other_walls(rng, starts.faces))
        faces = column(np.stack([starts.faces, ends.faces], axis=1), wp.int32, device)
        places = column(np.stack([starts.places, ends.places], axis=1), wp.vec2, device)
        connections = results(pair_kernel, COUNT, [device_scene.data, faces, places], int, device=device)
        assert np.count_nonzero(connections) == seen
