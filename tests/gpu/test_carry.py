import numpy as np
import pytest
import warp as wp
from scenes import column

from gpu.carry import Carrying, Table

CPU = wp.get_device("cpu")


def carry(source: wp.array, target: wp.array, *, axis: int = 0) -> None:
    Carrying([Table(source, axis)], [Table(target, axis)], CPU).run()


def origins(count: int, before: int) -> np.ndarray:
    """Which cluster each of `count` comes from, −1 for none."""
    numbers = np.arange(count)
    return np.where(numbers < before, numbers, -1) if count >= before else numbers * before // count


@pytest.mark.parametrize(("count", "before"), [(70, 70), (75, 70), (66, 70), (1, 70), (70, 1)])
@pytest.mark.parametrize("shape", [(), (3,), (33,), (64,)])
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


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("count", "before"), [(75, 70), (70, 75), (64, 2), (400, 300)])
def test_what_nobody_reads_of_free_clusters_is_left(count: int, before: int, axis: int) -> None:
    shape = [33, 33]
    shape[axis] = before
    known = np.random.default_rng(5).normal(size=shape).astype(np.float32)
    shape[axis] = count
    target = column(np.full(shape, 7.0, np.float32), float)
    Carrying([Table(column(known, float), axis)], [Table(target, axis, clears=False)], CPU).run()
    origin = origins(count, before)
    wanted = np.take(known, origin, axis)
    wanted[(slice(None),) * axis + (origin < 0,)] = 7.0
    assert np.array_equal(target.numpy(), wanted)


@pytest.mark.parametrize("count", [30, 31, 1 << 20])
def test_as_many_stay_as_there_is_room_for_and_each_once(count: int) -> None:
    known = column(np.arange(1, 1_200_001), wp.int32)
    target = wp.zeros(count, dtype=int, device=CPU)
    carry(known, target)
    kept = target.numpy()
    assert (np.diff(kept) > 0).all()
    assert kept[0] == 1


def test_tables_of_all_kinds_are_filled_at_once() -> None:
    draw = np.random.default_rng(4)
    normals, single = draw.normal(size=(9, 3)).astype(np.float32), draw.normal(size=1).astype(np.float32)
    rows, words = draw.normal(size=(5, 9)).astype(np.float32), draw.integers(1 << 31, size=(9, 7))
    sources = [Table(column(normals, wp.vec3)), Table(column(single, float)), Table(column(rows, float), axis=1),
               Table(column(words, wp.uint32))]  # fmt: skip
    targets = [Table(wp.zeros(6, dtype=wp.vec3, device=CPU)), Table(wp.zeros(1, dtype=float, device=CPU)),
               Table(wp.zeros((5, 6), dtype=float, device=CPU), axis=1),
               Table(wp.zeros((6, 7), dtype=wp.uint32, device=CPU))]  # fmt: skip
    Carrying(sources, targets, CPU).run()
    origin = origins(6, 9)
    wanted = normals[origin], single, rows[:, origin], words[origin]
    for table, expected in zip(targets, wanted, strict=True):
        assert np.array_equal(table.values.numpy(), expected)


def test_nothing_is_carried_of_no_tables() -> None:
    Carrying([], [], CPU).run()
