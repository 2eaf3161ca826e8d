"""Meshes that nobody means to make and everybody meets: each is a picture without a flaw, or refused by name."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import box, grey, quad, resident_of, scene_of
from stress import render

from gpu.device_scene.upload import DeviceScene
from gpu.errors import SceneError
from gpu.film.metrics import rel_mse
from gpu.scene.camera import look_at
from gpu.scene.scene_parts import MeshPart
from gpu.scene.types import Camera, Doubles, Floats, Light, LightKind
from gpu.settings import Method

SIZE = (24, 18)
CAMERA = look_at((0.1, 0.05, 0.42), (-0.05, -0.1, -0.5), yfov_degrees=75.0)
MATERIALS = [grey(0.6), grey(0.0, 5.0)]
LAMP = quad((-0.2, 0.48, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
ROOM = [*box(), LAMP]
METHODS = pytest.mark.parametrize("method", list(Method))


def picture(parts: list[MeshPart], device: str, method: Method, camera: Camera = CAMERA) -> Floats:
    return render(resident_of(parts, MATERIALS, device=device), camera, SIZE, method=method, samples=8)


@cache
def plain(device: str, method: Method) -> Floats:
    """The room as it is, with which others are compared."""
    return picture(ROOM, device, method)


def triangles(corners: object, material: int = 0) -> MeshPart:
    """Triangles (triangle, 3, 3) of their own."""
    positions = np.asarray(corners, np.float64).reshape(-1, 3)
    return MeshPart(positions, np.arange(len(positions)).reshape(-1, 3), material=material)


def rotated(part: MeshPart) -> MeshPart:
    """The same part with its fronts behind."""
    return MeshPart(part.positions, part.triangles[:, ::-1], part.normals, material=part.material)


@METHODS
def test_triangles_without_an_area_are_as_if_they_were_not_there(device: str, method: Method) -> None:
    rng = np.random.default_rng(0)
    a, b = rng.uniform(-0.4, 0.4, (2, 50, 3))
    points, lines = triangles(np.stack([a, a, a], axis=1)), triangles(np.stack([a, b, (a + b) / 2.0], axis=1))
    twice, lamp = triangles(np.stack([a, b, b], axis=1)), triangles(np.stack([a, a, b], axis=1), 1)
    with_them = picture([*ROOM, points, lines, twice, lamp], device, method)
    assert rel_mse(with_them, plain(device, method)) < 1e-6


@METHODS
def test_slivers_hide_and_light_no_more_than_they_are(device: str, method: Method) -> None:
    """Of reflectors and of emitters as thin as float32 tells apart from lines."""
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-0.4, 0.4, (2, 100, 3))
    widths = 10.0 ** rng.uniform(-7.0, -5.0, (100, 1))
    slivers = np.stack([a, b, (a + b) / 2.0 + widths * rng.uniform(-1.0, 1.0, (100, 3))], axis=1)
    parts = [triangles(slivers[:50]), triangles(slivers[50:], 1)]
    device_scene = resident_of([*ROOM, *parts], MATERIALS, device=device)
    assert len(device_scene.scene.triangles) > 14 + 50  # some are kept
    with_them = render(device_scene, CAMERA, SIZE, method=method, samples=8)
    assert with_them.mean() == pytest.approx(plain(device, method).mean(), rel=0.05)


@METHODS
@pytest.mark.parametrize("opposed", [False, True])
def test_a_wall_that_is_there_twice_is_a_wall(device: str, opposed: bool, method: Method) -> None:
    walls = [*box(), *(rotated(part) if opposed else part for part in box())]
    doubled = picture([*walls, LAMP], device, method)
    assert doubled.mean() == pytest.approx(plain(device, method).mean(), rel=0.02)


@METHODS
def test_normals_that_all_point_the_wrong_way_change_nothing_on_flat_walls(device: str, method: Method) -> None:
    """A file's normals say how to shade a side, not which side is there: light comes from the side that is seen."""
    wrong = [
        MeshPart(part.positions, part.triangles, np.tile(sign * _normal(part), (4, 1)), material=part.material)
        for part in ROOM
        for sign in (-1.0,)
    ]
    assert rel_mse(picture(wrong, device, method), plain(device, method)) < 1e-6


