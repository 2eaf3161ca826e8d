from math import inf, nan
from pathlib import Path

import pytest

from gpu.errors import UserError
from tests.load.results import load, save


def test_results_come_back_without_numbers_that_json_does_not_have(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    save(folder, "run", {"rows": [{"age": inf, "fps": (1.5, nan), "errors": {"x": 2}}]})
    assert load(folder, "run") == {"rows": [{"age": None, "fps": [1.5, None], "errors": {"x": 2}}]}
    assert load(folder, "ramp") is None


def test_without_a_folder_nothing_is_written_and_other_files_are_refused(tmp_path: Path) -> None:
    save(None, "run", {})
    (tmp_path / "run.json").write_text("{]")
    with pytest.raises(UserError, match=r"run\.json"):
        load(tmp_path, "run")
