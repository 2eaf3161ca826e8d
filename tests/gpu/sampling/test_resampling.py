import numpy as np
import pytest
import warp as wp

from gpu.sampling.resampling import candidate_at

Weights = wp.types.vector(length=4, dtype=float)


@wp.kernel
def choose_kernel(weights: Weights, places: wp.array[float], chosen: wp.array[int]) -> None:
    chosen[wp.tid()] = candidate_at(weights, places[wp.tid()])


@pytest.mark.parametrize(
    ("weights", "expected"),
    [
        ((1.0, 2.0, 0.0, 1.0), {0.0: 0, 0.9: 0, 1.1: 1, 2.9: 1, 3.1: 3, 4.0: 3, 4.1: 3}),
        ((0.0, 1.0, 0.5, 0.0), {0.0: 1, 0.9: 1, 1.1: 2, 1.6: 2}),
    ],
)
def test_candidates_are_chosen_by_their_weights_and_never_without_one(
    weights: tuple[float, ...], expected: dict[float, int]
) -> None:
    places = wp.array(np.array(list(expected), np.float32), device="cpu")
    chosen = wp.zeros(len(expected), dtype=int, device="cpu")
    wp.launch(choose_kernel, len(expected), inputs=[Weights(*weights), places, chosen], device="cpu")
    assert chosen.numpy().tolist() == list(expected.values())
