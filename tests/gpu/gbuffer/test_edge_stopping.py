import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from scenes import results
from walls import HEIGHT, WIDTH, wall

from gpu.gbuffer.edge_stopping import edge_stopping_weight, gloss_weight
from gpu.gbuffer.gbuffer import GBuffer

PIXEL = 5 * WIDTH + 10
TOLERANCE = 0.5


@wp.kernel
def kinship_kernel(first: int, gbuffer: GBuffer, pixel: int, step: int, tolerance: float,
                   out: wp.array[float]) -> None:  # fmt: skip
    """One thread a pixel: its share in `pixel`."""
    other = first + wp.tid()
    out[other] = edge_stopping_weight(gbuffer, pixel, other, step, tolerance)


def shares(gbuffer: GBuffer, step: int = 1) -> NDArray:
    """What every pixel has in PIXEL, (pixel,)."""
    return results(kinship_kernel, WIDTH * HEIGHT, [gbuffer, PIXEL, step, TOLERANCE], float)


def test_pixels_of_one_plane_are_kin_however_far_apart() -> None:
    assert shares(wall()) == pytest.approx(1.0)


def test_pixels_without_a_surface_are_nobodys_kin() -> None:
    seen = np.random.default_rng(0).uniform(size=(HEIGHT, WIDTH)) < 0.5
    assert np.array_equal(shares(wall(seen=seen)), seen.ravel())


def test_kinship_falls_as_normals_turn_away() -> None:
    angles = np.linspace(0.0, np.pi, WIDTH * HEIGHT).reshape(HEIGHT, WIDTH)
    gbuffer = wall(normals=np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=2))
    own = angles.ravel()[PIXEL]
    # The plane is PIXEL's own: nothing else lies in it, so only normals may count here.
    gbuffer.position.fill_(0.0)
    expected = np.maximum(np.cos(angles.ravel() - own), 0.0) ** 16.0
    assert shares(gbuffer) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("step", [1, 4])
def test_kinship_falls_off_the_plane_by_spacings_a_step(step: int) -> None:
    depth = np.random.default_rng(1).uniform(-3.0, 3.0, (HEIGHT, WIDTH))
    depth.flat[PIXEL] = 0.0
    gbuffer = wall(depth=depth)
    gbuffer.spacing.fill_(1.5)
    limit = TOLERANCE * 1.5 * step
    assert shares(gbuffer, step) == pytest.approx(np.exp(-((depth.ravel() / limit) ** 2)), abs=1e-4)


def test_what_chains_saw_apart_is_not_kin() -> None:
    """Kin are less than four spacings a step away, more where the surface is seen at a slant."""
    gbuffer = wall()
    gbuffer.chains = True
    gbuffer.to_camera.fill_(wp.vec3(0.8, 0.0, 0.6))
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    away = np.hypot(x - 10, y - 5).ravel()
    for step in (1, 2):
        assert np.array_equal(shares(gbuffer, step) > 0.0, 0.6 * away <= 4.0 * step)


@wp.kernel
def gloss_kernel(first: int, gbuffer: GBuffer, pixel: int, out: wp.array[float]) -> None:
    """One thread a pixel: how far it reflects as `pixel` does."""
    other = first + wp.tid()
    out[other] = gloss_weight(gbuffer, pixel, other)


def test_narrow_lobes_reflect_like_others_of_their_roughness_and_share_alone() -> None:
    """Pixels by number: as PIXEL, rougher by a tolerance, matt, metal, and the rest are rough."""
    gbuffer = wall()
    roughness, f0 = np.full(WIDTH * HEIGHT, 0.9, np.float32), np.full((WIDTH * HEIGHT, 3), 0.25, np.float32)
    diffuse, f90 = 3.0 * f0, np.ones(WIDTH * HEIGHT, np.float32)
    roughness[[0, 1, 3, PIXEL]] = 0.3, 0.35, 0.3, 0.3
    f90[2], diffuse[3] = 0.0, 0.0
    for name, values in {"roughness": roughness, "f0": f0, "diffuse": diffuse, "f90": f90}.items():
        getattr(gbuffer, name).assign(values)
    alike = results(gloss_kernel, WIDTH * HEIGHT, [gbuffer, PIXEL], float)
    assert (alike == 1.0).all()
    gbuffer.gloss = True
    alike = results(gloss_kernel, WIDTH * HEIGHT, [gbuffer, PIXEL], float)
    assert alike[:2] == pytest.approx([1.0, np.exp(-1.0)], rel=1e-3)
    assert (alike[2:PIXEL] < 1e-4).all()
    rough = results(gloss_kernel, WIDTH * HEIGHT, [gbuffer, PIXEL + 1], float)
    assert rough[2] == rough[PIXEL + 2] == 1.0
    assert rough[PIXEL] < 1e-4
