"""Rays of the shading points that may be brightest."""

from itertools import product

import numpy as np
import pytest
import warp as wp
from pipeline import Pipeline
from scenes import column, slats

from gpu.correction.adaptive_ray_sampling import RAYS, TRUST
from gpu.correction.adaptive_rays import BINOMIAL, BRIGHTER, DARKER, FRAMES, LEAST_BRIGHT, OWN, BrightPoints
from gpu.correction.brightness import SAMPLES, MeanBrightness
from gpu.denoise.atrous import ATROUS_PARAMETERS
from gpu.gbuffer.edge_stopping import NORMAL_POWER
from gpu.gbuffer.gbuffer import GBuffer, reflectance
from gpu.indirect.irradiance import CHECKS
from gpu.scene.types import Doubles, Ints

SEEDS = 200
SIZE = (16, 12)


@wp.kernel
def reflectance_kernel(gbuffer: GBuffer, out: wp.array[wp.vec3]) -> None:
    """One thread a pixel."""
    pixel = wp.tid()
    out[pixel] = reflectance(gbuffer, pixel)


class Bright:
    """The brightest of a pipeline's SPs. dim: how bright the picture is taken to be, so that many are bright."""

    def __init__(self, fuzzy: Pipeline, capacity: int, dim: float = 0.2) -> None:
        self.fuzzy, self.view, self.dim = fuzzy, fuzzy.view, dim
        self.points = BrightPoints(fuzzy.size, capacity, fuzzy.view.device)
        self.picture = MeanBrightness(fuzzy.view.device)

    def trace(self, seed: int = 0) -> Ints:
        """The pixels of those that have rays now."""
        fuzzy, view = self.fuzzy, self.view
        view.seed.fill_(seed)
        dim = column(self.dim * fuzzy.irradiance(), wp.vec3)
        self.picture.find(view.gbuffer, view.shading_points, dim)
        self.points.trace(view.scene, view.gbuffer, view.shading_points, fuzzy.known, view.indirect, view.seed,
                          self.picture)  # fmt: skip
        return np.asarray(self.points.pixels.numpy()[: self.points.count.numpy()[0]])

    def take(self, told: Doubles, known: Doubles, shown: Doubles, frames: int) -> tuple[Doubles, Doubles]:
        """Light and irradiance (pixel, 3) once the rays are taken into `known` light and the irradiance `shown`."""
        light, irradiance = column(known, wp.vec3), column(shown, wp.vec3)
        before = wp.full(self.view.pixels, frames, dtype=int, device=self.view.device)
        self.points.take(self.view.gbuffer, self.fuzzy.lights, column(told, wp.vec3), before, light, irradiance)
        return light.numpy().astype(np.float64), irradiance.numpy().astype(np.float64)

    def found(self, frames: int = 0) -> Doubles:
        """What the rays say that the light is, (pixel, 3)."""
        told, none = self.fuzzy.irradiance(), np.zeros((self.view.pixels, 3))
        return self.take(told, none, none, frames)[0] * (RAYS + CHECKS * (frames + 1)) / RAYS

    def shared(self, pixels: Ints, lacking: Doubles, told: Doubles) -> Doubles:
        """What SPs at `pixels` lack as those of them around each tell it, (place, 3); told, lacking (pixel, 3)."""
        gbuffer, (width, height), brightness = self.view.gbuffer, self.fuzzy.size, told.mean(axis=1)
        position, normal, geometric_normal = (
            getattr(gbuffer, name).numpy() for name in ("position", "normal", "geometric_normal")
        )
        means = []
        for pixel in pixels:
            row, column = divmod(pixel, width)
            weights = np.zeros(self.view.pixels)
            for across, down in product(range(-2, 3), repeat=2):
                other = (row + down) * width + column + across
                if not (0 <= row + down < height and 0 <= column + across < width and other in pixels):
                    continue
                off = geometric_normal[pixel] @ (position[other] - position[pixel])
                limit = ATROUS_PARAMETERS.plane_tolerance * gbuffer.spacing.numpy()[pixel] * 2
                edge_stopping_weight = max(normal[pixel] @ normal[other], 0.0) ** float(NORMAL_POWER) * np.exp(
                    -((off / limit) ** 2)
                )
                unlike = abs(brightness[other] - brightness[pixel]) / (
                    ATROUS_PARAMETERS.guide_tolerance * brightness[pixel]
                )
                weights[other] = BINOMIAL[abs(across)] * BINOMIAL[abs(down)] * edge_stopping_weight * np.exp(-unlike)
            means.append(weights @ lacking / weights.sum())
        return np.array(means)


def picture_of(*, far_field_sums: bool) -> Pipeline:
    """Every VPL a cluster of its own: then light of members and of clusters is the same."""
    device_scene, camera, _ = slats()
    return Pipeline(
        device_scene, camera, SIZE, sp_clusters=80, vpls=250, vpl_clusters=1000, far_field_sums=far_field_sums
    )


@pytest.fixture(scope="module")
def bright() -> Bright:
    return Bright(picture_of(far_field_sums=True), SIZE[0] * SIZE[1])


