import json
from pathlib import Path

import pytest

from gpu.errors import UserError
from server.wire.browser import Bounds, check_rigid
from tests.load.paths import MADE, Orbit, Resting, View, Walk, path_maker, read_path, write_path

ROOM = Bounds(min=(-2.0, 0.0, 1.0), max=(4.0, 3.0, 2.0))
TIMES = [0.0, 0.4, 3.0, 17.0, 71.3, 1200.0]


@pytest.mark.parametrize("name", MADE)
def test_made_paths_are_rigid_inside_the_box_and_the_same_each_time(name: str) -> None:
    for seed in range(5):
        path, again = MADE[name](ROOM, seed), MADE[name](ROOM, seed)
        for time in TIMES:
            view = path.at(time)
            check_rigid(view.matrix)
            assert view == again.at(time)
            place = view.matrix[12:15]
            assert all(low < at < high for low, at, high in zip(ROOM.min, place, ROOM.max, strict=True))


def test_seeds_give_different_paths_and_paths_move() -> None:
    assert Walk(ROOM, 0).at(1.0) != Walk(ROOM, 1).at(1.0)
    assert Orbit(ROOM, 0).at(1.0) != Orbit(ROOM, 0).at(1.033)


def test_an_orbit_looks_at_the_middle() -> None:
    matrix = Orbit(ROOM, 3).at(5.0).matrix
    eye, ahead, middle = matrix[12:15], [-value for value in matrix[8:11]], (1.0, 1.5, 1.5)
    away = [m - e for m, e in zip(middle, eye, strict=True)]
    distance = sum(value * value for value in away) ** 0.5
    assert [value / distance for value in away] == pytest.approx(ahead)


def test_a_resting_path_stands_still_and_goes_on_where_it_stood() -> None:
    path = Resting(Walk(ROOM, 0), move=2.0, rest=1.0)
    assert path.at(2.1) == path.at(2.9) == Walk(ROOM, 0).at(2.0)
    assert path.at(3.5) == Walk(ROOM, 0).at(2.5)


def test_a_recorded_path_comes_back_and_starts_again(tmp_path: Path) -> None:
    views = [Walk(ROOM, 0).at(time) for time in (0.0, 1.0, 2.0)]
    write_path(tmp_path / "walk.jsonl", [100.0, 101.0, 102.0], views)
    path = path_maker(str(tmp_path / "walk.jsonl"))(ROOM, 0)
    assert [path.at(time) for time in (0.0, 0.9, 1.1, 2.0, 3.5)] == [views[0], views[0], views[1], views[0], views[1]]


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("{", "line 2"),
        (json.dumps({"seconds": 1.0, "yfov": 1.0}), "matrix"),
        (json.dumps({"seconds": 1.0, "yfov": 1.0, "matrix": [2.0] * 16}), "rotation"),
        (json.dumps({"seconds": 1.0, "yfov": 1.0, "matrix": [1.0]}), "16"),
        (json.dumps({"seconds": -1.0, "yfov": 1.0, "matrix": list(Walk(ROOM, 0).at(0.0).matrix)}), "decrease"),
    ],
)
def test_a_wrong_line_is_named(tmp_path: Path, entry: str, words: str) -> None:
    file = tmp_path / "walk.jsonl"
    write_path(file, [0.0], [View(Walk(ROOM, 0).at(0.0).matrix, 1.0)])
    file.write_text(file.read_text() + entry + "\n")
    with pytest.raises(UserError, match=words):
        read_path(file)


def test_an_empty_or_missing_path_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.jsonl").touch()
    with pytest.raises(UserError, match="no poses"):
        path_maker(str(tmp_path / "empty.jsonl"))
    with pytest.raises(UserError, match="no such recorded path"):
        path_maker("nowhere.jsonl")
