"""Rays against the tree, held against every triangle in float64."""

import numpy as np
import pytest
import warp as wp
from devices import DEVICES, NEEDS_CUDA

from gpu.core.device import launch
from gpu.device_scene.bvh import Bvh, intersect
from gpu.device_scene.bvh_build import build
from gpu.scene.types import Doubles, Ints

CPU = wp.get_device("cpu")
LENGTH = 10.0


@wp.kernel
def met_kernel(first: int, bvh: Bvh, origins: wp.array[wp.vec3], directions: wp.array[wp.vec3],
               lengths: wp.array[float], culls: bool, nearest: wp.array[wp.vec4], faces: wp.array[int],
               blocked: wp.array[int]) -> None:  # fmt: skip
    """What each ray meets first, and whether it meets anything."""
    index = first + wp.tid()
    nearest[index] = intersect(bvh, origins[index], directions[index], lengths[index], False, culls)
    faces[index] = wp.cast(nearest[index][3], int)
    any_one = intersect(bvh, origins[index], directions[index], lengths[index], True, False)
    blocked[index] = int(wp.cast(any_one[3], int) >= 0)


def tree(triangles: Doubles, device: wp.Device = CPU, culled: Doubles | float = 0.0) -> Bvh:
    """A tree over triangles (triangle, corner, 3)."""
    vertices = wp.array(triangles.reshape(-1, 3).astype(np.float32), dtype=wp.vec3, device=device)
    flags = wp.array(np.broadcast_to(culled, len(triangles)).astype(np.float32), dtype=float, device=device)
    return build(vertices, wp.array(np.arange(3 * len(triangles)), dtype=int, device=device), flags)


def shoot(bvh: Bvh, origins: Doubles, directions: Doubles, lengths: Doubles | float = LENGTH, *,
          culls: bool = False) -> tuple[Doubles, Ints]:  # fmt: skip
    """What each ray meets first: (t, u, v) and the triangle; it must meet something exactly if it meets a first."""
    count, device = len(origins), bvh.faces.device
    nearest = wp.zeros(count, dtype=wp.vec4, device=device)
    faces, blocked = (wp.zeros(count, dtype=int, device=device) for _ in range(2))
    rays = [wp.array(values.astype(np.float32), dtype=wp.vec3, device=device) for values in (origins, directions)]
    limits = wp.array(np.broadcast_to(lengths, count).astype(np.float32), dtype=float, device=device)
    launch(met_kernel, count, [bvh, *rays, limits, culls, nearest, faces, blocked], device)
    assert culls or np.array_equal(blocked.numpy() == 1, faces.numpy() >= 0)
    return nearest.numpy()[:, :3].astype(float), faces.numpy()


def distances(triangles: Doubles, origin: Doubles, direction: Doubles) -> tuple[Doubles, Doubles]:
    """By every triangle: the distance at which its plane is met, and by how much inside of its edges, relatively."""
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((a - origin) * normal).sum(axis=1) / (normal @ direction)
        place = origin + t[:, None] * direction
        shares = [
            (np.cross(q - p, place - p) * normal).sum(axis=1) / (normal**2).sum(axis=1)
            for p, q in ((b, c), (c, a), (a, b))
        ]
    return t, np.min(shares, axis=0)


def unit(vectors: Doubles) -> Doubles:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def soup(rng: np.random.Generator, count: int, size: float = 0.1) -> Doubles:
    """Random triangles in a unit cube, as float32 has them."""
    centres = rng.uniform(-0.5, 0.5, (count, 1, 3))
    return (centres + size * rng.uniform(-0.5, 0.5, (count, 3, 3))).astype(np.float32).astype(float)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 9, 40, 1000])
def test_the_first_triangle_is_met_where_it_is(count: int) -> None:
    rng = np.random.default_rng(count)
    triangles = soup(rng, count, 0.1 if count > 40 else 0.5)
    bvh = tree(triangles)
    rays = 400
    origins = rng.uniform(-0.7, 0.7, (rays, 3)).astype(np.float32).astype(float)
    aims = triangles[rng.integers(count, size=rays)].mean(axis=1) + rng.normal(0.0, 0.05, (rays, 3))
    directions = unit(aims - origins).astype(np.float32).astype(float)
    lengths = rng.uniform(0.2, 2.0, rays)
    hits, faces = shoot(bvh, origins, directions, lengths)
    for origin, direction, length, hit, face in zip(origins, directions, lengths, hits, faces, strict=True):
        t, inside = distances(triangles, origin, direction)
        surely = (inside > 1e-4) & (t > 1e-5) & (t < length - 1e-5)
        if face < 0:
            assert not surely.any()
            continue
        assert inside[face] > -1e-3
        assert hit[0] == pytest.approx(t[face], abs=2e-5)
        assert hit[0] <= t[surely].min(initial=np.inf) + 2e-5
        assert hit[0] < length
        shares = np.array([hit[1], hit[2], 1.0 - hit[1] - hit[2]])
        assert shares @ triangles[face] == pytest.approx(origin + t[face] * direction, abs=1e-4)
    assert 0.1 < (faces >= 0).mean() < 1.0


