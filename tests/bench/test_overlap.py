import json

import pytest

from gpu.settings import RenderSettings
from tests.bench import overlap


def test_each_number_of_lanes_has_a_line_and_pictures_are_those_of_each_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in {"SIZES": ((16, 12),), "LANES": (1, 2), "WARM_UP": 1, "FRAMES": 2, "COMPARED": 2}.items():
        monkeypatch.setattr(overlap, name, value)
    overlap.main("cpu", ("cornell-box",), RenderSettings(sp_clusters=8, vpls=64, vpl_clusters=8), viewers=2)
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [row["lanes"] for row in rows] == [1, 2]
    assert all(row["bit_equal"] and row["frames_a_second"] > 0.0 for row in rows)
