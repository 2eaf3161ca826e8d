import numpy as np
import pytest

from gpu.scene.animation.keyframes import value_at
from gpu.scene.animation.motion import Channel, Interpolation, Property


def channel(values: list[list[float]], kind: str = "LINEAR", changes: Property = Property.TRANSLATION) -> Channel:
    """Keys at 1, 3 and 7 s, or as many of them as there are values."""
    keys = np.array(values, np.float64).reshape(-1, 3 if kind == "CUBICSPLINE" else 1, len(values[0]))
    return Channel(0, changes, Interpolation(kind), np.array([1.0, 3.0, 7.0])[: len(keys)], keys)


@pytest.mark.parametrize(
    ("kind", "time", "value"),
    [
        *(("LINEAR", time, value) for time, value in ((0.0, 0.0), (1.0, 0.0), (2.0, 4.0), (3.0, 8.0), (4.0, 9.0))),
        *(("STEP", time, value) for time, value in ((0.5, 0.0), (2.9, 0.0), (3.0, 8.0), (6.9, 8.0), (9.0, 12.0))),
    ],
)
def test_values_between_keys_and_beyond(kind: str, time: float, value: float) -> None:
    assert value_at(channel([[0.0], [8.0], [12.0]], kind), time).tolist() == [value]


def test_one_key_holds_for_ever() -> None:
    assert value_at(channel([[2.0, 3.0, 4.0]]), 5.0).tolist() == [2.0, 3.0, 4.0]


def test_rotations_take_the_short_arc_at_an_even_pace() -> None:
    half = np.sqrt(0.5)
    turns = channel([[0.0, 0.0, 0.0, 1.0], [0.0, -half, 0.0, -half]], changes=Property.ROTATION)  # 90° about +Y
    for share in (0.25, 0.5, 0.9):
        angle = share * np.pi / 4.0
        assert np.allclose(value_at(turns, 1.0 + 2.0 * share), [0.0, np.sin(angle), 0.0, np.cos(angle)], atol=1e-12)


def test_rotations_that_are_alike_or_none_stay_finite() -> None:
    for first in ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0]):
        found = value_at(channel([first, [0.0, 0.0, 0.0, 2.0]], changes=Property.ROTATION), 2.0)
        assert found.tolist() == first


def test_a_spline_has_its_keys_values_and_tangents() -> None:
    """t³ − 2t from 1 to 3: the one cubic with those ends and slopes."""

    def cubic(time: float) -> float:
        return time**3 - 2.0 * time

    keys = [[99.0], [cubic(1.0)], [1.0], [25.0], [cubic(3.0)], [99.0]]
    spline = channel(keys, "CUBICSPLINE")
    for time in (1.0, 1.3, 2.0, 2.9, 3.0):
        assert value_at(spline, time)[0] == pytest.approx(cubic(time))
    assert value_at(spline, 9.0).tolist() == [cubic(3.0)]