def sphere(rings: int) -> Doubles:
    """A closed sphere around the origin whose triangles share edges and corners."""
    theta, phi = np.linspace(0.0, np.pi, rings + 1), np.linspace(0.0, 2.0 * np.pi, 2 * rings + 1)
    phi[-1] = 0.0
    t, p = np.meshgrid(theta, phi, indexing="ij")
    points = (0.5 * np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=2)).astype(np.float32)
    points[0], points[-1] = (0.0, 0.0, 0.5), (0.0, 0.0, -0.5)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(three, axis=2).reshape(-1, 3, 3) for three in ((a, b, c), (a, c, d))]).astype(float)


@pytest.mark.parametrize("device", DEVICES)
def test_no_ray_leaves_a_closed_surface_at_its_edges_or_corners(device: str) -> None:
    rng = np.random.default_rng(3)
    triangles = sphere(24)
    origins = rng.uniform(-0.25, 0.25, (60_000, 3))
    chosen = triangles[rng.integers(len(triangles), size=len(origins))]
    share = rng.random((len(origins), 1))
    on_edge = share * chosen[:, 0] + (1.0 - share) * chosen[:, 1]
    aims = np.where(np.arange(len(origins))[:, None] % 2 == 0, on_edge, chosen[:, 2])
    _, faces = shoot(tree(triangles, wp.get_device(device)), origins, unit(aims - origins))
    assert (faces >= 0).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_rays_along_an_axis_meet_flat_boxes(axis: int, sign: float) -> None:
    """A grid of walls across the axis has boxes without depth; rays start beside it, on it and behind it."""
    cells = np.linspace(-0.5, 0.5, 9)
    u, v = (values.ravel() for values in np.meshgrid(cells[:-1], cells[:-1]))
    step = cells[1] - cells[0]
    corners = np.zeros((len(u), 3, 3))
    corners[:, :, (axis + 1) % 3] = u[:, None] + np.array([0.0, step, 0.0])
    corners[:, :, (axis + 2) % 3] = v[:, None] + np.array([0.0, 0.0, step])
    direction = np.zeros((1, 3))
    direction[0, axis] = sign
    inside = corners.mean(axis=1) - 0.25 * direction
    bvh = tree(corners)
    hits, faces = shoot(bvh, inside, np.repeat(direction, len(inside), axis=0))
    assert np.array_equal(faces, np.arange(len(inside)))
    assert hits[:, 0] == pytest.approx(0.25, abs=1e-6)
    _, faces = shoot(bvh, inside + 0.5 * direction, np.repeat(direction, len(inside), axis=0))
    assert (faces < 0).all()


def test_copies_of_one_triangle_and_such_without_area_do_no_harm() -> None:
    rng = np.random.default_rng(5)
    triangle = np.array([[-0.3, -0.3, 0.0], [0.4, -0.3, 0.0], [0.0, 0.4, 0.0]])
    point, line = np.repeat(triangle[:1], 3, axis=0), triangle[[0, 1, 1]]
    triangles = np.stack([triangle] * 300 + [point] * 100 + [line] * 100)
    places = rng.dirichlet([1.0, 1.0, 1.0], 200) @ triangle
    origins = places + np.array([0.0, 0.0, 0.5])
    hits, faces = shoot(tree(triangles), origins, np.tile([0.0, 0.0, -1.0], (200, 1)))
    assert ((faces >= 0) & (faces < 300)).all()
    assert hits[:, 0] == pytest.approx(0.5, abs=1e-6)


def test_length_ends_a_ray_before_what_lies_there() -> None:
    wall = np.array([[[-1.0, -1.0, 0.25], [1.0, -1.0, 0.25], [0.0, 1.0, 0.25]]])
    origins, directions = np.zeros((3, 3)), np.tile([0.0, 0.0, 1.0], (3, 1))
    _, faces = shoot(tree(wall), origins, directions, np.array([0.2, 0.25, 0.3]))
    assert faces.tolist() == [-1, -1, 0]


