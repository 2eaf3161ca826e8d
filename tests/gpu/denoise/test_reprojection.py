"""Where points of this frame were in the last one, and how much of what was known there is of their surface."""

import numpy as np
import pytest
import warp as wp
from scenes import column, results
from walls import CPU, HEIGHT, WIDTH, wall

from gpu.core.image_size import image_size
from gpu.denoise.reprojection import (
    REPROJECTION_PARAMETERS,
    PreviousFrameData,
    ReprojectionParameters,
    bilinear_tap,
    blend,
    previous_place,
)
from gpu.gbuffer.camera_rays import CameraData, camera_data
from gpu.gbuffer.gbuffer import GBuffer
from gpu.scene.camera import look_at
from gpu.scene.types import Doubles, Placement


@wp.kernel
def share_kernel(first: int, previous: PreviousFrameData, frames: wp.array[int], gbuffer: GBuffer, pixel: int,
                 place: wp.vec2, step: int, chosen: ReprojectionParameters, out: wp.array[float]) -> None:  # fmt: skip
    """One thread a corner: its share."""
    corner = first + wp.tid()
    out[corner] = bilinear_tap(previous, frames, gbuffer, pixel, place, corner, step, chosen.plane_tolerance).share


def shares(
    gbuffer: GBuffer, place: tuple[float, float], step: int = 1, known: int = 1, *, chains: bool = False
) -> Doubles:
    """Of the four pixels around a place of a plane wall, for the last frame's pixels of such depths."""
    pixel, flat = 20 * WIDTH + 20, wall()
    flat.chains = chains
    flat.to_camera.fill_(wp.vec3(0.0, 0.0, 1.0))
    previous = PreviousFrameData()
    previous.image, previous.position, previous.normal = image_size((WIDTH, HEIGHT)), gbuffer.position, gbuffer.normal
    frames = wp.full(WIDTH * HEIGHT, known, dtype=int, device=CPU)
    inputs = [previous, frames, flat, pixel, wp.vec2(*place), step, REPROJECTION_PARAMETERS]
    return np.asarray(results(share_kernel, 4, inputs, float), np.float64)


def test_shares_are_bilinear_on_a_plane() -> None:
    assert shares(wall(), (20.25, 20.5)) == pytest.approx([0.375, 0.125, 0.375, 0.125])
    assert shares(wall(), (20.5, 20.0), step=2) == pytest.approx([0.75, 0.25, 0.0, 0.0])


def test_what_is_off_the_plane_by_half_a_spacing_a_step_counts_less_by_e() -> None:
    for step in (1, 2):
        off = shares(wall(depth=np.full((HEIGHT, WIDTH), 0.5 * step)), (20.5, 20.5), step)
        assert off == pytest.approx(shares(wall(), (20.5, 20.5), step) / np.e, rel=1e-5)


def test_what_chains_saw_elsewhere_on_the_plane_tells_nothing() -> None:
    for away in ((25.5, 20.5), (20.5, 12.5)):
        assert shares(wall(), away).any()
        assert not shares(wall(), away, chains=True).any()
    assert shares(wall(), (20.25, 20.5), chains=True) == pytest.approx(shares(wall(), (20.25, 20.5)))


@wp.kernel
def place_kernel(first: int, previous: PreviousFrameData, gbuffer: GBuffer, out: wp.array[wp.vec2]) -> None:
    pixel = first + wp.tid()
    out[pixel] = previous_place(previous, gbuffer, pixel)


@pytest.mark.parametrize("chains", [False, True])
def test_points_in_mirrors_are_looked_for_where_they_seem_to_be(chains: bool) -> None:
    """There, not where they are, the last frame saw them, too."""
    camera = look_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), yfov_degrees=90.0, aspect=WIDTH / HEIGHT)
    previous = PreviousFrameData()
    data = camera_data(camera, Placement((0.0, 0.0, 0.0), 1.0), WIDTH / HEIGHT)
    previous.camera, previous.image = wp.array([data], dtype=CameraData, device=CPU), image_size((WIDTH, HEIGHT))
    gbuffer = wall()
    gbuffer.chains = chains
    gbuffer.position.fill_(wp.vec3(0.5, 0.0, -1.0))
    gbuffer.apparent.fill_(wp.vec3(-0.5, 0.0, -2.0))
    across = -0.25 if chains else 0.5  # of half the height
    expected = (0.5 * WIDTH + across * 0.5 * HEIGHT - 0.5, 0.5 * HEIGHT - 0.5)
    assert results(place_kernel, 1, [previous, gbuffer], wp.vec2)[0] == pytest.approx(expected, abs=1e-3)


def test_nothing_is_beyond_the_image_or_where_nothing_is_known() -> None:
    assert shares(wall(), (WIDTH - 0.5, 20.0)) == pytest.approx([0.5, 0.0, 0.0, 0.0])
    assert shares(wall(), (-0.25, -0.5)) == pytest.approx([0.0, 0.0, 0.0, 0.375])
    assert not shares(wall(), (20.25, 20.5), known=0).any()


@wp.kernel
def blend_kernel(first: int, frames: wp.array[int], out: wp.array[wp.vec3]) -> None:
    """One thread a number of frames of light 2 before one of light 1."""
    index = first + wp.tid()
    out[index] = blend(wp.vec3(1.0, 1.0, 1.0), wp.vec3(2.0, 2.0, 2.0), frames[index], 8)


def test_a_frame_counts_as_one_of_all_up_to_the_most() -> None:
    blended = results(blend_kernel, 4, [column([0, 1, 3, 20], wp.int32)], wp.vec3)[:, 0]
    assert blended == pytest.approx([1.0, 1.5, 1.75, 2.0 - 1.0 / 8.0])
