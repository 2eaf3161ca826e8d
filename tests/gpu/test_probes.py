import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.camera import look_at
from gpu.error_model import Estimate
from gpu.metrics import mse
from gpu.probes import Probes, clipped_products, white_of
from gpu.renderer import Renderer
from gpu.resident import ResidentScene
from gpu.settings import Component, Method, RenderSettings

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
# Before near-field light, which is no matter of clusters and not in the estimate.
CHOICE = {"component": Component.INDIRECT, "near_field": False, "vpls": 2000, "skip": {"unchanged_camera": False}}


@pytest.fixture(scope="module")
def room() -> ResidentScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)])


def test_products_of_independent_estimates_do_not_count_their_noise() -> None:
    random = np.random.default_rng(3)
    truth = random.uniform(0.1, 0.8, (3, 4000))
    render = truth + 0.05
    one, other = (truth + 0.1 * random.standard_normal(truth.shape) for _ in range(2))
    noisy = clipped_products(render, one, other, 2.0)
    assert noisy.mean() == pytest.approx((0.05 / 2.0) ** 2, rel=0.1)
    assert clipped_products(render, truth, truth, 2.0) == pytest.approx(np.full(4000, (0.05 / 2.0) ** 2))
    assert not clipped_products(truth + 9.0, truth + 9.0, truth + 8.0, 1.0).any()
    assert not clipped_products(0.0 * truth, 0.0 * truth, 0.0 * truth, 0.0).any()


@pytest.mark.parametrize("dimmed", [0.8, 1.0, 1.25])
def test_white_is_that_of_the_truth_whatever_noise_it_has_and_however_dim_the_render_is(dimmed: float) -> None:
    """Bright probes are drawn more often, and so count for less."""
    random = np.random.default_rng(5)
    even = random.exponential(size=(3, 20_000))
    bright = even.mean(axis=0)
    drawn = random.choice(len(bright), len(bright), p=bright / bright.sum())
    counts, truth = bright.mean() / bright[drawn], even[:, drawn]
    noisy = truth * random.exponential(size=truth.shape)
    white = white_of(dimmed * even, dimmed * truth, noisy, counts)
    assert white == pytest.approx(np.percentile(even, 99.0), rel=0.06)
    assert np.percentile(noisy, 99.0) > 1.3 * np.percentile(even, 99.0)
    assert white_of(0.0 * even, 0.0 * truth, noisy, counts) == 0.0


@pytest.mark.parametrize("smooth", [True, False])
def test_the_estimate_is_the_error_against_exact_vpl(
    room: ResidentScene, monkeypatch: pytest.MonkeyPatch, smooth: bool
) -> None:
    estimates: list[Estimate] = []
    estimate = Probes.estimate

    def heard(probes: Probes) -> Estimate:
        estimates.append(estimate(probes))
        return Estimate(1e-3, 1e-6)  # as wanted: the counts stay

    monkeypatch.setattr(Probes, "estimate", heard)
    renderer = Renderer(room, SIZE, RenderSettings(**CHOICE, target_error=1e-3, smooth=smooth))
    frames = [renderer.render(CAMERA) for _ in range(60)]
    counts = [(frame.stats.counts["sp_clusters"], frame.stats.counts["vpl_clusters"]) for frame in frames]
    assert len(set(counts)) == 1
    exact = RenderSettings(**CHOICE, method=Method.EXACT_VPL, vpl_clusters=counts[0][1])
    true = mse(frames[-1].radiance(), Renderer(room, SIZE, exact).render(CAMERA).radiance())
    errors = np.array([estimate.error for estimate in estimates])
    assert errors.mean() == pytest.approx(true, rel=0.05)
    assert len(set(errors)) == len(errors), "each frame has other probes"
    told = np.mean([estimate.deviation for estimate in estimates])
    assert 0.5 * told < errors.std() < 1.5 * told
