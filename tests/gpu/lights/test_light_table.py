import numpy as np
import pytest
import warp as wp
from emitters import POINT, SPOT, SUN, lamp_room, share_kernel
from scenes import box, grey, resident_of, results
from scipy import stats

from gpu.lights.build import build_light_table
from gpu.lights.light_table import (
    NOT_AN_EMITTER,
    LightTable,
    PowerCdf,
    choose_emitter,
    emitter_of,
)
from gpu.sampling.sobol import hashed
from gpu.scene.types import Light, LightKind, Sky

COUNT = 1 << 14


@wp.kernel
def choose_kernel(first: int, shares: PowerCdf, out: wp.array[wp.vec2]) -> None:
    index = first + wp.tid()
    choice = choose_emitter(shares, hashed(wp.uint32(index)))
    out[index] = wp.vec2(float(choice.index), choice.probability)


@wp.kernel
def emitter_kernel(first: int, table: LightTable, out: wp.array[int]) -> None:
    index = first + wp.tid()
    out[index] = emitter_of(table, index)


def test_emitters_are_chosen_in_proportion_to_power() -> None:
    device_scene = lamp_room(lights=[POINT, SPOT, SUN], sky=Sky((0.1, 0.2, 0.3)))
    table = build_light_table(device_scene)
    assert table.all_emitters.count == 2 + 1 + 3
    (radius,) = table.radius.numpy()
    assert radius == pytest.approx(0.75**0.5)
    lamp = np.pi * 3.0 * 0.04 / 2.0
    powers = [lamp, lamp, 0.2 * 2.0 * (np.pi * radius) ** 2, 2.0 * 4.0 * np.pi, 3.0 * 2.0 * np.pi * 0.4,
              3.5 / 3.0 * np.pi * radius**2]  # fmt: skip
    chosen = results(choose_kernel, COUNT, [table.all_emitters], wp.vec2)
    counts = np.bincount(chosen[:, 0].astype(int), minlength=6)
    expected = np.array(powers) / np.sum(powers)
    assert stats.chisquare(counts, expected * COUNT).pvalue > 1e-3
    assert np.allclose(chosen[:, 1], expected[chosen[:, 0].astype(int)], rtol=1e-4)
    assert results(share_kernel, 6, [table.all_emitters], float).sum() == pytest.approx(1.0, abs=1e-6)


def test_each_emissive_triangle_is_found_among_all() -> None:
    device_scene = lamp_room()
    emitters = results(emitter_kernel, 14, [build_light_table(device_scene)], int)
    assert emitters[12:].tolist() == [0, 1]
    assert (emitters[:12] == int(NOT_AN_EMITTER)).all()


def test_shares_hold_for_lights_of_no_power() -> None:
    dark = Light("dark", LightKind.POINT, (0.0, 0.0, 0.0))
    device_scene = resident_of(box(), [grey(0.5)], lights=[POINT, dark])
    table = build_light_table(device_scene)
    chosen = results(choose_kernel, COUNT, [table.all_emitters], wp.vec2)
    assert (chosen[:, 0] == 0).all()
