import numpy as np
import pytest
from scenes import box, grey, quad, resident_of

from gpu.camera import look_at
from gpu.metrics import mse
from gpu.probes import Probes, clipped_product, white_of
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
    truth = random.uniform(0.1, 0.8, (4000, 3))
    render = truth + 0.05
    one, other = (truth + 0.1 * random.standard_normal(truth.shape) for _ in range(2))
    assert clipped_product(render, one, other, 2.0) == pytest.approx((0.05 / 2.0) ** 2, rel=0.1)
    assert clipped_product(render, truth, truth, 2.0) == pytest.approx((0.05 / 2.0) ** 2)
    assert clipped_product(truth + 9.0, truth + 9.0, truth + 8.0, 1.0) == 0.0
    assert clipped_product(0.0 * truth, 0.0 * truth, 0.0 * truth, 0.0) == 0.0


@pytest.mark.parametrize("dimmed", [0.8, 1.0, 1.25])
def test_white_is_that_of_the_truth_whatever_noise_it_has_and_however_dim_the_render_is(dimmed: float) -> None:
    random = np.random.default_rng(5)
    truth = random.exponential(size=(20_000, 3))
    noisy = truth * random.exponential(size=truth.shape)
    assert white_of(dimmed * truth, noisy) == pytest.approx(np.percentile(truth, 99.0), rel=0.06)
    assert np.percentile(noisy, 99.0) > 1.3 * np.percentile(truth, 99.0)
    assert white_of(0.0 * truth, noisy) == 0.0


@pytest.mark.parametrize("smooth", [True, False])
def test_the_estimate_is_the_error_against_exact_vpl(
    room: ResidentScene, monkeypatch: pytest.MonkeyPatch, smooth: bool
) -> None:
    estimates: list[float] = []
    error = Probes.error

    def heard(probes: Probes) -> float:
        estimates.append(error(probes))
        return 1e-3  # as wanted: the counts stay

    monkeypatch.setattr(Probes, "error", heard)
    renderer = Renderer(room, SIZE, RenderSettings(**CHOICE, target_error=1e-3, smooth=smooth))
    frames = [renderer.render(CAMERA) for _ in range(60)]
    counts = [(frame.stats.counts["sp_clusters"], frame.stats.counts["vpl_clusters"]) for frame in frames]
    assert len(set(counts)) == 1
    exact = RenderSettings(**CHOICE, method=Method.EXACT_VPL, vpl_clusters=counts[0][1])
    true = mse(frames[-1].radiance(), Renderer(room, SIZE, exact).render(CAMERA).radiance())
    assert np.mean(estimates) == pytest.approx(true, rel=0.25)
    assert len(set(estimates)) == len(estimates), "each frame has other probes"
