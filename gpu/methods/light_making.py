"""The light set of a frame: which it is, whether it is kept, and how it is made as stages beside others."""

from collections.abc import Callable

import warp as wp

from gpu.core.stages import Stages
from gpu.methods.frame_kind import frame_seed
from gpu.methods.method import RenderSetup
from gpu.vpl.light_set import LightSet, LightSetChoice


def light_set_choice(setup: RenderSetup, number: int = 0) -> LightSetChoice:
    """The light set number `number` of a still view."""
    settings, counts = setup.settings, setup.sample_counts
    seed = frame_seed(settings.seed, number)
    return LightSetChoice(counts.vpls, counts.vpl_clusters, setup.bounces, seed, settings.lambertian)


def keeps_lights(setup: RenderSetup, light_set: LightSet) -> bool:
    """Whether a light set is kept from before; else, or where settings forbid that, `make_lights` is to make it."""
    setup.light_sets.wait_for_made()
    return setup.settings.skip.unchanged_lights and setup.light_sets.is_current(light_set)


def make_lights(setup: RenderSetup, light_set: LightSet, stages: Stages, *, captured: bool) -> None:
    """Make a light set that is not kept, beside the frame's stages so far, which must not read it.

    captured: its making may be replayed; then radiosity is made beside the stages up to `near`, unless something that
    runs apart from these reads it, or nobody has asked for it yet: who does finds it at once.
    """
    sets, key, radiosity = setup.light_sets, stages.graph_key, list[Callable[[], None]]()
    see_through = setup.device_scene.features(lambertian=setup.settings.lambertian).see_through
    begins_near = captured and not stages.stepwise and not see_through

    def run(name: str, part: Callable[[], None]) -> None:
        stages.graph_key = light_set.numbers
        if name == "radiosity" and begins_near and light_set.cache is not None:
            radiosity.append(part)
        else:
            stages.run(name, part, repeats=captured)
            stages.flush()  # what it made is read

    if sets.is_current(light_set):
        wp.synchronize_device(setup.device)  # others may read it
    with stages.beside():
        sets.renew(light_set, setup.progress, run)
    for part in radiosity:
        sets.leave_open(light_set)
        stages.fork("near", "radiosity", part)
    stages.graph_key = key
