from pathlib import Path
from typing import Any

import pytest


def test_stages_of_other_methods_do_not_lie_over_those_of_fuzzy_vpl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    from tests.bench import sweep_plots

    def row(method: str, group: str, sps: int) -> dict[str, Any]:
        counts = {"sp_clusters": sps, "vpl_clusters": 20, "vpls": 80, "clustering": "both", "method": method}
        times = {"median": 2.0}
        return {"scene": "room", "groups": [group], "settings": counts, "stages": {"x": times}, "frame_ms": times}

    rows = [row("fuzzy-vpl", "default", 10), row("photon-gather", "default", 10), row("fuzzy-vpl", "paper", 30)]
    figures: list[Any] = []
    monkeypatch.setattr(sweep_plots, "save", lambda figure, *_: figures.append(figure))
    list(sweep_plots.stage_stacks(rows, tmp_path))
    bars, numbers = figures[0].axes[0].patches, figures[0].axes[0].texts
    assert len(bars) == len(numbers) == 2
    assert [text.get_position()[1] for text in numbers] == [bar.get_y() + bar.get_height() / 2.0 for bar in bars]