def test_backs_are_culled_where_they_can_be() -> None:
    """Of two squares one behind the other only the nearer can be culled, and is where its back is met."""
    square = np.array([[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]])
    bvh = tree(np.concatenate([square, square - [0.0, 0.0, 0.5]]), culled=np.array([1.0, 0.0]))
    origins, directions = np.array([[0.0, 0.0, 0.25], [0.0, 0.0, -0.25], [0.0, 0.0, -2.0]]), np.diag([0.0, 0.0, 1.0])
    directions = np.stack([-directions[2], directions[2], directions[2]])
    assert shoot(bvh, origins, directions, culls=True)[1].tolist() == [0, -1, 1]
    assert shoot(bvh, origins, directions)[1].tolist() == [0, 0, 1]


@pytest.mark.parametrize("device", DEVICES)
def test_of_two_faces_in_one_place_the_one_that_faces_the_ray_is_met(device: str) -> None:
    """A wall of two skins back to back, divided differently into triangles, met under all angles from both sides."""
    rng = np.random.default_rng(11)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn[:, 0] *= np.linalg.det(turn)
    a, b, c, d = np.array([[-0.4, -0.3, 0.1], [0.4, -0.3, 0.1], [0.4, 0.3, 0.1], [-0.4, 0.3, 0.1]])
    wall = np.array([[a, b, c], [a, c, d], [b, a, d], [b, d, c]]) @ turn.T
    side = np.tile([1.0, -1.0], 2000)
    aims = np.stack([rng.uniform(-0.39, 0.39, 4000), rng.uniform(-0.29, 0.29, 4000), np.full(4000, 0.1)], axis=1)
    eyes = aims + unit(rng.normal(size=(4000, 3)) * [1.0, 1.0, 0.3]) * rng.uniform(0.01, 1.0, (4000, 1))
    eyes[:, 2] = 0.1 + side * np.maximum(np.abs(eyes[:, 2] - 0.1), 1e-3)
    origins, directions = eyes @ turn.T, unit(aims - eyes) @ turn.T
    _, faces = shoot(tree(wall, wp.get_device(device)), origins, directions)
    assert np.array_equal(faces // 2, (side < 0.0).astype(int))


@NEEDS_CUDA
def test_cuda_meets_the_same() -> None:
    rng = np.random.default_rng(7)
    triangles, count = soup(rng, 20_000, 0.05), 50_000
    origins, directions = rng.uniform(-0.5, 0.5, (count, 3)), unit(rng.normal(size=(count, 3)))
    hits, faces = shoot(tree(triangles), origins, directions)
    others, other_faces = shoot(tree(triangles, wp.get_device("cuda:0")), origins, directions)
    same = faces == other_faces
    assert same.mean() > 0.9999
    assert hits[same] == pytest.approx(others[same], abs=1e-3)
    assert hits[same, 0] == pytest.approx(others[same, 0], abs=1e-5)


@pytest.mark.parametrize("device", DEVICES)
def test_what_is_met_first_does_not_depend_on_the_tree(device: str) -> None:
    """Where triangles share edges and corners, lie in one plane or one in the place of another, too."""
    rng = np.random.default_rng(11)
    flat = soup(rng, 60, 0.6)
    flat[:, :, 2] = 0.1
    tilted = flat @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T
    ball = sphere(16)
    triangles = np.concatenate([ball, flat, tilted, ball[:40], flat[:20, ::-1], soup(rng, 200)]).astype(np.float32)
    count, order = len(triangles), rng.permutation(len(triangles))
    one, other = tree(triangles, wp.get_device(device)), tree(triangles[order], wp.get_device(device))
    other.faces = wp.array(order[other.faces.numpy()], dtype=int, device=device)
    origins = rng.uniform(-0.7, 0.7, (20_000, 3))
    chosen = triangles[rng.integers(count, size=len(origins))]
    share = rng.choice([0.0, 0.5, 1.0, 0.3], (len(origins), 1))
    aims = share * chosen[:, 0] + (1.0 - share) * chosen[:, 1]
    found = [shoot(bvh, origins, unit(aims - origins)) for bvh in (one, other)]
    for values, others in zip(*found, strict=True):
        assert np.array_equal(values, others)
