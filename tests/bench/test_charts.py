import pytest


def test_a_scene_has_one_colour_whatever_the_order_of_rows() -> None:
    pytest.importorskip("matplotlib")
    from tests.bench.charts import scene_colours

    rows = [{"scene": name} for name in ("yard", "hall", "room", "hall")]
    colours = scene_colours(rows)
    assert colours == scene_colours(rows[::-1])
    assert len(set(colours.values())) == 3
