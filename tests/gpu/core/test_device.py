from collections.abc import Callable
from os import environ
from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp
from devices import NEEDS_CUDA

from gpu.core import device as launching
from gpu.core.device import (
    MIN_SLICE,
    alike,
    allocate,
    choose_device,
    duplicate,
    identical,
    launch,
    launch_together,
    layout_of,
    overwrite,
    struct_array,
    write_changes,
)
from gpu.core.lane import CUDA_FRAMES
from gpu.core.sharing import DEVICE_SHARING
from gpu.errors import DeviceError
from gpu.lights.light_paths import Vpls
from gpu.sampling.sobol import Pair


@wp.struct
class Inner:
    light: wp.array[float]
    unset: wp.array[int]


@wp.struct
class Nested:
    inner: Inner
    radius: float
    never_set: bool


@wp.kernel
def count_kernel(first: int, visits: wp.array[int]) -> None:
    """One thread an item: counts its visits."""
    item = first + wp.tid()
    visits[item] += 1


def test_an_unknown_device_is_refused_with_those_there_are() -> None:
    with pytest.raises(DeviceError, match="cpu"):
        choose_device("cuda:77")


def test_a_gpu_that_is_chosen_becomes_the_current_device(monkeypatch: pytest.MonkeyPatch) -> None:
    gpus, current = [SimpleNamespace(alias=f"cuda:{number}", is_cuda=True) for number in range(2)], []
    monkeypatch.setattr(wp, "get_devices", lambda: gpus)
    monkeypatch.setattr(wp, "set_device", current.append)
    monkeypatch.setattr(wp, "set_stream", lambda _stream, _device: None)
    monkeypatch.setattr(wp, "Stream", lambda _device, priority: None)
    monkeypatch.setattr(launching, "_prioritised", set())
    assert choose_device("cuda:1") is gpus[1]
    assert current == [gpus[1]]


@pytest.mark.parametrize("count", [0, 1, MIN_SLICE - 1, MIN_SLICE + 1, 50_001])
def test_a_launch_visits_every_item_once(count: int) -> None:
    visits = wp.zeros(max(count, 1), dtype=int, device="cpu")
    launch(count_kernel, count, [visits], choose_device("cpu"))
    assert (visits.numpy()[:count] == 1).all()


class Due:
    """Turns that others always want; visits: of items, at each time that they got one."""

    def __init__(self, visits: wp.array) -> None:
        self._visits = visits
        self.visits: list[int] = []

    def due(self, *, idle: bool = False) -> bool:
        return True

    def give(self) -> None:
        self.visits.append(int(self._visits.numpy().sum()))


