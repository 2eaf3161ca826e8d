import numpy as np
import pytest
import warp as wp
from glass import bulb, caustics_of, mirror_over_floor
from scenes import camera_of, column, quad, results

from gpu.core.intrinsics import CUDA_LANES
from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.indirect.caustics import CausticGather, caustic_irradiance
from gpu.lights.caustic_map import CausticLight
from gpu.methods.frame_arrays import FrameArrays
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Floats

PATHS = 8192
LAMP = bulb(0.0, -0.3, 0.0)


@wp.kernel
def read_caustics_kernel(first: int, scene: SceneData, lit: CausticLight, places: wp.array[wp.vec3], normal: wp.vec3,
                         lanes: int, out: wp.array[wp.vec3]) -> None:  # fmt: skip
    """What each of `lanes` threads a place finds, where no warp adds it up."""
    index = first + wp.tid()
    out[index] = caustic_irradiance(scene, lit, places[index // lanes], normal, index % lanes, lanes)


def read_at(room: DeviceScene, lit: CausticLight, x: Floats, z: Floats, up: float = 1.0, lanes: int = 1) -> Doubles:
    """Irradiance of places on the room's floor."""
    places = column(np.stack([x, np.full(len(x), -0.5), z], axis=1), wp.vec3)
    inputs = [room.data, lit, places, wp.vec3(0.0, up, 0.0), lanes]
    return results(read_caustics_kernel, lanes * len(x), inputs, wp.vec3)[:, 0].reshape(-1, lanes).sum(axis=1)


@pytest.fixture(scope="module")
def room() -> DeviceScene:
    return mirror_over_floor(LAMP)


@pytest.fixture(scope="module")
def lit(room: DeviceScene) -> CausticLight:
    return caustics_of(room, PATHS).light


def test_a_mirror_lights_the_floor_as_the_lamp_behind_it_would(room: DeviceScene, lit: CausticLight) -> None:
    x, z = np.random.default_rng(0).uniform(-0.2, 0.2, (2, 500))
    expected = 0.8 / (x**2 + z**2 + 0.8**2) ** 1.5
    share = read_at(room, lit, x, z) / expected
    assert share.mean() == pytest.approx(1.0, abs=0.02)
    assert share.std() < 0.2
    narrow = read_at(room, caustics_of(room, PATHS, share=0.5).light, x, z) / expected
    assert narrow.mean() == pytest.approx(1.0, abs=0.03)
    assert narrow.std() > share.std()


def test_lanes_share_the_photons_of_a_place(room: DeviceScene, lit: CausticLight) -> None:
    x, z = np.random.default_rng(0).uniform(-0.2, 0.2, (2, 50))
    assert np.allclose(read_at(room, lit, x, z, lanes=CUDA_LANES), read_at(room, lit, x, z), rtol=1e-5)


def test_it_ends_where_the_mirror_does(room: DeviceScene, lit: CausticLight) -> None:
    x = np.linspace(0.26667 + lit.grid.reach, 0.49, 50)
    assert not read_at(room, lit, x, np.zeros(50)).any()


def test_the_back_of_a_surface_gets_nothing(room: DeviceScene, lit: CausticLight) -> None:
    x, z = np.random.default_rng(0).uniform(-0.2, 0.2, (2, 50))
    assert not read_at(room, lit, x, z, up=-1.0).any()


def test_no_light_leaks_under_a_thin_wall() -> None:
    wall = quad([0.1, -0.5, -0.45], [0.0, 0.49, 0.0], [0.0, 0.0, 0.9], 1)
    room = mirror_over_floor(LAMP, parts=[wall])
    lit, z = caustics_of(room, PATHS).light, np.random.default_rng(0).uniform(-0.2, 0.2, 200)
    before, behind = (read_at(room, lit, np.full(200, x), z) for x in (0.095, 0.105))
    assert 1.15 < before.mean() < 1.65  # 1.53, but for what lies within an estimate of the wall
    assert not behind.any()


def seen_from_below(room: DeviceScene, lit: CausticLight, stride: int, size: tuple[int, int] = (64, 48)) -> Floats:
    """What a camera under the mirror sees of caustics on the floor, in (height, width)."""
    view = look_at((0.05, -0.05, 0.0), (0.05, -0.5, 0.0), (0.0, 0.0, 1.0), yfov_degrees=50.0)
    frame = FrameArrays(room, size, lambertian=False, stride=stride)
    frame.trace_primary_rays(camera_of(room, view, size))
    frame.shading_points.find(frame.gbuffer)
    radiance, mean = wp.zeros(frame.pixels, dtype=wp.vec3, device="cpu"), wp.zeros(1, dtype=float, device="cpu")
    gather, seen = CausticGather(frame.pixels, frame.device), (frame.scene, frame.gbuffer, frame.shading_points)
    gather.find(*seen, lit, frame.features)
    if stride > 1:
        gather.fill(*seen, lit, frame.features, mean)
    gather.add(frame.gbuffer, radiance)
    return radiance.numpy()[:, 0].reshape(size[::-1])


def test_between_shading_points_it_is_interpolated_but_not_at_its_edges() -> None:
    wall = quad([0.1, -0.5, -0.45], [0.0, 0.49, 0.0], [0.0, 0.0, 0.9], 1)
    room = mirror_over_floor(LAMP, parts=[wall])
    lit = caustics_of(room, PATHS).light
    whole, sparse = (seen_from_below(room, lit, stride)[::2] for stride in (1, 2))
    left, between, right = whole[:, :-2:2], (slice(None), slice(1, -1, 2)), whole[:, 2::2]
    across = np.maximum(left, right) > 2.0 * np.minimum(left, right)
    np.testing.assert_allclose(sparse[between][across], whole[between][across], rtol=1e-5)
    assert 5 < across.sum() < 0.2 * across.size
    assert np.isclose(sparse[between], 0.5 * (left + right), rtol=1e-4)[~across].mean() > 0.9
