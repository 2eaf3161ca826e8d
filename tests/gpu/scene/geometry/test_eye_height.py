"""Where people could stand: on floors, with headroom, not on tables or roofs' undersides."""

import numpy as np
import pytest

from gpu.scene.geometry.eye_height import EYE_HEIGHT, standing_eyes

# A box from 0 to 1, seen from inside and from outside.
UNIT = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
OUTWARD = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
INWARD = OUTWARD[:, ::-1]
Box = tuple[tuple[float, float, float], tuple[float, float, float], np.ndarray]
ROOM: Box = ((0, 0, 0), (6, 3, 5), INWARD)


def built(*boxes: Box) -> tuple[np.ndarray, np.ndarray]:
    vertices = np.concatenate([UNIT * size + np.array(low) for low, size, _ in boxes])
    return vertices, np.concatenate([faces + 8 * number for number, (_, _, faces) in enumerate(boxes)])


def heights(*boxes: Box, at: tuple[float, float] = (3.3, 2.1), metre: float = 1.0) -> list[float]:
    """Of the eyes of people in one column, above the zero."""
    return [round(float(y), 6) for y in standing_eyes([at], *built(*boxes), metre)[:, 1]]


def test_people_stand_on_the_floor_of_a_room_whatever_the_unit() -> None:
    assert heights(ROOM) == [EYE_HEIGHT]
    vertices, triangles = built(ROOM)
    eyes = standing_eyes([(0.33, 0.21)], vertices / 10 + 7.0 * np.array([0, 1, 0]), triangles, 0.1)
    assert np.allclose(eyes, [[0.33, 7 + EYE_HEIGHT / 10, 0.21]])


def test_nobody_stands_where_nothing_is_below() -> None:
    assert heights(ROOM, at=(7.0, 2.0)) == []


@pytest.mark.parametrize(("height", "there"), [(1.89, False), (1.91, True)])
def test_nobody_stands_where_the_ceiling_is_low(height: float, there: bool) -> None:
    assert bool(heights(((0, 0, 0), (6, height, 5), INWARD))) is there


@pytest.mark.parametrize(("share", "there"), [(0.2, False), (0.3, True)])
def test_what_is_small_is_a_table_and_no_floor(share: float, there: bool) -> None:
    """A block on the floor, under which nobody can stand; its size is a share of the floor's."""
    block: Box = ((0.1, 0.05, 0.1), (5.8, 0.9, 5.0 * share / 0.97), OUTWARD)
    eyes = standing_eyes([(3.0, 0.5), (3.0, 4.9)], *built(ROOM, block), 1.0)
    assert sorted(np.round(eyes[:, 1], 6).tolist()) == ([1.6, 2.55] if there else [1.6])


def test_floors_of_several_storeys_and_steps_are_told_apart() -> None:
    upper: Box = ((0, 3.2, 0), (6, 3, 5), INWARD)
    assert heights(ROOM, upper) == [1.6, 4.8]
    step: Box = ((2.0, 0.05, 1.0), (2.0, 0.09, 2.0), OUTWARD)
    assert heights(ROOM, step) == [1.74]  # a carpet is part of the floor that it lies on
    kerb: Box = ((2.0, 0.05, 1.0), (2.0, 0.2, 2.0), OUTWARD)
    assert heights(ROOM, kerb) == [1.85]  # the only one in this column


@pytest.mark.parametrize(("slope", "there"), [(0.7, True), (0.8, False)])
def test_a_ramp_is_a_floor_and_a_wall_is_none(slope: float, there: bool) -> None:
    vertices = np.array([[0.0, 0, 0], [4, 4 * slope, 0], [4, 4 * slope, 4], [0, 0, 4]])
    eyes = standing_eyes([(2.0, 1.9)], vertices, np.array([[0, 2, 1], [0, 3, 2]]), 1.0)
    assert np.allclose(eyes[:, 1], [2 * slope + EYE_HEIGHT] if there else [])