@pytest.mark.parametrize("start", [launch, launch_together])
def test_long_launches_give_the_device_to_others_between_slices(
    start: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each slice has what can be done in its time, by what the kernel took before."""
    count = 64 * MIN_SLICE
    visits = wp.zeros(count, dtype=int, device="cpu")
    monkeypatch.setattr(launching, "_costs", Costs(launching.CPU_SLICE_SECONDS / 100.0))
    turns = Due(visits)
    DEVICE_SHARING.begin(turns)
    try:
        start(count_kernel, count, [visits], choose_device("cpu"))
    finally:
        DEVICE_SHARING.begin(None)
    assert (visits.numpy() == 1).all()
    between = np.diff([0, *turns.visits])
    assert between.max() <= 100 * 2 * launching.CORES
    assert between.sum() == count


@NEEDS_CUDA
def test_long_launches_give_a_gpu_to_others_between_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    device, count = choose_device("cuda:0"), 2 * launching.LONG_LAUNCH
    monkeypatch.setattr(launching, "_costs", Costs(launching.CUDA_SLICE_SECONDS))
    visits = wp.zeros(count, dtype=int, device=device)
    turns = Due(visits)
    launch(count_kernel, count, [visits], device)  # alone, at once
    DEVICE_SHARING.begin(turns)
    try:
        launch(count_kernel, launching.LONG_LAUNCH - 1, [visits], device)
        assert turns.visits == []
        launch(count_kernel, count, [visits], device)
        with DEVICE_SHARING.keep():
            launch(count_kernel, count, [visits], device)
    finally:
        DEVICE_SHARING.begin(None)
    assert len(turns.visits) == count // launching.LEAST_CUDA_SLICE
    assert visits.numpy()[[0, -1]].tolist() == [4, 3]


class Costs(dict[wp.Kernel, float]):
    """What an item costs, whatever is measured."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._seconds = seconds

    def get(self, _kernel: wp.Kernel, _default: float | None = None) -> float:
        return self._seconds


def test_a_launch_that_is_over_soon_is_handed_to_no_other_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(launching, "_pool", None)
    count, device = 10 * MIN_SLICE, choose_device("cpu")
    visits = wp.zeros(count, dtype=int, device="cpu")
    monkeypatch.setattr(launching, "_costs", Costs(0.9 * launching.SHORT_SECONDS / count))
    launch(count_kernel, count, [visits], device)
    assert (visits.numpy() == 1).all()
    monkeypatch.setattr(launching, "_costs", Costs(1.1 * launching.SHORT_SECONDS / count))
    with pytest.raises(AttributeError, match="submit"):
        launch(count_kernel, count, [visits], device)


def test_a_kernel_that_nothing_is_known_of_begins_with_a_short_slice(monkeypatch: pytest.MonkeyPatch) -> None:
    costs: dict[wp.Kernel, float] = {}
    monkeypatch.setattr(launching, "_costs", costs)
    visits = wp.zeros(10 * MIN_SLICE, dtype=int, device="cpu")
    turns = Due(visits)
    DEVICE_SHARING.begin(turns)
    try:
        launch_together(count_kernel, len(visits), [visits], choose_device("cpu"))
    finally:
        DEVICE_SHARING.begin(None)
    assert turns.visits[0] == launching.FIRST_CPU_SLICE
    assert costs[count_kernel] > 0.0


def test_allocate_makes_every_array_and_duplicate_shares_them() -> None:
    vpls = allocate(Vpls, 3, choose_device("cpu"))
    vpls.count = 3
    other = duplicate(Vpls, vpls)
    other.count = 2
    assert vpls.count == 3
    assert np.array_equal(vpls.flux.numpy(), np.zeros((3, 3)))
    assert other.flux.ptr == vpls.flux.ptr


def test_what_is_alike_is_overwritten_in_its_arrays() -> None:
    """Nested structs too; arrays that both share stay as they are."""

    def lit(light: float, *, count: int = 3, radius: float = 1.0) -> Nested:
        made = Nested()
        made.inner.light, made.radius = wp.full(count, light, dtype=float, device="cpu"), radius
        return made

    one, other = lit(1.0), lit(2.0)
    assert identical(one, duplicate(Nested, one))
    assert not identical(one, lit(1.0))
    held = one.inner.light
    assert alike(Nested, one, other)
    overwrite(Nested, one, other)
    assert one.inner.light is held
    assert held.numpy().tolist() == [2.0] * 3
    overwrite(Nested, one, one)
    for unlike in (lit(1.0, count=4), lit(1.0, radius=2.0), Nested()):
        assert not alike(Nested, one, unlike)


def test_a_gpu_has_queues_for_all_lanes() -> None:
    assert int(environ["CUDA_DEVICE_MAX_CONNECTIONS"]) >= 2 * CUDA_FRAMES


def test_rows_of_structs_are_put_on_a_device() -> None:
    rows = np.zeros(3, layout_of(Pair))
    rows["a"], rows["b"] = [1, 2, 3], [4, 5, 2**32 - 1]
    found = struct_array(Pair, rows, wp.get_device("cpu")).numpy()
    assert found["a"].tolist() == [1, 2, 3]
    assert found["b"].tolist() == [4, 5, 2**32 - 1]


@pytest.mark.parametrize(("changed", "rows"), [([], (0, 0)), ([2, 5], (2, 6))])
def test_rows_that_changed_are_written_into_an_array(changed: list[int], rows: tuple[int, int]) -> None:
    before = np.random.default_rng(1).random((8, 3), np.float32)
    before[:, 0] = 0.0
    now = before.copy()
    now[changed] *= -1.0  # -0 is another number, too
    array = wp.array(before, dtype=wp.vec3, device="cpu")
    assert write_changes(array, before, now) == rows
    assert array.numpy().tobytes() == now.tobytes()
    assert write_changes(array, now, now) == (0, 0)
