from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace

import pytest
from scenes import box, grey, resident_of

from gpu.core.stages import Stages
from gpu.methods.light_making import keeps_lights, light_set_choice, make_lights
from gpu.methods.method import RenderSetup
from gpu.sample_counts import sample_counts_of
from gpu.settings import RenderSettings, Skips
from gpu.vpl.light_sets import LightSets

SIZE = (12, 8)


@pytest.fixture(scope="module")
def setup() -> RenderSetup:
    device_scene = resident_of(box(), [grey(0.5, emission=1.0)])
    settings = RenderSettings(vpls=500, vpl_clusters=20, sp_clusters=10)
    counts = sample_counts_of(settings, device_scene.device, SIZE[0] * SIZE[1])
    return RenderSetup(device_scene, LightSets(device_scene), SIZE, settings, counts, lambda what, share: None)


def test_a_set_is_kept_once_it_is_made_unless_settings_forbid_that(setup: RenderSetup) -> None:
    light_set, stages = setup.light_sets.at(light_set_choice(setup)), Stages(setup.device)
    assert not keeps_lights(setup, light_set)
    stages.start_frame()
    make_lights(setup, light_set, stages, captured=True)
    assert list(stages.milliseconds()) == ["pilot", "light", "vpl-clusters", "radiosity"]
    assert keeps_lights(setup, light_set)
    anew = replace(setup, settings=setup.settings.model_copy(update={"skip": Skips(unchanged_lights=False)}))
    assert not keeps_lights(anew, light_set)


class StagesOfAGpu(Stages):
    """Runs what is forked last of all."""

    def __init__(self) -> None:
        self.graph_key, self.stepwise, self.forked = (), False, list[Callable[[], None]]()

    def run(self, name: str, work: Callable[[], None], **_: object) -> None:
        """At once."""
        work()

    def fork(self, name: str, part: str, work: Callable[[], None], **_: object) -> None:
        """Later."""
        self.forked.append(work)

    def flush(self) -> None:
        """Nothing waits for that."""

    def beside(self) -> AbstractContextManager[None]:
        """In order."""
        return nullcontext()


@pytest.mark.parametrize("asked_before", [False, True])
def test_a_set_stays_made_whenever_its_radiosity_is_asked_for(setup: RenderSetup, asked_before: bool) -> None:
    sets, stages = LightSets(setup.device_scene), StagesOfAGpu()
    own, choice = replace(setup, light_sets=sets), light_set_choice(setup)
    light_set = sets.made(choice, setup.progress) if asked_before else sets.at(choice)
    if asked_before:
        sets.radiosity(light_set)
    make_lights(own, light_set, stages, captured=True)
    sets.radiosity(light_set)
    for work in stages.forked:
        work()
    sets.settle()
    assert sets.is_current(light_set)
    assert len(stages.forked) == asked_before


def test_sets_of_a_still_view_differ_by_their_seeds_alone(setup: RenderSetup) -> None:
    first, second = (light_set_choice(setup, number) for number in range(2))
    assert first.seed == setup.settings.seed != second.seed
    assert replace(second, seed=first.seed) == first
