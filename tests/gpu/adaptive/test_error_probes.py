import numpy as np
import pytest
import warp as wp
from devices import DEVICES
from scenes import box, column, grey, quad, resident_of

from gpu.adaptive.error_model import Estimate
from gpu.adaptive.error_probes import Probes, probe_error_kernel
from gpu.adaptive.probe_white_point import ProbeRadiance
from gpu.core.device import launch
from gpu.device_scene.upload import DeviceScene
from gpu.film.metrics import mse
from gpu.renderer import Renderer
from gpu.scene.camera import look_at
from gpu.settings import Component, Method, RenderSettings

SIZE = (48, 36)
CAMERA = look_at((0.0, 0.0, 0.45), (0.0, -0.1, -0.5), yfov_degrees=75.0)
# Before near-field light, which is no matter of clusters and not in the estimate.
CHOICE = {"component": Component.INDIRECT, "near_field": False, "vpls": 400, "skip": {"unchanged_camera": False}}


def room_on(device: str) -> DeviceScene:
    """A closed box with a lamp below its ceiling and a block on its floor."""
    lamp = quad((-0.2, 0.49, -0.2), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4), 1)
    block = quad((-0.3, -0.2, -0.3), (0.0, 0.0, 0.3), (0.3, 0.0, 0.0), 2)
    return resident_of([*box(), lamp, block], [grey(0.7), grey(0.0, 5.0), grey(0.4)], device=device)


def products(render: np.ndarray, one: np.ndarray, other: np.ndarray, white: float) -> np.ndarray:
    """Squared errors (probe,) by values (probe, 3)."""
    radiance = ProbeRadiance()
    radiance.render, radiance.one, radiance.other = (column(array, wp.vec3) for array in (render, one, other))
    counts, found, errors = (wp.zeros(len(render), dtype=kind, device="cpu") for kind in (float, float, wp.vec2))
    whole = column([[1.0, 1.0]], wp.vec2)
    inputs = [column([0.0, white], float), whole, counts, radiance, found, errors]
    launch(probe_error_kernel, len(render), inputs, wp.get_device("cpu"))
    return np.array(found.numpy())


def test_products_of_independent_estimates_do_not_count_their_noise() -> None:
    random = np.random.default_rng(3)
    truth = random.uniform(0.1, 0.8, (4000, 3))
    render = truth + 0.05
    one, other = (truth + 0.1 * random.standard_normal(truth.shape) for _ in range(2))
    assert products(render, one, other, 2.0).mean() == pytest.approx((0.05 / 2.0) ** 2, rel=0.1)
    assert products(render, truth, truth, 2.0) == pytest.approx(np.full(4000, (0.05 / 2.0) ** 2), rel=1e-4)
    assert not products(truth + 9.0, truth + 9.0, truth + 8.0, 1.0).any()
    assert not products(0.0 * truth, truth, truth, 0.0).any()


@pytest.mark.parametrize("white", [np.nan, np.inf])
def test_an_error_relative_to_no_number_is_none(white: float) -> None:
    one = np.ones((9, 3))
    assert not np.isfinite(products(one, one, one, white)).any()


@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("smooth", [True, False])
def test_the_estimate_is_the_error_against_exact_vpl(monkeypatch: pytest.MonkeyPatch, smooth: bool, name: str) -> None:
    room = room_on(name)
    estimates: list[Estimate] = []
    estimate = Probes.estimate

    def heard(probes: Probes) -> Estimate:
        estimates.append(estimate(probes))
        return Estimate(1e-3, 1e-6)  # as wanted: the counts stay

    monkeypatch.setattr(Probes, "estimate", heard)
    renderer = Renderer(room, SIZE, RenderSettings(**CHOICE, target_error=1e-3, smooth=smooth))
    frames = [renderer.render(CAMERA) for _ in range(16)]
    counts = [(frame.stats.counts["sp_clusters"], frame.stats.counts["vpl_clusters"]) for frame in frames]
    assert len(set(counts)) == 1
    exact = RenderSettings(**CHOICE, method=Method.EXACT_VPL, vpl_clusters=counts[0][1])
    true = mse(frames[-1].radiance(), Renderer(room, SIZE, exact).render(CAMERA).radiance())
    errors = np.array([estimate.error for estimate in estimates])
    assert errors.mean() == pytest.approx(true, rel=0.05)
    assert len(set(errors)) == len(errors), "each frame has other probes"
    told = np.mean([estimate.deviation for estimate in estimates])
    assert 0.5 * told < errors.std() < 1.5 * told
