import numpy as np
import pytest
from numpy.typing import NDArray

from gpu.errors import ImageError
from gpu.film.metrics import energy, hdr_flip, measure, mse, nonfinite_count, rel_mse


def image(*values: float) -> NDArray[np.float64]:
    """One row of grey pixels."""
    return np.repeat(np.array(values, np.float64)[None, :, None], 3, axis=2)


def test_mse_by_hand() -> None:
    # All but one of 200 values are 2, so w = 2: errors 0.5² at one pixel, 0 where both are clipped at white.
    reference = image(*[2.0] * 199, 50.0)
    render = image(1.0, *[2.0] * 198, 9.0)
    assert mse(render, reference) == pytest.approx(0.25 / 200)


def test_mse_clips_negative_values() -> None:
    assert mse(image(-3.0, 1.0), image(0.0, 1.0)) == pytest.approx(0.0)


def test_mse_white_is_the_99th_percentile() -> None:
    reference = image(*np.arange(101.0))
    render = reference.copy()
    render[0, 50] += 9.9
    assert mse(render, reference) == pytest.approx(0.1**2 / 101)


def test_rel_mse_by_hand() -> None:
    # mean(r) = 2: (1 − 0)² / (0 + 0.04) = 25 and (5 − 4)² / (16 + 0.04).
    assert rel_mse(image(1.0, 5.0), image(0.0, 4.0)) == pytest.approx((25.0 + 1.0 / 16.04) / 2.0)


def test_energy_is_render_over_reference() -> None:
    assert energy(image(1.0, 2.0), image(2.0, 4.0)) == pytest.approx(0.5)


def test_flip_orders_errors_and_ignores_a_common_scale() -> None:
    reference = np.random.default_rng(1).random((24, 32, 3)) ** 2
    small, large = hdr_flip(reference * 1.05, reference), hdr_flip(reference * 2.0, reference)
    assert hdr_flip(reference, reference) == 0.0
    assert 0.0 < small < large < 1.0
    # Darker than the evaluator's floor, where it would end the process.
    assert hdr_flip(reference * 2e-9, reference * 1e-9) == pytest.approx(large, abs=1e-3)


def test_flip_accepts_negative_noise_and_bright_fireflies() -> None:
    reference = np.random.default_rng(2).random((16, 16, 3))
    render = reference.copy()
    render[0, 0], render[3, 3] = -1.0, 1e39
    assert 0.0 < hdr_flip(render, reference) < 1.0


def test_measure_is_all_definitions_at_once() -> None:
    reference = np.random.default_rng(3).random((16, 16, 3)).astype(np.float16)
    render = reference.astype(np.float32) * np.float32(1.5)
    errors = measure(render, reference)
    assert errors.nonfinite == 0
    assert errors.mse == mse(render, reference)
    assert errors.rel_mse == rel_mse(render, reference)
    assert errors.flip == hdr_flip(render, reference)
    assert errors.energy == pytest.approx(1.5)


def test_one_nonfinite_value_fails_every_threshold() -> None:
    render = image(np.nan, np.inf, 1.0)
    render[0, 0, 1:] = 1.0
    assert nonfinite_count(render) == 4
    errors = measure(render, image(1.0, 1.0, 1.0))
    assert errors.nonfinite == 4
    assert not any(value <= 1e9 for value in (errors.mse, errors.rel_mse, errors.flip, errors.energy))


@pytest.mark.parametrize(
    ("render", "reference", "word"),
    [
        (image(1.0), image(1.0, 2.0), "size"),
        (np.ones((2, 2)), np.ones((2, 2)), "RGB"),
        (image(1.0), image(np.inf), "reference"),
        (image(np.nan), image(1.0), "render"),
        (image(1.0), image(0.0), "no light"),
        (image(*[1.0] * 201), image(*[0.0] * 200, 1.0), "black"),
    ],
)
def test_what_cannot_be_compared_is_said(
    render: NDArray[np.float64], reference: NDArray[np.float64], word: str
) -> None:
    with pytest.raises(ImageError, match=word):
        mse(render, reference)


@pytest.mark.parametrize("reference", [image(np.inf, 1.0), image(0.0, 0.0), image(1.0)])
def test_measure_refuses_a_bad_reference_even_for_a_nonfinite_render(reference: NDArray[np.float64]) -> None:
    with pytest.raises(ImageError):
        measure(image(np.nan, 1.0), reference)
