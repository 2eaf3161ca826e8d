import numpy as np
import pytest
import warp as wp
from scenes import column, results

from gpu.core.device import launch
from gpu.vpl.disk_light import Disk, disk_at, disk_of


@wp.kernel
def make_kernel(
    first: int, position: wp.array[wp.vec3], variance: float, normal_cone_cos: float, out: wp.array[Disk]
) -> None:
    """One thread a disk: at its position, of area 2."""
    index = first + wp.tid()
    flux = wp.vec3(float(index), 1.0, 2.0)
    out[index] = disk_of(position[index], wp.vec3(0.0, 0.0, 1.0), flux, 2.0, variance, normal_cone_cos)


@wp.kernel
def read_kernel(first: int, disks: wp.array[Disk], out: wp.array[float]) -> None:
    """One thread a disk: its twelve numbers."""
    index = first + wp.tid()
    disk = disk_at(disks, index)
    for axis in range(3):
        out[12 * index + axis] = disk.position[axis]
        out[12 * index + 3 + axis] = disk.normal[axis]
        out[12 * index + 6 + axis] = disk.flux[axis]
    out[12 * index + 9] = disk.area
    out[12 * index + 10] = disk.radius
    out[12 * index + 11] = disk.tilt


def disks_at(positions: np.ndarray, variance: float, normal_cone_cos: float) -> wp.array:
    disks = wp.zeros(len(positions), dtype=Disk, device="cpu")
    launch(
        make_kernel,
        len(positions),
        [column(positions, wp.vec3), variance, normal_cone_cos, disks],
        wp.get_device("cpu"),
    )
    return disks


def test_a_disk_read_by_wide_loads_is_the_one_that_was_written() -> None:
    positions = np.random.default_rng(0).uniform(-1.0, 1.0, (17, 3))
    disks = disks_at(positions, 0.3, 0.5)
    fields, told = disks.numpy(), results(read_kernel, 17, [disks], float, 12).reshape(17, 12)
    columns = [fields[name].reshape(17, -1) for name in ("position", "normal", "flux", "area", "radius", "tilt")]
    assert np.array_equal(told.astype(np.float32), np.concatenate(columns, axis=1))
    assert told[:, :3] == pytest.approx(positions, abs=1e-6)


def test_an_even_disk_reaches_as_far_as_an_even_spread_of_its_deviation() -> None:
    places = np.random.default_rng(1).uniform(-1.0, 1.0, (200_000, 2))
    places = places[(places**2).sum(axis=1) <= 1.0]
    (disk,) = disks_at(np.zeros((1, 3)), float((places**2).sum(axis=1).mean()), 1.0).numpy()
    assert disk["radius"] / np.sqrt(3.0) == pytest.approx(places[:, 0].std(), rel=0.01)
    assert disk["tilt"] == 0.0


def test_normals_that_stray_turn_a_disk() -> None:
    (disk,) = disks_at(np.zeros((1, 3)), 0.0, 0.8).numpy()
    assert disk["tilt"] == pytest.approx(0.5 * 0.6)
    assert disk["radius"] == 0.0
