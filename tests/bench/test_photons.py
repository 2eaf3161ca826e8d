from pathlib import Path

from gpu.settings import Component, Method
from tests.bench.photons import GROWTH, PAPER, choices
from tests.bench.suite import Suite


def test_choices_are_settings_that_change_one_count_at_a_time(tmp_path: Path, cpu: str) -> None:
    suite = Suite(out=tmp_path, cache=tmp_path, device=cpu, quick=True)
    all_settings = [suite.settings(component=Component.INDIRECT, **choice) for choice in choices(suite)]
    first, ablation, *others = all_settings
    assert (first.cut_nodes > 0, ablation.cut_nodes) == (True, 0)
    grown = [settings for settings in others if settings.method is Method.PHOTON_GATHER]
    assert len(grown) == sum(map(len, GROWTH.values()))
    for settings in grown:
        assert sum(getattr(settings, name) != getattr(first, name) for name in PAPER) <= 1
