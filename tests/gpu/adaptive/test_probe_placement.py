import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.adaptive.probe_placement import ProbePlaces

CPU = wp.get_device("cpu")
# Sides that are no multiples of a tile's.
SIZE = WIDTH, HEIGHT = 101, 70
PROBES = 2048


def errors_at(pixels: np.ndarray) -> np.ndarray:
    """Errors that are large in a corner of the image, and nothing in a third of it."""
    x, y = pixels % WIDTH, pixels // WIDTH
    return np.where(x < 30, 0.0, 0.01) + np.where((x > 80) & (y > 50), 1.0, 0.0) * (1.0 + x % 2)


ALL = errors_at(np.arange(WIDTH * HEIGHT))


def drawn(frames: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Pixels and counts of probes in so many frames."""
    places, frame, seen = ProbePlaces(SIZE, PROBES, CPU), wp.zeros(1, dtype=int, device=CPU), []
    for number in range(frames):
        frame.fill_(number)
        places.draw(frame)
        pixels, counts = places.points.pixels.numpy().copy(), places.counts.numpy().copy()
        seen.append((pixels, counts))
        places.learn(column(errors_at(pixels), float))
    return seen


def test_what_probes_count_is_right_in_the_mean_for_every_part_of_the_image() -> None:
    seen = drawn(400)
    pixels, counts = (np.concatenate(values) for values in zip(*seen, strict=True))
    assert pixels.min() >= 0
    assert pixels.max() < WIDTH * HEIGHT
    share = np.bincount(pixels, weights=counts, minlength=WIDTH * HEIGHT) / counts.size * (WIDTH * HEIGHT)
    blocks = share.reshape(HEIGHT, WIDTH)[:, :100].reshape(7, 10, 10, 10).mean(axis=(1, 3))
    assert blocks == pytest.approx(np.ones(blocks.shape), abs=0.08)
    estimates = [float(np.mean(weights * errors_at(places))) for places, weights in seen]
    assert np.mean(estimates) == pytest.approx(ALL.mean(), rel=0.01)
    assert len(set(estimates)) > 300, "each frame has other probes"


def test_probes_go_to_where_errors_were_so_that_estimates_have_less_noise() -> None:
    seen = drawn(200)
    estimates = np.array([np.mean(counts * errors_at(pixels)) for pixels, counts in seen[10:]])
    even = ALL.std() / np.sqrt(PROBES)
    assert estimates.std() < 0.5 * even
    first = np.bincount(seen[0][0] % WIDTH > 80, minlength=2)[1]
    last = np.bincount(seen[-1][0] % WIDTH > 80, minlength=2)[1]
    assert last > 2 * first
    nothing = seen[-1][0] % WIDTH < 16
    assert nothing.any(), "errors that are new must be found, too"


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_probes_that_tell_nothing_leave_places_as_they_are(value: float) -> None:
    places, frame = ProbePlaces(SIZE, PROBES, CPU), wp.zeros(1, dtype=int, device=CPU)
    places.draw(frame)
    before = places.points.pixels.numpy().copy()
    places.learn(wp.full(PROBES, value, dtype=float, device=CPU))
    places.draw(frame)
    assert np.array_equal(places.points.pixels.numpy(), before)
    assert places.counts.numpy() == pytest.approx(np.ones(PROBES), rel=1e-3)
    places.learn(column(errors_at(before), float))
    places.draw(frame)
    assert places.counts.numpy().min() < 0.5


def test_one_probe_and_an_image_smaller_than_a_tile_will_do() -> None:
    places, frame = ProbePlaces((3, 2), 1, CPU), wp.zeros(1, dtype=int, device=CPU)
    seen = set()
    for number in range(100):
        frame.fill_(number)
        places.draw(frame)
        seen.add(int(places.points.pixels.numpy()[0]))
        places.learn(column([0.5], float))
        assert places.counts.numpy()[0] == pytest.approx(1.0)
    assert seen == set(range(6))


def test_some_probes_are_drawn_evenly_and_old_errors_fade() -> None:
    """All errors are in the left quarter of an image, for 20 frames, and then in its right quarter."""
    places, frame, left = ProbePlaces((128, 64), PROBES, CPU), wp.zeros(1, dtype=int, device=CPU), []
    for number in range(25):
        frame.fill_(number)
        places.draw(frame)
        x = places.points.pixels.numpy() % 128
        left.append(float(np.mean(x < 32)))
        places.learn(column(np.where(x < 32 if number < 20 else x >= 96, 1.0, 0.0), float))
    assert 0.78 < left[20] < 0.87
    assert 0.25 < left[24] < 0.4
