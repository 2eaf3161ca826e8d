from dataclasses import replace

import numpy as np
import pytest
from scenes import box, camera_of, grey, quad, resident_of

from gpu.core.device import allocate
from gpu.device_scene.data import NO_HIT
from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.gbuffer import GBuffer, trace_primary_rays
from gpu.gbuffer.specular_chain import chain_samples
from gpu.scene.camera import look_at
from gpu.scene.types import Camera, Doubles, Material, Sky

FLAGS = {"chains", "gloss", "traces_gloss", "grained", "translucent"}
SIZE = (24, 16)


def look(device_scene: DeviceScene, camera: Camera) -> dict[str, Doubles]:
    """The G-buffer's arrays, each (height, width, …)."""
    width, height = SIZE
    gbuffer = allocate(GBuffer, width * height, device_scene.device)
    data = camera_of(device_scene, camera, SIZE)
    trace_primary_rays(device_scene.data, data, SIZE, gbuffer, chain_samples(device_scene.device))
    arrays = {name: getattr(gbuffer, name).numpy() for name in GBuffer.vars if name not in FLAGS}
    return {name: array.reshape(height, width, *array.shape[1:]) for name, array in arrays.items()}


def pixel_grid() -> Doubles:
    """Pixel centres (height, width, 2) in [−1, 1], x to the right, y up."""
    x = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2.0 - 1.0
    y = 1.0 - (np.arange(SIZE[1]) + 0.5) / SIZE[1] * 2.0
    return np.stack(np.meshgrid(x, y), axis=-1)


def in_camera(camera: Camera, device_scene: DeviceScene, positions: Doubles) -> Doubles:
    """Unit-space positions in the camera's own axes, world units."""
    placement = device_scene.scene.placement
    world = positions / placement.scale + placement.centre
    return np.asarray((world - camera.to_world[:3, 3]) @ camera.to_world[:3, :3])


def test_pixels_look_through_their_centres() -> None:
    device_scene = resident_of([*box(half=3.0)], [grey(0.5)])
    camera = look_at((0.5, -0.7, 1.1), (1.0, 2.0, -2.0), yfov_degrees=70.0)
    seen = look(device_scene, camera)
    assert (seen["face"] != int(NO_HIT)).all()
    own = in_camera(camera, device_scene, seen["position"])
    assert (own[..., 2] < 0.0).all()
    plane = own[..., :2] / -own[..., 2:]
    half = camera.half_height * np.array([SIZE[0] / SIZE[1], 1.0])
    assert np.allclose(plane, pixel_grid() * half, atol=2e-4)
    distance = np.linalg.norm(own, axis=-1) * device_scene.scene.placement.scale
    assert np.allclose(seen["spacing"], distance * 2.0 * camera.half_height / SIZE[1], rtol=1e-3)
    towards = camera.to_world[:3, 3] - (seen["position"] / device_scene.scene.placement.scale)
    assert np.allclose(seen["to_camera"], towards / np.linalg.norm(towards, axis=-1, keepdims=True), atol=1e-4)


def test_orthographic_pixels_are_parallel() -> None:
    device_scene = resident_of([*box(half=3.0)], [grey(0.5)])
    base = look_at((0.2, 0.1, 2.0), (0.2, 0.1, 0.0))
    camera = Camera("plan", base.to_world, 1.5, orthographic=True)
    seen = look(device_scene, camera)
    own = in_camera(camera, device_scene, seen["position"])
    assert np.allclose(own[..., :2], pixel_grid() * [1.5 * SIZE[0] / SIZE[1], 1.5], atol=1e-4)
    assert np.allclose(own[..., 2], -5.0, atol=1e-4)
    assert np.allclose(seen["to_camera"], [0, 0, 1])
    assert np.allclose(seen["spacing"], 3.0 / SIZE[1] * device_scene.scene.placement.scale)


@pytest.mark.parametrize("orthographic", [False, True])
def test_the_view_begins_where_the_camera_says(orthographic: bool) -> None:
    """A wall a little before that place is cut away, one a little behind it is seen, wherever in the picture."""
    walls = [quad([-3, -3, z], [6, 0, 0], [0, 6, 0], number) for number, z in enumerate((-0.9, -1.1))]
    device_scene = resident_of(walls, [grey(0.2), grey(0.6)])
    base = look_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    for near, albedo, depth in ((0.0, 0.2, 0.9), (0.89, 0.2, 0.9), (0.91, 0.6, 1.1)):
        camera = Camera("cut", base.to_world, 1.0, orthographic=orthographic, near=near)
        seen = look(device_scene, camera)
        assert np.allclose(seen["albedo"], albedo)
        distance = np.linalg.norm(in_camera(camera, device_scene, seen["position"]), axis=-1)
        scale = device_scene.scene.placement.scale
        wanted = 1.0 if orthographic else distance * scale
        assert np.allclose(seen["spacing"], wanted * 2.0 / SIZE[1] * (scale if orthographic else 1.0), rtol=1e-3)
        assert np.allclose(in_camera(camera, device_scene, seen["position"])[..., 2], -depth, atol=1e-3)