def _normal(part: MeshPart) -> Doubles:
    a, b, c = part.positions[part.triangles[0]]
    normal = np.cross(b - a, c - a)
    return np.asarray(normal / np.linalg.norm(normal))


@METHODS
def test_walls_wound_the_wrong_way_are_opaque_and_reflect(device: str, method: Method) -> None:
    inside_out = picture([*map(rotated, box()), LAMP], device, method)
    assert inside_out.mean() == pytest.approx(plain(device, method).mean(), rel=0.02)


@METHODS
@pytest.mark.parametrize("material", [0, 1], ids=["under the sky", "that shines"])
def test_one_triangle(device: str, material: int, method: Method) -> None:
    device_scene = resident_of([triangles([[-1, 0, 0], [1, 0, 0], [0, 1, 0]], material)], MATERIALS, device=device)
    radiance = render(device_scene, device_scene.scene.cameras[0], SIZE, method=method, samples=8)
    assert radiance.max() > 0.0


@METHODS
@pytest.mark.parametrize("apart", [1e3, 1e6, 1e9])
def test_two_islands_far_apart(device: str, apart: float, method: Method) -> None:
    """A room, and another one so far away that float32 hardly resolves either; at 10⁹ extents it is a point."""
    far = [
        MeshPart(part.positions + np.array([apart, 0.0, 0.0]), part.triangles, material=part.material) for part in ROOM
    ]
    radiance = picture([*ROOM, *far], device, method)
    if apart == 1e3:
        assert radiance.mean() == pytest.approx(plain(device, method).mean(), rel=0.05)


@METHODS
def test_an_emitter_without_an_area_is_no_light(device: str, method: Method) -> None:
    spark = triangles(np.full((1, 3, 3), 0.1), 1)
    off = Light("off", LightKind.POINT, (0.0, 0.0, 0.0))  # a scene without any lamp gets one
    device_scene = resident_of([*box(), spark], MATERIALS, lights=[off], device=device)
    assert (render(device_scene, CAMERA, SIZE, method=method) == 0.0).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_vertex_that_is_no_number_is_named(value: float) -> None:
    """Also tests/gpu/scene, for each format and attribute."""
    broken = quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    broken.positions[2, 1] = value
    with pytest.raises(SceneError, match=r"positions\[2\]"):
        scene_of([*ROOM, broken], MATERIALS)


# Near, equal, tiny and unlike numbers; and all that a float64 can be.
CLOSE = st.one_of(st.sampled_from([0.0, -0.0, 0.5, -0.5, 1.0, 1.0 + 1e-7, 1e-7, 1e-30]), st.floats(-1.0, 1.0))
ANY = st.one_of(CLOSE, st.sampled_from([5e-324, 1e-160, 1e30, -1e30, 1e99, -1.7e308]), st.floats())


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    corners=st.one_of(*(st.lists(st.tuples(n, n, n), min_size=3, max_size=15) for n in (CLOSE, ANY))),
    emitter=st.booleans(),
)
def test_any_numbers_are_a_picture_or_an_error(
    device: str, corners: list[tuple[float, float, float]], emitter: bool
) -> None:
    part = triangles(corners[: len(corners) // 3 * 3], int(emitter))
    try:
        scene = scene_of([part], MATERIALS)
    except SceneError:
        return
    device_scene, few = DeviceScene(scene, device), {"samples": 2, "vpls": 200, "vpl_clusters": 20, "sp_clusters": 20}
    few |= {"photons": 500, "gather_rays": 8}
    for method in Method:
        render(device_scene, scene.cameras[0], (12, 9), method=method, **few)
