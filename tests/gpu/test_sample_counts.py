import pytest
import warp as wp
from pydantic import ValidationError

from gpu.sample_counts import ON_CPU, PATHS, sample_counts_of
from gpu.settings import Method, RenderSettings


def test_open_counts_are_chosen_for_the_device_and_given_ones_kept() -> None:
    cpu = wp.get_device("cpu")
    assert sample_counts_of(RenderSettings(), cpu) == ON_CPU
    sample_counts = sample_counts_of(RenderSettings(vpls=77, samples=3), cpu)
    assert (sample_counts.vpls, sample_counts.samples, sample_counts.sp_clusters) == (77, 3, ON_CPU.sp_clusters)
    assert sample_counts_of(RenderSettings(method=Method.PATH), cpu).samples == PATHS


@pytest.mark.parametrize("wrong", [{"vpls": 0}, {"fuzziness": 9}, {"exposure": -1.0}, {"unknown": 1}, {"method": "x"}])
def test_settings_out_of_range_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError, match=next(iter(wrong))):
        RenderSettings(**wrong)
