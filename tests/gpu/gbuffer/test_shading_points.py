import numpy as np
import pytest
import warp as wp
from scenes import column
from walls import HEIGHT, WIDTH, wall

from gpu.core.device import allocate
from gpu.core.morton import morton_order
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints

CPU = wp.get_device("cpu")


def gbuffer_with(valid: np.ndarray) -> GBuffer:
    """A G-buffer whose pixels have a surface where `valid`, each at its own index along x."""
    gbuffer = allocate(GBuffer, valid.size, CPU)
    gbuffer.face.assign(np.where(valid.ravel(), 0, -1).astype(np.int32))
    positions = np.zeros((valid.size, 3), np.float32)
    positions[:, 0] = np.arange(valid.size)
    gbuffer.position.assign(positions)
    gbuffer.spacing.assign(np.ones(valid.size, np.float32))
    return gbuffer


def test_every_pixel_is_shaded_where_that_is_asked_for() -> None:
    gbuffer, sps = gbuffer_with(np.ones((20, 30), bool)), ShadingPoints((30, 20), 2, CPU)
    gbuffer.normal.assign(np.tile(np.float32([0.0, 1.0, 0.0]), (600, 1)))
    gbuffer.geometric_normal.assign(gbuffer.normal)
    sps.find(gbuffer)
    assert sps.count.numpy()[0] < 300
    sps.find(gbuffer, every=True)
    assert sps.count.numpy()[0] == 600
    assert (sps.listed.numpy() == 1).all()


def test_only_pixels_with_a_surface_are_listed() -> None:
    valid = np.random.default_rng(0).uniform(size=(20, 30)) < 0.4
    sps = ShadingPoints((30, 20), 1, CPU)
    sps.find(gbuffer_with(valid))
    count = sps.count.numpy()[0]
    assert count == valid.sum()
    listed = sps.pixels.numpy()[:count]
    assert set(listed) == set(np.flatnonzero(valid))
    assert np.array_equal(listed, [pixel for pixel in morton_order((30, 20), CPU).numpy() if valid.flat[pixel]])


def test_with_a_stride_fewer_are_listed_in_the_same_order() -> None:
    sps = ShadingPoints((WIDTH, HEIGHT), 2, CPU)
    sps.find(wall())
    listed = sps.pixels.numpy()[: sps.count.numpy()[0]]
    assert WIDTH * HEIGHT / 4 <= len(listed) < WIDTH * HEIGHT / 3
    among = set(listed)
    assert np.array_equal(listed, [pixel for pixel in morton_order((WIDTH, HEIGHT), CPU).numpy() if pixel in among])


def test_a_term_is_added_at_the_points_alone() -> None:
    sps = ShadingPoints((30, 20), 1, CPU)
    valid = np.random.default_rng(2).uniform(size=600) < 0.4
    sps.find(gbuffer_with(valid))
    term, total = np.random.default_rng(3).uniform(-2.0, 2.0, (2, 600, 3))
    result = column(total, wp.vec3)
    sps.add(column(term, wp.vec3), result)
    assert result.numpy() == pytest.approx(np.where(valid[:, None], total + term, total), rel=1e-5, abs=1e-6)
