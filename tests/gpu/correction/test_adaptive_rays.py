"""Rays of the shading points that may be brightest."""

import numpy as np
import pytest
import warp as wp
from bright import SIZE, Bright, picture_of

from gpu.core.sample_mean import SAMPLES
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.indirect.far_field import VISIBILITY_WEIGHT_PARAMETERS
from gpu.indirect.irradiance import CHECKS

# What frames use, written again, so that a change of it fails.
RAYS, MOST_FRAMES, OWN_SHARE, DARKER, TRUST, LEAST = 24, 6, 0.45, 0.25, 0.6, 0.05


@wp.kernel
def reflectance_kernel(gbuffer: GBuffer, out: wp.array[wp.vec3]) -> None:
    """One thread a pixel."""
    pixel = wp.tid()
    out[pixel] = reflectance(gbuffer, pixel)


@pytest.fixture(scope="module")
def bright() -> Bright:
    return Bright(picture_of(far_field_sums=True), SIZE[0] * SIZE[1])


def test_those_that_may_be_brightest_have_rays() -> None:
    bright = Bright(picture_of(far_field_sums=True), SIZE[0] * SIZE[1], 1.0)
    fuzzy, view = bright.fuzzy, bright.view
    reflected = wp.zeros(view.pixels, dtype=wp.vec3, device=view.device)
    wp.launch(reflectance_kernel, view.pixels, [view.gbuffer, reflected], device=view.device)
    count = fuzzy.sp_count
    most = (view.indirect.unoccluded_near.numpy() + view.indirect.unoccluded_far.numpy())[:count]
    most = most * reflected.numpy()[fuzzy.pixels].mean(axis=1)
    # Ten samples are brighter than the one that tells what is bright.
    samples = np.full(SAMPLES, 1e-9)
    samples[:10], samples[10] = 1e9, np.median(most) / 0.6
    bright.picture.samples.assign(samples)
    bright.points.trace(view.scene, view.gbuffer, view.shading_points, fuzzy.known, view.indirect, view.seed,
                        bright.picture)  # fmt: skip
    chosen = bright.points.pixels.numpy()[: bright.points.count.numpy()[0]]
    assert np.array_equal(np.isin(fuzzy.pixels, chosen), most >= np.float32(np.median(most)))
    few = Bright(fuzzy, 20)
    brightest = np.isin(fuzzy.pixels, few.trace())
    assert brightest.sum() == 20
    assert most[brightest].min() > 0.93 * most[~brightest].max()  # keys are steps of 2 ^ (1 / 16)


def test_points_whose_light_no_ray_would_find_have_none() -> None:
    """Half of them see so little of all light, by their clusters, that one in 300 rays would find some."""
    bright = Bright(picture_of(far_field_sums=True), SIZE[0] * SIZE[1], 1e-3)
    fuzzy, indirect = bright.fuzzy, bright.view.indirect
    whole = indirect.unoccluded_near.numpy() + indirect.unoccluded_far.numpy()
    hidden = np.arange(len(whole)) % 2 == 1
    seen = np.where(hidden, 1.0 / 300.0, 1.0 / 200.0) * whole
    least = VISIBILITY_WEIGHT_PARAMETERS.hidden
    indirect.near_importance.fill_(0.0)
    indirect.far_importance.assign((least * whole + (1.0 - least) * seen).astype(np.float32))
    chosen = np.isin(fuzzy.pixels, bright.trace())
    lit = whole[: fuzzy.sp_count] > 0.0
    assert np.array_equal(chosen[lit], ~hidden[: fuzzy.sp_count][lit])