@pytest.mark.parametrize(("sides", "seen"), [(False, 0.6), (True, 0.2), (None, 0.2)])
def test_rooms_of_one_sided_walls_are_seen_from_outside(sides: bool | None, seen: float) -> None:
    near = quad([-1, -1, 0.5], [0, 2, 0], [2, 0, 0], 0)  # faces away from the camera
    materials = [replace(grey(albedo), double_sided=sides) for albedo in (0.2, 0.6)]
    device_scene = resident_of([near, quad([-1, -1, -0.5], [2, 0, 0], [0, 2, 0], 1)], materials)
    assert np.allclose(look(device_scene, look_at((0.0, 0.0, 1.5), (0.0, 0.0, 0.0), yfov_degrees=20.0))["albedo"], seen)


def test_pixels_beside_the_scene_show_the_sky() -> None:
    device_scene = resident_of(
        [quad([-1, -1, 0], [1, 0, 0], [0, 2, 0])], [grey(0.5, emission=2.0)], sky=Sky((1.0, 2.0, 4.0))
    )
    seen = look(device_scene, look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), yfov_degrees=30.0))
    left, right = seen["face"][8, 10], seen["face"][8, 14]
    assert left >= 0
    assert right == int(NO_HIT)
    assert np.allclose(seen["emitted"][8, 10], 2.0)
    up = -seen["to_camera"][..., 1]
    sky = np.array([1.0, 2.0, 4.0]) * (0.5 + 0.5 * up[..., None])
    missed = seen["face"] == int(NO_HIT)
    assert np.allclose(seen["emitted"][missed], sky[missed], rtol=1e-4)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_surfaces_face_the_camera_and_pass_on_all_their_light(side: float) -> None:
    device_scene = resident_of([quad([-1, -1, 0], [2, 0, 0], [0, 2, 0])], [grey(0.3)])
    seen = look(device_scene, look_at((0.0, 0.0, 0.5 * side), (0.0, 0.0, 0.0)))
    assert np.allclose(seen["geometric_normal"], [0, 0, side])
    assert np.allclose(seen["throughput"], 1.0)
    assert np.allclose(seen["albedo"], 0.3)
    assert np.allclose(seen["emitted"], 0.0)


def test_a_second_picture_forgets_the_first() -> None:
    device_scene = resident_of([quad([-1, -1, 0], [2, 0, 0], [0, 2, 0])], [grey(0.3, emission=1.0)])
    gbuffer = allocate(GBuffer, SIZE[0] * SIZE[1], device_scene.device)
    for target, expected in (((0.0, 0.0, 0.0), 1.0), ((0.0, 0.0, 5.0), 0.0)):
        camera = look_at((0.0, 0.0, 0.5), target)
        data = camera_of(device_scene, camera, SIZE)
        trace_primary_rays(device_scene.data, data, SIZE, gbuffer, chain_samples(device_scene.device))
        assert np.allclose(gbuffer.emitted.numpy(), expected)
        assert ((gbuffer.face.numpy() != int(NO_HIT)) == (expected > 0.0)).all()


def test_cloth_reflects_even_light_by_its_fibres_and_what_is_below() -> None:
    velvet = replace(grey(0.5), sheen_color=(0.0, 0.5, 0.0), sheen_roughness=0.5)
    seen = look(resident_of([*box()], [velvet]), look_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), yfov_degrees=5.0))
    assert np.allclose(seen["sheen"], [0.0, 0.5, 0.0, 0.5])
    fibres, taken = 0.5 * 0.027, 0.5 * 0.144  # E(1, 0.5) of the green channel, and the mean of what either way takes
    assert np.allclose(seen["albedo"], 0.5 * (1.0 - taken) + np.array([0.0, fibres, 0.0]), atol=0.006)
    assert np.allclose(seen["diffuse"], 0.5 * (1.0 - fibres), atol=0.005)


def test_below_a_film_there_is_what_its_brightest_colour_leaves() -> None:
    film = Material(base_color=(0.5, 0.5, 0.5, 1.0), iridescence=1.0, iridescence_ior=1.8, iridescence_most=250.0)
    seen = look(resident_of([*box()], [film]), look_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), yfov_degrees=5.0))
    f0, below = seen["f0"], seen["diffuse"]
    assert np.ptp(f0, axis=2).min() > 0.1
    assert np.allclose((1.0 - f0) * below, 0.5 * (1.0 - f0.max(axis=2, keepdims=True)), atol=0.005)
