from collections.abc import Callable

import numpy as np
import pytest
import warp as wp
from numpy.typing import NDArray
from walls import CPU, HEIGHT, LEFT, WIDTH, grey_values, numbers, split_walls, wall

from gpu.core.image_size import image_size
from gpu.denoise.atrous import ATROUS_PARAMETERS, LightGuide, Smoothing, atrous_pixels_kernel, atrous_points_kernel
from gpu.denoise.sparse_image import sparse_image
from gpu.gbuffer.gbuffer import GBuffer
from gpu.gbuffer.shading_points import ShadingPoints

SPLITS = ["normals", "depth", "nothing"]


def smoothed(gbuffer: GBuffer, light: NDArray, frames: int = 1) -> NDArray:
    """`light` (height, width), the mean of so many `frames`, after smoothing."""
    values = grey_values(light)
    known = wp.full(WIDTH * HEIGHT, frames, dtype=int, device=CPU)
    Smoothing((WIDTH, HEIGHT), CPU).run(gbuffer, values, known)
    return numbers(values)


def shared(
    gbuffer: GBuffer,
    light: NDArray,
    guide: NDArray,
    stride: int = 1,
    frames: NDArray | int = 0,
    nearer_on_detail: bool = False,
) -> tuple[NDArray, NDArray]:
    """`light` (height, width) of so many `frames` shared between SPs by a `guide`, and which pixels have SPs."""
    sps = ShadingPoints((WIDTH, HEIGHT), stride, CPU)
    sps.find(gbuffer)
    chosen = np.zeros(WIDTH * HEIGHT, bool)
    chosen[sps.pixels.numpy()[: sps.count.numpy()[0]]] = True
    values = grey_values(light)
    known = wp.array(np.broadcast_to(frames, (HEIGHT, WIDTH)).ravel(), dtype=int, device=CPU)
    result = Smoothing((WIDTH, HEIGHT), CPU).share(
        gbuffer, sps, grey_values(guide), values, known, nearer_on_detail=nearer_on_detail
    )
    assert np.array_equal(numbers(values), light.astype(np.float32))  # other stages still need it
    return numbers(result), chosen.reshape(HEIGHT, WIDTH)


def noise(seed: int = 0) -> NDArray:
    """What one shadow ray a pixel gives in a penumbra."""
    return np.random.default_rng(seed).integers(0, 2, (HEIGHT, WIDTH)).astype(float)


def rare(seed: int = 0) -> NDArray:
    """What a ray a pixel finds of what few rays find: now and then far too much, of mean 1."""
    return np.where(np.random.default_rng(seed).uniform(size=(HEIGHT, WIDTH)) < 0.05, 20.0, 0.0)


def test_even_light_stays_as_it_is() -> None:
    assert smoothed(wall(), np.full((HEIGHT, WIDTH), 0.3)) == pytest.approx(0.3, rel=1e-6)


def test_noise_falls_and_its_mean_stays() -> None:
    light = noise()
    result = smoothed(wall(), light)
    assert result.var() < light.var() / 10.0
    assert result.mean() == pytest.approx(light.mean(), abs=0.02)


@pytest.mark.parametrize("frames", [1, 8])
def test_of_rays_that_seldom_find_much_little_is_lost(frames: int) -> None:
    light = np.random.default_rng(0).exponential(size=(HEIGHT, WIDTH)) ** 2
    result = smoothed(wall(), light, frames)
    assert result.mean() == pytest.approx(light.mean(), rel=0.05)
    assert result.var() < light.var() / 30.0


def test_light_spreads_over_a_surface_however_much_it_differs() -> None:
    """Between SPs alone, whose strides skip some pixels, and not beyond a surface."""
    light = np.where(LEFT, 0.0, 7.0)
    light[20, 12] = 1e6
    sps = ShadingPoints((WIDTH, HEIGHT), 2, CPU)
    sps.find(split_walls()["depth"])
    listed = sps.listed.numpy().reshape(HEIGHT, WIDTH) == 1
    values = grey_values(np.where(listed, light, 0.0))
    result = numbers(Smoothing((WIDTH, HEIGHT), CPU).spread(split_walls()["depth"], sps, values))
    assert np.all(result[~listed] == 0.0)
    assert np.allclose(result[listed & ~LEFT], 7.0)
    assert result[LEFT].max() < 0.07e6
    assert result[LEFT].sum() == pytest.approx(1e6, rel=1e-5)
    assert np.count_nonzero(result[LEFT]) > 40


