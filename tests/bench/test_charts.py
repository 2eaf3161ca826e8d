from pathlib import Path

import numpy as np
import pytest


def test_a_scene_has_one_colour_whatever_the_order_of_rows() -> None:
    pytest.importorskip("matplotlib")
    from tests.bench.charts import scene_colours

    rows = [{"scene": name} for name in ("yard", "hall", "room", "hall")]
    colours = scene_colours(rows)
    assert colours == scene_colours(rows[::-1])
    assert len(set(colours.values())) == 3


def test_a_photo_that_is_too_large_has_less_quality(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    from tests.bench import charts

    def size(most: int) -> int:
        monkeypatch.setattr(charts, "MOST_PHOTO_BYTES", most)
        figure, axes = charts.panels(1, 1, 2.0, 2.0)
        axes[0].imshow(np.random.default_rng(0).random((64, 64, 3)))
        return (tmp_path / charts.save(figure, tmp_path, "noise", photo=True)).stat().st_size

    assert size(1) < 0.7 * size(10**9)
