from pathlib import Path

import pytest

from tests.bench import __main__ as command
from tests.bench.floor_tables import floors_table
from tests.bench.goals import Goal
from tests.bench.page import SECTIONS, page, shortfalls
from tests.bench.plots import run as plot
from tests.bench.store import Row
from tests.bench.suite import Suite
from tests.bench.tables import targets_table

ROOT = Path(__file__).parents[2]
RESULTS, DOCS = ROOT / "tests/bench/results", ROOT / "docs"
# Folders of rows, and the pages of them.
PAGES = {"h100": "results.md", "h200": "results-h200.md"}
MOST_IMAGE_BYTES, MOST_BYTES = 300_000, 4_000_000


def committed(tmp_path: Path, name: str) -> Suite:
    return Suite(out=RESULTS / name, cache=tmp_path, device="cpu", page_file=DOCS / PAGES[name])


@pytest.mark.parametrize("name", PAGES)
def test_the_committed_pages_are_what_the_committed_rows_say(tmp_path: Path, name: str) -> None:
    suite = committed(tmp_path, name)
    images = [path.name for path in suite.images_folder.iterdir()]
    assert (DOCS / PAGES[name]).read_text() == page(suite.measured(), suite.images_folder.name, images, suite.tried())


@pytest.mark.parametrize("file", PAGES.values())
def test_the_committed_pages_show_all_their_images_and_they_are_small(file: str) -> None:
    folder, text = (DOCS / file).with_suffix(""), (DOCS / file).read_text()
    sizes = {path.name: path.stat().st_size for path in folder.iterdir()}
    assert all(f"({folder.name}/{name})" in text for name in sizes)
    assert max(sizes.values()) < MOST_IMAGE_BYTES
    assert sum(sizes.values()) < MOST_BYTES


def test_the_page_of_nothing_names_all_that_is_missing() -> None:
    text = page({}, "results", [])
    assert text.count("**Not measured.**") == len(SECTIONS)
    assert "| met |" not in text


def test_what_was_tried_is_on_the_page_if_somebody_wrote_it_down() -> None:
    assert "## What was tried\n\n| idea | gain |\n\n## " in page({}, "results", [], "| idea | gain |\n")
    assert "tried" not in page({}, "results", [])


def test_stages_are_in_the_order_of_what_is_left_to_their_floors() -> None:
    def times(median: float, floor_ms: float) -> Row:
        return {"median": median, "floor_ms": floor_ms, "bound": "fmas"}

    stages = {"gbuffer": times(2.0, 1.0), "shade": times(4.0, 1.0), "other": {"median": 9.0}}
    lines = floors_table([{"scene": "room", "stages": stages}]).splitlines()[2:]
    assert lines == [
        "| shade | multiply-adds | 3 | 4 / 1 (4.0×) |",
        "| gbuffer | multiply-adds | 1 | 2 / 1 (2.0×) |",
        "| other | no model | 0 | – |",
        "| all with a model |  | 4 | 6 / 2 (3.0×) |",
    ]


def test_targets_are_shown_as_ratios() -> None:
    spread = {"median": 1.01, "p5": 0.94, "p95": 1.2}
    row = {"scene": "room", "frames": 180, "held": {**spread, "mean": 1.02, "within": 0.875}, "changes": 7}
    row |= {"pairs": spread, "path_ms": [6.0, 6.5, 6.7, 5.0] * 45}
    errors = {"target": {"error": 1e-3}, "errors": [1e-3, 1.2e-3], "tries": 1.125, "below_at_fewest": 0.25}
    errors["wall_ms"] = {"median": 9.0, "p5": 8.0, "p95": 10.0}
    passes = {"median": 2.0, "p5": 1.0, "p95": 3.5}
    lines = targets_table([{**row, "target": {"ms": 6.0}, "passes": passes}, {**row, **errors}])
    rest, last = "1.01 (0.94–1.2) | 1.02 | 88 %", "180 | 7 | 1.01 (0.94–1.2) |"
    assert lines.splitlines()[2:] == [
        f"| room | 6 ms | {rest} | 25 % | – | 1 | 6.25 (5–6.7) | – | 180 of {last} 2 (1–3.5) |",
        f"| room | MSE 0.001 | {rest} | 50 % | 25 % | 1.12 | 6.25 (5–6.7) | 9 (8–10) | 2 of {last} 1 |",
    ]


def test_all_that_falls_short_is_listed_worst_first_and_no_more() -> None:
    aims = [Goal("speed", 6.0, {"hall": 9.0, "room": 12.0, "yard": 1.0}), Goal("error", 1.0, {"hall": 1.0})]
    lines = shortfalls(aims, {section.part: [{}] for section in SECTIONS}).splitlines()
    assert lines == ["- speed: room 12 (100 % off), hall 9 (50 % off)"]


def test_plots_replace_those_of_an_earlier_run(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    suite = Suite(out=RESULTS / "h100", cache=tmp_path, device="cpu", page_file=tmp_path / "page.md")
    stale = suite.images_folder / "error-time-nowhere.png"
    stale.parent.mkdir()
    stale.touch()
    plot(suite)
    names = {path.name for path in suite.images_folder.iterdir()}
    assert stale.name not in names
    assert {"stages.png", "rest.png", "error-time-cornell-box.png"} <= names


def test_the_page_is_written_where_it_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = ["--out", str(RESULTS / "h100"), "--page", str(tmp_path / "docs/page.md")]
    monkeypatch.setattr("sys.argv", ["bench", "page", *files, "--device", "cpu", "--scenes-named", "sponza"])
    assert command.main() == 0
    text = (tmp_path / "docs/page.md").read_text()
    assert "sponza" in text
    assert "| veach-bidir" not in text  # in words of what was tried it may be