def test_a_sharp_shadow_without_noise_stays_sharp() -> None:
    light = np.zeros((HEIGHT, WIDTH))
    light[:, WIDTH // 2 :] = 1.0
    result = smoothed(wall(), light)
    # Only the two columns at the edge see both sides around them; they keep what they had together.
    assert np.allclose(np.delete(result, [23, 24], axis=1), np.delete(light, [23, 24], axis=1), atol=0.02)
    assert result[:, 23] + result[:, 24] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("kind", SPLITS)
def test_nothing_crosses_the_edges_of_surfaces(kind: str) -> None:
    one, other = (smoothed(split_walls()[kind], np.where(LEFT, noise(), much + noise(1))) for much in (100.0, 7.0))
    assert np.array_equal(one[LEFT], other[LEFT])
    assert one[LEFT].max() < 1.1
    assert one[~LEFT].min() > 99.9


def test_pixels_without_a_surface_keep_their_light() -> None:
    light = noise()
    assert np.array_equal(smoothed(wall(seen=np.zeros((HEIGHT, WIDTH), bool)), light), light)


@pytest.mark.parametrize("stride", [1, 2])
def test_rare_light_is_spread_evenly_over_a_plane_and_keeps_its_mean(stride: int) -> None:
    before, after = [], []
    for seed in range(20):
        light = rare(seed)
        result, sps = shared(wall(), light, np.ones((HEIGHT, WIDTH)), stride)
        anchors = light[::stride, ::stride]
        # Every SP takes from the anchors around it, which so all count the same but near the image's edges.
        before.append(anchors.mean())
        after.append(result[sps].mean())
        assert result[sps].var() < anchors.var() / 20.0
    assert np.mean(after) == pytest.approx(np.mean(before), rel=0.03)


def test_light_of_many_frames_is_shared_less_far() -> None:
    few, many = (shared(wall(), rare(), np.ones((HEIGHT, WIDTH)), frames=frames)[0] for frames in (4, 5))
    assert 2.0 * few.var() < many.var() < rare().var() / 15.0
    spot = np.zeros((HEIGHT, WIDTH))
    spot[12, 20] = 1.0
    reach = [np.nonzero(shared(wall(), spot, np.ones((HEIGHT, WIDTH)), frames=frames)[0])[1] for frames in (4, 5)]
    assert [columns.max() - columns.min() for columns in reach] == [16, 8]


@pytest.mark.parametrize(("frames", "steps"), [(0, 7), (1, 3), (3, 3), (4, 1)])
def test_light_of_some_frames_is_shared_nearer_where_a_surface_is_uneven(frames: int, steps: int) -> None:
    uneven, edge, taken = split_walls()["depth"], WIDTH // 2, []
    for column in range(edge, WIDTH, 2):
        light = np.zeros((HEIGHT, WIDTH))
        light[12, column] = 1.0
        result, sps = shared(uneven, light, np.ones((HEIGHT, WIDTH)), 2, frames, nearer_on_detail=True)
        assert sps[12, edge - 1 : edge + 2].tolist() == [True, True, False]
        taken.append(result[12, edge] > 0.0)
    assert taken == [place <= steps for place in range(len(taken))]


def test_what_few_frames_know_counts_less_beside_what_many_do() -> None:
    known = np.where(LEFT, 3, 0)
    result, _ = shared(wall(), 1.0 * LEFT, np.ones((HEIGHT, WIDTH)), frames=known)
    alike, _ = shared(wall(), 1.0 * LEFT, np.ones((HEIGHT, WIDTH)), frames=3)
    edge = WIDTH // 2
    assert (1.0 - result[:, edge - 1] < 0.5 * (1.0 - alike[:, edge - 1])).all()
    assert np.allclose(result[:, edge], shared(wall(), 1.0 * LEFT, np.ones((HEIGHT, WIDTH)))[0][:, edge], rtol=0.2)


def test_only_sps_share_their_light() -> None:
    _, sps = shared(wall(), rare(), np.ones((HEIGHT, WIDTH)), 2)
    result, _ = shared(wall(), np.where(sps, 0.0, rare()), np.ones((HEIGHT, WIDTH)), 2)
    assert 0.2 < sps.mean() < 0.5
    assert (result[sps] == 0.0).all()


def test_sps_between_anchors_of_other_surfaces_share_with_those_beside_them() -> None:
    # Every second column lies far behind, and has no anchors.
    deep = (np.arange(WIDTH)[None] + np.zeros((HEIGHT, 1), int)) % 2 == 1
    stripes = wall(depth=np.where(deep, 50.0, 0.0))
    light = np.stack([np.where(deep, rare(seed), 0.0) for seed in range(20)])
    results = [shared(stripes, one, np.ones((HEIGHT, WIDTH)), 2) for one in light]
    assert all(sps[deep].all() for _, sps in results)
    after = np.stack([result[deep] for result, _ in results])
    assert after.mean() == pytest.approx(light[:, deep].mean(), rel=0.03)
    # Three of a column, by 1/4, 1/2 and 1/4.
    assert after.var() == pytest.approx(0.375 * light[:, deep].var(), rel=0.1)


@pytest.mark.parametrize("stride", [1, 2])
@pytest.mark.parametrize("kind", SPLITS)
def test_no_light_is_shared_across_the_edges_of_surfaces(kind: str, stride: int) -> None:
    light = np.where(LEFT, rare(), 1000.0 + rare(1))
    result, sps = shared(split_walls()[kind], light, np.ones((HEIGHT, WIDTH)), stride)
    assert result[LEFT & sps].max() <= 20.0
    if kind != "nothing":
        assert result[~LEFT & sps].min() >= 1000.0


def test_less_is_shared_where_the_guide_has_other_light() -> None:
    light, alike = np.where(LEFT, 0.0, 1.0), np.ones((HEIGHT, WIDTH))
    leaked = [shared(wall(), light, guide)[0][LEFT].sum() for guide in (alike, np.where(LEFT, 1.0, 50.0))]
    assert leaked[0] > 10.0
    assert leaked[1] < 1e-3 * leaked[0]


def test_what_is_black_in_the_guide_shares_with_its_like() -> None:
    result, _ = shared(wall(), rare(), np.zeros((HEIGHT, WIDTH)))
    assert result.var() < rare().var() / 20.0


def mixed(light: NDArray, step: int, weight: Callable[[tuple[slice, slice], tuple[slice, slice]], NDArray]) -> NDArray:
    """`light` mixed with that of the eight pixels `step` away; weight: of the pixels there in those here."""
    total, result = np.full((HEIGHT, WIDTH), 4.0), 4.0 * light
    for dy, dx in np.ndindex(3, 3):
        away = (dy - 1) * step, (dx - 1) * step
        if any(away):
            pairs = [(slice(max(-by, 0), end - max(by, 0)), by) for by, end in zip(away, light.shape, strict=True)]
            here = pairs[0][0], pairs[1][0]
            there = tuple(slice(run.start + by, run.stop + by) for run, by in pairs)
            weights = (2 - abs(dx - 1)) * (2 - abs(dy - 1)) * weight(here, there)
            total[here] += weights
            result[here] += weights * light[there]
    return np.asarray(result / total)


@pytest.mark.parametrize("step", [1, 2])
def test_neighbours_count_by_plane_guide_and_frames(step: int) -> None:
    random = np.random.default_rng(4)
    light, guide = random.uniform(0.5, 1.5, (2, HEIGHT, WIDTH))
    depth, frames = random.uniform(-1.0, 1.0, (HEIGHT, WIDTH)), random.integers(0, 8, (HEIGHT, WIDTH))

    def weight(here: tuple[slice, slice], there: tuple[slice, slice]) -> NDArray:
        plane = np.exp(-(((depth[there] - depth[here]) / step) ** 2))
        alike = np.exp(-np.abs(guide[there] - guide[here]) / guide[here])
        return np.asarray(plane * alike * np.minimum((frames[there] + 1) / (frames[here] + 1), 1.0))

    sps, guides, out = ShadingPoints((WIDTH, HEIGHT), 1, CPU), LightGuide(), grey_values(light)
    gbuffer = wall(depth=depth)
    sps.find(gbuffer)
    guides.light, guides.frames = grey_values(guide), wp.array(frames.ravel(), dtype=int, device=CPU)
    inputs = [0, gbuffer, sps.points, sparse_image((WIDTH, HEIGHT), sps), step, guides, ATROUS_PARAMETERS]
    wp.launch(atrous_points_kernel, WIDTH * HEIGHT, [*inputs, grey_values(light), out], device=CPU)
    assert numbers(out) == pytest.approx(mixed(light, step, weight), rel=1e-5)


@pytest.mark.parametrize("step", [1, 2])
def test_neighbours_count_by_plane_and_deviation(step: int) -> None:
    random = np.random.default_rng(5)
    light, deviation = random.uniform(0.5, 1.5, (2, HEIGHT, WIDTH))
    depth = random.uniform(-1.0, 1.0, (HEIGHT, WIDTH))

    def weight(here: tuple[slice, slice], there: tuple[slice, slice]) -> NDArray:
        plane = np.exp(-(((depth[there] - depth[here]) / step) ** 2))
        return np.asarray(plane * np.exp(-np.abs(light[there] - light[here]) / (3.0 * deviation[here])))

    out = grey_values(light)
    inputs = [0, wall(depth=depth), image_size((WIDTH, HEIGHT)), step, ATROUS_PARAMETERS, grey_values(light)]
    noise = wp.array(deviation.ravel().astype(np.float32), device=CPU)
    wp.launch(atrous_pixels_kernel, WIDTH * HEIGHT, [*inputs, noise, out], device=CPU)
    assert numbers(out) == pytest.approx(mixed(light, step, weight), rel=1e-5)
