import pytest
from pydantic import BaseModel

from gpu.settings import RenderSettings
from tests.bench.skips import FOR_STILL_VIEWS, flipped, switches


class Inner(BaseModel):
    facing: bool = True
    share: int = 8


class Outer(BaseModel):
    smooth: bool = True
    lambertian: bool = False
    samples: int = 1
    skip: Inner = Inner()


def test_switches_are_the_yes_or_nos_also_of_models_within() -> None:
    assert list(switches(Outer)) == ["smooth", "skip.facing"]


def test_switches_of_still_views_are_switches() -> None:
    assert set(FOR_STILL_VIEWS) <= set(switches(RenderSettings))


@pytest.mark.parametrize("switch", list(switches(RenderSettings)))
def test_flipping_changes_one_switch_alone(switch: str) -> None:
    settings = RenderSettings()
    other = flipped(settings, switch)
    assert other != settings
    assert flipped(other, switch) == settings
