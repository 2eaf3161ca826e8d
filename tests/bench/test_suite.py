from pathlib import Path

import numpy as np
import pytest

from gpu.scene.formats.gltf.writing import glb_of
from gpu.scene.load import load_scene
from tests.bench import __main__ as command
from tests.bench import growth, skips, sweep, targets, temporal, walk
from tests.bench.errors import ErrorPool, errors_of
from tests.bench.page import SECTIONS, page
from tests.bench.store import Row, read_rows
from tests.bench.suite import Suite

PARTS = ("sweep", "decompose", "temporal", "targets", "skips", "still", "peers", "growth", "pictures", "walk", "floors")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Row]]:
    """The rows of a very small run of every part."""
    out = tmp_path_factory.mktemp("bench")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(growth, "SIZES", growth.SIZES[:2])
        patch.setattr(growth, "VPL_COUNTS", (2000, 8000))
        patch.setattr(growth, "TRIANGLES", (10_000, 40_000))
        patch.setattr(growth, "QUICK_SIDES", 64)
        patch.setattr(temporal, "SETTINGS", temporal.SETTINGS[:1])
        # Each switch has kernels of its own, which take long to compile.
        patch.setattr(skips, "switches", lambda _: ("near_field", "skip.unchanged_camera"))
        patch.setattr(Suite, "frames", 2)
        patch.setattr(targets, "QUICK_FRAMES", 3)
        patch.setattr(targets, "REACH_EVERY", 2)
        patch.setattr(targets, "TIMES", targets.TIMES[:1])
        patch.setattr(targets, "ERRORS", targets.ERRORS[:1])
        options = ["--groups", "paper", "exact", "--scenes-named", "cornell-box", "--size", "16x12", "--device", "cpu"]
        patch.setattr("sys.argv", ["bench", *PARTS, "--quick", "--reference-samples", "4", "--out", str(out), *options])
        assert command.main() == 0
    return {part: read_rows(out / f"{part}.json") for part in PARTS}


@pytest.mark.parametrize("part", PARTS)
def test_every_part_measures(measured: dict[str, list[Row]], part: str) -> None:
    rows = measured[part]
    assert rows
    assert len({row["key"] for row in rows}) == len(rows)
    assert all(row["scene"] in ("cornell-box", "hall") for row in rows)


def test_the_sweep_has_times_and_both_errors(measured: dict[str, list[Row]]) -> None:
    rows = [row for row in measured["sweep"] if "paper" in row["groups"]]
    assert len(rows) == 3
    for row in rows:
        assert {"gbuffer", "cluster", "visibility", "shade"} <= set(row["stages"])
        assert row["frame_ms"]["p5"] <= row["frame_ms"]["median"] <= row["frame_ms"]["p95"]
        assert all(row["errors"][kind]["nonfinite"] == 0 for kind in ("total", "clustering"))
    assert any("exact" in row["groups"] for row in measured["sweep"])


def test_the_page_has_every_part_that_was_measured(measured: dict[str, list[Row]]) -> None:
    text = page(measured, "results", ["error-time-cornell-box.png", "rest.png", "notes.txt"])
    assert not any(f"**Not measured.** `python -m tests.bench {part}`" in text for part in PARTS)
    assert "![cornell-box: error over time" in text
    assert "](results/rest.png)" in text
    assert "notes.txt" not in text


def test_the_page_names_what_was_not_measured(measured: dict[str, list[Row]]) -> None:
    text = page({"still": measured["still"]}, "results", [])
    assert text.count("**Not measured.**") == len(SECTIONS) - 1
    assert "| clustering MSE | ≤ 0.0005 | – | – | **not measured** |" in text


def test_the_sweep_covers_the_papers_settings_first(tmp_path: Path) -> None:
    suite = Suite(out=tmp_path, cache=tmp_path, device="cpu")
    choices = list(sweep.choices(suite).items())
    assert choices[0][1][0] == "default"
    settings = [(choice.vpl_clusters, choice.sp_clusters) for choice, names in choices if "paper" in names]
    assert settings == [(750, 1000), (2000, 8000), (4000, 30_000)]
    names = {name for _, groups in choices for name in groups}
    assert names == {"default", "paper", "exact", "path", "fuzziness", "vpls", "sps", "vpl-clusters", "both"}
    assert len({sweep.title(choice) for choice, _ in choices}) == len(choices)


def test_a_walk_has_the_size_of_its_scenes_reference(
    measured: dict[str, list[Row]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (row,) = measured["walk"]
    assert row["size"] == [16, 12]
    (tmp_path / "box.glb").write_bytes(glb_of(load_scene("cornell-box")))
    black = np.zeros((12, 20, 3), np.float32)
    np.savez(tmp_path / "box.npz", full=black, direct=black)
    monkeypatch.setattr(walk, "WARM_UP", 1)
    monkeypatch.setattr(Suite, "frames", 2)
    suite = Suite(out=tmp_path, cache=tmp_path, device="cpu", scenes=tmp_path, references=tmp_path, quick=True)
    assert walk.measure_row(suite, "box")["size"] == [20, 12]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sweep", "--scenes-named", "nowhere"], "has no 'nowhere'"),
        (["sweep", "--device", "quantum"], "no device 'quantum'"),
    ],
)
def test_a_wrong_option_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.setattr("sys.argv", ["bench", *arguments, "--out", str(tmp_path)])
    assert command.main() == 1
    assert message in capsys.readouterr().err


def test_errors_are_the_same_from_another_process() -> None:
    reference = np.random.default_rng(0).random((16, 24, 3))
    future = ErrorPool().submit(reference * 1.1, reference)
    assert future.result(60) == errors_of(reference * 1.1, reference)
