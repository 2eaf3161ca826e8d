import json

import pytest

from gpu.gbuffer import sparse_shading
from gpu.settings import RenderSettings
from tests.bench import sparse


def test_each_choice_has_a_rate_and_errors_with_every_pixel_shaded_and_one_of_four(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sparse_shading, "ANCHOR_PARAMETERS", sparse_shading.ANCHOR_PARAMETERS)  # put back afterwards
    few = {"SIZES": ((24, 16),), "LANES": (1,), "VIEWERS": 1, "WARM_UP": 1, "FRAMES": 1, "WALKED": 2, "RESTING": 2}
    for name, value in {**few, "CHOICES": {"2 samples": {"samples": 2}}, "COMPARED": (0,)}.items():
        monkeypatch.setattr(sparse, name, value)
    sparse.main("cpu", ("cornell-box",), RenderSettings(sp_clusters=8, vpls=64, vpl_clusters=8))
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [(row["choice"], row["shaded"]) for row in rows] == [("2 samples", shaded) for shaded in sparse.SHADED]
    assert all(row["frames_a_second"] > 0.0 for row in rows)
    every, some = (row["errors"][0]["rel_mse"] for row in rows)
    assert 0.0 < every != some < 0.5