def test_a_point_that_speaks_for_those_beside_it_has_no_rays(bright: Bright) -> None:
    listed = bright.view.shading_points.listed
    before = listed.numpy().copy()
    pixel = int(next(p for p in bright.trace() if 0 < p % SIZE[0] < SIZE[0] - 1 and 0 < p // SIZE[0] < SIZE[1] - 1))
    alone = before.reshape(SIZE[1], SIZE[0]).copy()
    row, across = divmod(pixel, SIZE[0])
    alone[row - 1 : row + 2, across - 1 : across + 2] = 0
    alone[row, across] = 1
    try:
        listed.assign(alone.ravel())
        assert pixel not in bright.trace()
    finally:
        listed.assign(before)
    assert pixel in bright.trace()


def test_what_rays_find_counts_beside_what_frames_before_knew(bright: Bright) -> None:
    pixels = bright.trace()
    told = bright.fuzzy.irradiance()
    found, known = bright.found(), np.full((bright.view.pixels, 3), 1.0)
    for frames in (0, 2, 20):
        light, shown = bright.take(told, known, known, frames)
        share = RAYS / (RAYS + CHECKS * min(frames + 1, MOST_FRAMES))
        mean = 1.0 + (found[pixels] - 1.0) * share
        assert light[pixels] == pytest.approx(mean, rel=1e-4, abs=1e-5)
        lacking = np.zeros_like(known)
        lacking[pixels] = mean - 1.0
        mixed = 1.0 + OWN_SHARE * lacking[pixels] + (1.0 - OWN_SHARE) * bright.shared(pixels, lacking, told)
        kept = np.minimum(mean, told[pixels]).mean(axis=1) * DARKER > 1.0
        assert not kept.all()
        least = np.minimum(told[pixels] * LEAST / (frames + 1), 1.0)
        assert shown[pixels][~kept] == pytest.approx(np.maximum(mixed, least)[~kept], rel=1e-3, abs=1e-4)
        others = np.setdiff1d(np.arange(bright.view.pixels), pixels)
        assert (light[others] == 1.0).all()
        assert (shown[others] == 1.0).all()


def test_a_share_of_what_clusters_tell_is_taken_for_granted(bright: Bright) -> None:
    pixels, told = bright.trace(), bright.fuzzy.irradiance()
    none = np.zeros_like(told)
    once, twice = (bright.take(clustered, none, none, 0)[0][pixels] for clustered in (told, 2.0 * told))
    granted = TRUST * RAYS / (RAYS + CHECKS) * told[pixels]
    assert twice - once == pytest.approx(granted, rel=1e-3, abs=1e-5)


def test_points_that_were_listed_once_tell_nothing_any_more(bright: Bright) -> None:
    fuzzy, told = bright.fuzzy, bright.fuzzy.irradiance()
    none = np.zeros_like(told)
    many = Bright(fuzzy, fuzzy.view.pixels)
    before = many.trace()
    many.take(told, none, none, 0)
    many.dim = 1.0
    few = many.trace()
    assert 0 < len(few) < len(before)
    fresh = Bright(fuzzy, fuzzy.view.pixels, 1.0)
    fresh.trace()
    for seen, expected in zip(many.take(told, none, told, 0), fresh.take(told, none, told, 0), strict=True):
        assert np.array_equal(seen, expected)


def test_what_was_found_to_be_much_darker_is_shown_as_it_is_and_tells_nothing(bright: Bright) -> None:
    pixels, told = bright.trace(), bright.fuzzy.irradiance()
    found = bright.found()[pixels].mean(axis=1)
    dark = np.full((bright.view.pixels, 3), 0.2 * DARKER * found.max() * RAYS / (RAYS + CHECKS))
    light, shown = bright.take(told, np.zeros_like(dark), dark, 0)
    kept = dark[pixels].mean(axis=1) < DARKER * np.minimum(light, told)[pixels].mean(axis=1)
    assert kept.any()
    assert shown[pixels[kept]] == pytest.approx(dark[pixels[kept]])
    others, lacking = pixels[~kept], light - dark
    mixed = dark[others] + OWN_SHARE * lacking[others] + (1.0 - OWN_SHARE) * bright.shared(others, lacking, told)
    least = np.minimum(told[others] * LEAST, dark[others])
    assert shown[others] == pytest.approx(np.maximum(mixed, least), rel=1e-3, abs=1e-4)


def test_where_clusters_told_too_little_rays_that_find_more_are_shown(bright: Bright) -> None:
    """Such points are as dark as clusters told, and no rays before found them to be so."""
    pixels, told = bright.trace(), np.full((bright.view.pixels, 3), 1e-6)
    light, shown = bright.take(told, np.zeros_like(told), told, 0)
    found = light[pixels].mean(axis=1)
    assert shown[pixels].mean() == pytest.approx(found.mean(), rel=0.1)
    assert (shown[pixels].mean(axis=1) > 0.1 * found)[found > np.median(found)].all()


def test_where_rays_find_nothing_some_of_what_clusters_tell_is_left_but_nothing_becomes_brighter(
    bright: Bright,
) -> None:
    """Black specks would show what rays miss by chance."""
    pixels, pixel_count = bright.trace(), bright.view.pixels
    told, none = np.full((pixel_count, 3), 1e6), np.full((pixel_count, 3), -1e7)
    for before, frames, left in ((1e6, 0, LEAST), (1e6, 3, LEAST / 4.0), (1e4, 0, 0.01)):
        shown = bright.take(told, none, np.full((pixel_count, 3), before), frames)[1][pixels]
        assert shown == pytest.approx(np.full_like(shown, 1e6 * left), rel=1e-4)
