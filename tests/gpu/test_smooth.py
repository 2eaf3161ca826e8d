import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import column

from gpu.device import allocate
from gpu.gbuffer import GBuffer
from gpu.smooth import Smoothing

WIDTH, HEIGHT = 48, 40
CPU = wp.get_device("cpu")


def wall(normals: NDArray | None = None, depth: NDArray | None = None, seen: NDArray | None = None) -> GBuffer:
    """A G-buffer of a wall that faces the camera, one unit a pixel; all arguments (height, width, …)."""
    count = WIDTH * HEIGHT
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    z = np.zeros((HEIGHT, WIDTH)) if depth is None else depth
    up = np.zeros((HEIGHT, WIDTH, 3))
    up[..., 2] = 1.0
    up = up if normals is None else normals
    gbuffer = allocate(GBuffer, count, CPU)
    gbuffer.position.assign(np.stack([x, -y, z], axis=2).reshape(count, 3).astype(np.float32))
    gbuffer.normal.assign(up.reshape(count, 3).astype(np.float32))
    gbuffer.geometric.assign(up.reshape(count, 3).astype(np.float32))
    gbuffer.spacing.assign(np.ones(count, np.float32))
    visible = np.ones((HEIGHT, WIDTH), bool) if seen is None else seen
    gbuffer.face.assign(np.where(visible.ravel(), 0, -1).astype(np.int32))
    return gbuffer


def smoothed(gbuffer: GBuffer, light: NDArray) -> NDArray:
    """`light` (height, width) after smoothing."""
    values = column(np.repeat(light.reshape(-1, 1), 3, axis=1), wp.vec3)
    Smoothing((WIDTH, HEIGHT), CPU).run(gbuffer, values)
    return values.numpy()[:, 0].reshape(HEIGHT, WIDTH)


def noise(seed: int = 0) -> NDArray:
    """What one shadow ray a pixel gives in a penumbra."""
    return np.random.default_rng(seed).integers(0, 2, (HEIGHT, WIDTH)).astype(float)


def test_even_light_stays_as_it_is() -> None:
    assert smoothed(wall(), np.full((HEIGHT, WIDTH), 0.3)) == pytest.approx(0.3, rel=1e-6)


def test_noise_falls_and_its_mean_stays() -> None:
    light = noise()
    result = smoothed(wall(), light)
    assert result.var() < light.var() / 10.0
    assert result.mean() == pytest.approx(light.mean(), abs=0.02)


def test_a_sharp_shadow_without_noise_stays_sharp() -> None:
    light = np.zeros((HEIGHT, WIDTH))
    light[:, WIDTH // 2 :] = 1.0
    result = smoothed(wall(), light)
    # Only the two columns at the edge see both sides around them.
    assert np.array_equal(np.delete(result, [WIDTH // 2 - 1, WIDTH // 2], axis=1), np.delete(light, [23, 24], axis=1))


def test_nothing_crosses_the_edges_of_surfaces() -> None:
    left = np.arange(WIDTH)[None, :] < WIDTH // 2
    left = np.repeat(left, HEIGHT, axis=0)
    normals = np.where(left[..., None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    for gbuffer in (wall(normals=normals), wall(depth=np.where(left, 0.0, 50.0)), wall(seen=left)):
        light = np.where(left, noise(), 100.0 + noise(1))
        result = smoothed(gbuffer, light)
        assert result[left].max() <= 1.0
        assert result[~left].min() >= 100.0


def test_pixels_without_a_surface_keep_their_light() -> None:
    light = noise()
    assert np.array_equal(smoothed(wall(seen=np.zeros((HEIGHT, WIDTH), bool)), light), light)
