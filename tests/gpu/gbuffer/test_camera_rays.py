from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scenes import results

from gpu.core.image_size import ImageSize, image_size
from gpu.gbuffer.camera_rays import CameraData, camera_data, image_point, pixel_of, pixel_ray
from gpu.scene.camera import look_at
from gpu.scene.types import Placement

SIZE = (24, 16)
PIXELS = SIZE[0] * SIZE[1]
PLACEMENT = Placement(centre=(1.0, 2.0, 3.0), scale=0.5)
CAMERA = look_at((1.2, 2.1, 4.0), (1.0, 2.0, 3.0), yfov_degrees=60.0)


@wp.kernel
def ahead_kernel(first: int, camera: CameraData, image: ImageSize, distance: float, out: wp.array[wp.vec3]) -> None:
    """One thread a pixel: a point on its ray."""
    pixel = first + wp.tid()
    ray = pixel_ray(camera, pixel, image)
    out[pixel] = ray.origin + ray.direction * distance


@wp.kernel
def image_kernel(first: int, camera: CameraData, image: ImageSize, points: wp.array[wp.vec3],
                 out: wp.array[wp.vec4]) -> None:  # fmt: skip
    """One thread a point: where it is in the image, and its pixel."""
    index = first + wp.tid()
    place = image_point(camera, points[index], image)
    pixel = pixel_of(camera, points[index], image)
    out[index] = wp.vec4(place[0], place[1], float(pixel[0]), float(pixel[1]))


@pytest.mark.parametrize("place", [(0.5, 0.5), (0.1, 0.8)])
@pytest.mark.parametrize("orthographic", [False, True])
def test_a_point_on_a_pixels_ray_is_found_in_that_pixel(orthographic: bool, place: tuple[float, float]) -> None:
    camera = replace(CAMERA, orthographic=orthographic, half_height=0.3 if orthographic else CAMERA.half_height)
    data, image = camera_data(camera, PLACEMENT, 1.5, place), image_size(SIZE)
    points = results(ahead_kernel, PIXELS, [data, image, 0.4], wp.vec3)
    found = results(image_kernel, PIXELS, [data, image, wp.array(points, dtype=wp.vec3, device="cpu")], wp.vec4)
    y, x = np.divmod(np.arange(PIXELS), SIZE[0])
    assert np.allclose(found[:, :2], np.stack([x, y], axis=1), atol=1e-3)
    assert np.array_equal(found[:, 2:], np.stack([x, y], axis=1))


def test_what_is_behind_or_beside_is_outside() -> None:
    data, image = camera_data(CAMERA, PLACEMENT, 1.5), image_size(SIZE)
    behind = np.array(data.origin) + np.array(data.back)
    beside = np.array(data.origin) - np.array(data.back) + 9.0 * np.array(data.right)
    points = wp.array([behind, beside], dtype=wp.vec3, device="cpu")
    assert (results(image_kernel, 2, [data, image, points], wp.vec4) == -1.0).all()


@pytest.mark.parametrize("orthographic", [False, True])
def test_what_is_cut_away_is_outside(orthographic: bool) -> None:
    data, image = camera_data(replace(CAMERA, orthographic=orthographic, near=0.6), PLACEMENT, 1.5), image_size(SIZE)
    ahead = [np.array(data.origin) - depth * np.array(data.back) for depth in (0.29, 0.31)]
    found = results(image_kernel, 2, [data, image, wp.array(ahead, dtype=wp.vec3, device="cpu")], wp.vec4)
    assert (found[0, :2] == -1.0).all()
    assert (found[1, :2] >= 0.0).all()


def test_cameras_are_placed_in_unit_space() -> None:
    data = camera_data(CAMERA, PLACEMENT, 1.5)
    assert np.allclose(data.origin, (np.array([1.2, 2.1, 4.0]) - PLACEMENT.centre) * PLACEMENT.scale)
    assert data.half_width == pytest.approx(1.5 * data.half_height)
    flat = camera_data(replace(CAMERA, orthographic=True, half_height=0.3), PLACEMENT, 1.0)
    assert flat.half_height == pytest.approx(0.3 * PLACEMENT.scale)
