import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.carry import carry

CPU = wp.get_device("cpu")


def origins(count: int, before: int) -> np.ndarray:
    """Which cluster each of `count` comes from, −1 for none."""
    numbers = np.arange(count)
    return np.where(numbers < before, numbers, -1) if count >= before else numbers * before // count


@pytest.mark.parametrize(("count", "before"), [(70, 70), (75, 70), (66, 70), (1, 70), (70, 1)])
@pytest.mark.parametrize("shape", [(), (3,), (64,)])
def test_clusters_keep_what_they_know_or_begin_with_nothing(count: int, before: int, shape: tuple[int, ...]) -> None:
    known = np.random.default_rng(1).normal(size=(before, *shape)).astype(np.float32)
    target = column(np.full((count, *shape), 7.0, np.float32), float)
    carry(column(known, float), target)
    origin = origins(count, before)
    wanted = np.where((origin < 0).reshape(-1, *(1 for _ in shape)), np.float32(0.0), known[origin])
    assert np.array_equal(target.numpy(), wanted)


def test_vectors_are_carried_whole() -> None:
    known = np.random.default_rng(2).normal(size=(9, 3)).astype(np.float32)
    target = wp.zeros(6, dtype=wp.vec3, device=CPU)
    carry(column(known, wp.vec3), target)
    assert np.array_equal(target.numpy(), known[origins(6, 9)])


def test_clusters_may_be_columns() -> None:
    known = np.random.default_rng(3).normal(size=(5, 9)).astype(np.float32)
    target = wp.zeros((5, 12), dtype=float, device=CPU)
    carry(column(known, float), target, axis=1)
    assert np.array_equal(target.numpy()[:, :9], known)
    assert not target.numpy()[:, 9:].any()


@pytest.mark.parametrize("count", [30, 31, 1 << 20])
def test_as_many_stay_as_there_is_room_for_and_each_once(count: int) -> None:
    known = column(np.arange(1, 1_200_001), wp.int32)
    target = wp.zeros(count, dtype=int, device=CPU)
    carry(known, target)
    kept = target.numpy()
    assert (np.diff(kept) > 0).all()
    assert kept[0] == 1
