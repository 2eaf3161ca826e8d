from typing import Any

import numpy as np
import pytest

from gpu.scene.file_frame import FileFrame
from gpu.scene.guess import Shape, frame_of
from gpu.scene.import_options import ImportOptions
from gpu.scene.types import Doubles, Integers
from tests.gpu.rooms import room


def guess(
    found: tuple[Doubles, Integers], said: tuple[Any, float | None] = (None, None), **options: Any
) -> tuple[FileFrame, list[str]]:
    positions, triangles = found
    shape = Shape(positions, triangles, positions.min(axis=0), positions.max(axis=0))
    return frame_of(shape, *said, ImportOptions(**options))


@pytest.mark.parametrize(
    ("scale", "metres", "word"), [(1.0, 1.0, ""), (100.0, 0.01, "centimetre"), (1000.0, 0.001, "millimetre")]
)
def test_the_unit_of_a_room_is_guessed_by_its_height(scale: float, metres: float, word: str) -> None:
    frame, notes = guess(room(5 * scale, 4 * scale, 2.7 * scale))
    assert frame.metres_per_unit == metres
    assert len(notes) == bool(word)
    assert all(word in note for note in notes)


@pytest.mark.parametrize(
    "sizes", [(50.0, 40.0, 300.0), (9000.0, 9000.0, 250.0), (5.0, 4.0, 2.7), (1e7, 1e7, 5e6), (0.1, 0.1, 0.15)], ids=str
)
def test_towers_landscapes_and_small_things_are_in_metres(sizes: tuple[float, float, float]) -> None:
    assert guess(room(*sizes))[0].metres_per_unit == 1.0


def test_what_the_file_says_is_believed_and_the_user_still_more() -> None:
    large = room(5000.0, 4000.0, 2700.0)
    assert guess(large, ("y", 1.0)) == (FileFrame("y", 1.0), [])
    assert guess(large, ("y", 1.0), unit="in", up="z", origin=(1, 2, 3)) == (FileFrame("z", 0.0254, (1, 2, 3)), [])
    assert guess(large, unit="m")[0].metres_per_unit == 1.0


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_floor_and_ceiling_tell_which_way_is_up(scale: float) -> None:
    lying, notes = guess(room(5 * scale, 4 * scale, 2.7 * scale, up=2))
    assert (lying.up, lying.metres_per_unit) == ("z", 1.0 / scale)
    assert "floor and ceiling" in notes[0]
    assert guess(room(5 * scale, 4 * scale, 2.7 * scale, up=1))[0].up == "y"
    assert guess(room(5, 4, 2.7, up=2), up="y")[0].up == "y"


@pytest.mark.parametrize("up", [1, 2])
def test_a_thing_seen_from_outside_gives_no_reason_to_turn_it(up: int) -> None:
    """A wardrobe, a door or a picture is thin along Z as well, and stands all the same."""
    positions, triangles = room(1.0, 2.0, 0.4, up)
    assert guess((positions, triangles[:, ::-1])) == (FileFrame(), [])


def test_coordinates_of_a_map_are_east_north_and_height() -> None:
    positions, triangles = room(10.0, 20.0, 30.0, up=2)
    frame, notes = guess((np.add(positions, (456_789.0, 5_432_100.0, 120.0)), triangles[:, ::-1]))
    assert frame.up == "z"
    assert "map" in notes[0]
    turned = guess((np.add(positions, (456_789.0, 120.0, -5_432_100.0)), triangles[:, ::-1]))[0]
    assert turned.up == "y"


def test_the_origin_can_be_the_middle_of_the_scene() -> None:
    positions, triangles = room(4.0, 4.0, 3.0)
    frame, _ = guess((np.add(positions, (456_789.3, 120.2, -5_432_100.1)), triangles), origin="auto")
    assert frame.origin == (456_791.0, 122.0, -5_432_098.0)


def test_a_line_is_no_reason_to_fail() -> None:
    assert guess((np.array([[0.0, 0, 0], [0, 300, 0]]), np.array([[0, 1, 1]])))[0] == FileFrame()