@pytest.mark.parametrize("far_field_sums", [False, True])
def test_the_mean_of_what_rays_find_is_the_light(far_field_sums: bool) -> None:
    bright = Bright(picture_of(far_field_sums=far_field_sums), SIZE[0] * SIZE[1])
    fuzzy = bright.fuzzy
    assert (fuzzy.view.indirect.unoccluded_far.numpy() > 0.0).any() == far_field_sums
    share = float(TRUST)
    rays = (fuzzy.unhidden().mean(axis=2) * (fuzzy.seen() - share * fuzzy.shares())).sum(axis=1)
    expected = np.zeros(fuzzy.view.pixels)
    expected[fuzzy.pixels] = share * fuzzy.irradiance()[fuzzy.pixels].mean(axis=1) + rays
    samples = []
    for seed in range(SEEDS):
        pixels = bright.trace(seed)
        samples.append(bright.found()[pixels].mean(axis=1))
    found = np.array(samples)
    assert len(pixels) > 50
    off, error = found.mean(axis=0) - expected[pixels], found.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    assert 0.6 < np.mean((off / error) ** 2) < (2.0 if far_field_sums else 1.5)
    whole = found.sum(axis=1).std(ddof=1) / np.sqrt(SEEDS)
    assert abs(off.sum()) < 4.0 * whole
    assert whole < 0.01 * expected[pixels].sum()


def test_steps_that_are_even_leave_less_noise_than_rays_at_random(bright: Bright) -> None:
    fuzzy = bright.fuzzy
    pixels = bright.trace()
    found = []
    for seed in range(SEEDS):
        bright.trace(seed)
        found.append(bright.found()[pixels].mean(axis=1))
    amount, wrong = fuzzy.unhidden().mean(axis=2), fuzzy.seen() - float(TRUST) * fuzzy.shares()
    random = ((amount.sum(axis=1) * (amount * wrong**2).sum(axis=1)) - (amount * wrong).sum(axis=1) ** 2) / RAYS
    rows = np.argsort(fuzzy.pixels)[np.searchsorted(np.sort(fuzzy.pixels), pixels)]
    assert np.var(found, axis=0, ddof=1).mean() < 0.8 * random[rows].mean()


def test_those_that_may_be_brightest_have_rays() -> None:
    bright = Bright(picture_of(far_field_sums=True), SIZE[0] * SIZE[1], 1.0)
    fuzzy, view = bright.fuzzy, bright.view
    reflected = wp.zeros(view.pixels, dtype=wp.vec3, device=view.device)
    wp.launch(reflectance_kernel, view.pixels, [view.gbuffer, reflected], device=view.device)
    count = fuzzy.sp_count
    most = (view.indirect.unoccluded_near.numpy() + view.indirect.unoccluded_far.numpy())[:count]
    most = most * reflected.numpy()[fuzzy.pixels].mean(axis=1)
    chosen = np.isin(fuzzy.pixels, bright.trace())
    least = float(LEAST_BRIGHT) * np.sort(bright.picture.samples.numpy())[int(SAMPLES) - 1 - BRIGHTER]
    assert np.array_equal(chosen, most >= least)
    assert 0.1 < chosen.mean() < 0.9
    few = Bright(fuzzy, 20)
    brightest = np.isin(fuzzy.pixels, few.trace())
    assert brightest.sum() == 20
    assert most[brightest].min() > 0.93 * most[~brightest].max()  # keys are steps of 2 ^ (1 / 16)


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
        share = RAYS / (RAYS + CHECKS * min(frames + 1, int(FRAMES)))
        mean = 1.0 + (found[pixels] - 1.0) * share
        assert light[pixels] == pytest.approx(mean, rel=1e-4, abs=1e-5)
        lacking = np.zeros_like(known)
        lacking[pixels] = mean - 1.0
        mixed = 1.0 + float(OWN) * lacking[pixels] + (1.0 - float(OWN)) * bright.shared(pixels, lacking, told)
        kept = mean.mean(axis=1) * float(DARKER) > 1.0
        assert not kept.all()
        assert shown[pixels][~kept] == pytest.approx(np.maximum(mixed, 0.0)[~kept], rel=1e-3, abs=1e-4)
        others = np.setdiff1d(np.arange(bright.view.pixels), pixels)
        assert (light[others] == 1.0).all()
        assert (shown[others] == 1.0).all()


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
    dark = np.full((bright.view.pixels, 3), 0.5 * float(DARKER) * found.max() * RAYS / (RAYS + CHECKS))
    light, shown = bright.take(told, np.zeros_like(dark), dark, 0)
    kept = dark[pixels].mean(axis=1) < float(DARKER) * light[pixels].mean(axis=1)
    assert kept.any()
    assert shown[pixels[kept]] == pytest.approx(dark[pixels[kept]])
    others, lacking = pixels[~kept], light - dark
    mixed = dark[others] + float(OWN) * lacking[others] + (1.0 - float(OWN)) * bright.shared(others, lacking, told)
    assert shown[others] == pytest.approx(np.maximum(mixed, 0.0), rel=1e-3, abs=1e-4)
