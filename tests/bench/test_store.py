import json
from concurrent.futures import Future
from functools import partial
from pathlib import Path

import pytest

from gpu.errors import UserError
from tests.bench.store import Budget, Results, Row, Task, read_rows, run_tasks

HERE = {"device": "here", "commit": "a"}


def tasks_of(names: str, measured: list[str]) -> list[Task]:
    def task(name: str) -> Task:
        def measure() -> Row:
            measured.append(name)
            return {"value": name}

        return Task(name, measure)

    return [task(name) for name in names]


def quiet(_: str) -> None:
    pass


def test_a_later_run_measures_only_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "part.json"
    measured: list[str] = []
    run_tasks(tasks_of("ab", measured), Results(path, HERE), Budget(None), quiet)
    run_tasks(tasks_of("abc", measured), Results(path, HERE), Budget(None), quiet)
    assert measured == ["a", "b", "c"]
    assert [row["value"] for row in read_rows(path)] == ["a", "b", "c"]


def test_another_commit_measures_anew_and_replaces_what_it_measured(tmp_path: Path) -> None:
    path = tmp_path / "part.json"
    measured: list[str] = []
    run_tasks(tasks_of("ab", measured), Results(path, HERE), Budget(None), quiet)
    run_tasks(tasks_of("a", measured), Results(path, {**HERE, "commit": "b"}), Budget(None), quiet)
    assert measured == ["a", "b", "a"]
    assert {row["key"]: row["environment"]["commit"] for row in read_rows(path)} == {"a": "b", "b": "a"}


def test_the_first_rows_are_measured_when_the_budget_does_not_last(tmp_path: Path) -> None:
    now, measured = [0.0], []

    def measure_slowly(name: str) -> Row:
        now[0] += 10.0
        measured.append(name)
        return {}

    tasks = [Task(name, partial(measure_slowly, name)) for name in "abcd"]
    left = run_tasks(tasks, Results(tmp_path / "part.json", HERE), Budget(15.0, lambda: now[0]), quiet)
    assert measured == ["a", "b"]
    assert left == 2


def test_parts_share_what_is_left() -> None:
    now = [0.0]
    whole = Budget(30.0, lambda: now[0])
    first = whole.share(3)
    now[0] = 4.0
    assert not first.spent()
    rest = whole.share(2)
    now[0] = 10.0
    assert first.spent()
    assert not rest.spent()
    now[0] = 17.0
    assert rest.spent()
    assert not Budget(None).share(2).spent()


def test_a_row_that_was_measured_survives_a_later_ones_failure(tmp_path: Path) -> None:
    path = tmp_path / "part.json"

    def fail() -> Row:
        raise RuntimeError("lost the device")

    with pytest.raises(RuntimeError, match="lost"):
        run_tasks([*tasks_of("a", []), Task("b", fail)], Results(path, HERE), Budget(None), quiet)
    assert [row["key"] for row in read_rows(path)] == ["a"]


def test_rows_wait_for_their_futures_and_hold_no_nan(tmp_path: Path) -> None:
    path = tmp_path / "part.json"
    errors: Future[Row] = Future()
    results = Results(path, HERE)
    results.add("a", {"errors": {"total": errors}})
    assert not path.exists()
    errors.set_result({"mse": float("nan"), "nonfinite": 3})
    results.close()
    assert read_rows(path)[0]["errors"] == {"total": {"mse": None, "nonfinite": 3}}


def test_devices_do_not_mix(tmp_path: Path) -> None:
    path = tmp_path / "part.json"
    run_tasks(tasks_of("a", []), Results(path, HERE), Budget(None), quiet)
    with pytest.raises(UserError, match="another --out"):
        Results(path, {**HERE, "device": "there"})


@pytest.mark.parametrize("content", ["", "[]", json.dumps({"rows": [{}]})])
def test_another_file_is_not_taken_for_results(tmp_path: Path, content: str) -> None:
    path = tmp_path / "part.json"
    path.write_text(content)
    with pytest.raises(UserError, match=r"part\.json"):
        Results(path, HERE)


def test_a_step_has_no_more_time_than_is_left() -> None:
    now = [0.0]
    whole = Budget(30.0, lambda: now[0])
    short, long = whole.at_most(10.0), whole.at_most(50.0)
    now[0] = 10.0
    assert short.spent()
    assert not long.spent()
    now[0] = 30.0
    assert long.spent()
    free = Budget(None, lambda: now[0]).at_most(5.0)
    assert not free.spent()
    now[0] = 35.0
    assert free.spent()
