"""What the methods share: their interface, and the first stages of a frame."""

from typing import Protocol

import warp as wp

from gpu.core.stages import Stages
from gpu.direct.direct_light import add_soft_light, trace_direct_light
from gpu.indirect.near_field import NearField
from gpu.lights.light_table import LightTable
from gpu.methods.view_state import ViewState
from gpu.sample_counts import SampleCounts
from gpu.settings import Component, Method, RenderSettings
from gpu.vpl.light_sets import LightSetChoice, LightSets, Progress
from gpu.vpl.radiosity_cache import RadiosityCache
from gpu.vpl.vpl_clusters import VplClusters

# Smoothing blurs shadows a little. It helps the first frames of a still view; later ones are averaged, not smoothed, so
# that the mean forgets the blur.
SMOOTHED_FRAMES = 4
# Those have at least so many samples of direct light, whose noise would be most of the mean's.
SHARPER_SAMPLES = 4

# What a frame is made of and what it did not have to do: counts by name; see gpu.film.frame.FrameStats.
FrameStatistics = tuple[dict[str, int], dict[str, int]]


class RenderMethod(Protocol):
    """What a renderer runs once a frame."""

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """Fill the view's radiance for its camera.

        sample: the frame's number among those of a still view; each has its own samples.
        """

    def count(self) -> None:
        """Launch the sums that `statistics` reads."""

    def statistics(self) -> FrameStatistics:
        """Of the last frame, once it is ready and `count` has run."""


def frame_seed(seed: int, number: int) -> int:
    """The seed of frame `number` of a still view or a walk; that of the first is `seed` itself."""
    return (seed + 0x9E3779B9 * number) % 2**31


def light_set_choice(settings: RenderSettings, sample_counts: SampleCounts, sample: int = 0) -> LightSetChoice:
    """The light set that `settings` ask for in frame `sample` of a still view."""
    seed = frame_seed(settings.seed, sample)
    return LightSetChoice(sample_counts.vpls, sample_counts.vpl_clusters, settings.bounces, seed, settings.lambertian)


def keeps_lights(light_sets: LightSets, choice: LightSetChoice, settings: RenderSettings, stages: Stages,
                 progress: Progress, *, held: bool) -> bool:  # fmt: skip
    """Whether the light set of `choice` is kept from before; else, or where `settings` forbid that, it is made now.

    held: the caller keeps it itself.
    """
    kept = settings.skip.unchanged_lights and (held or light_sets.holds(choice))
    if not kept:
        stages.run("light", lambda: light_sets.renew(choice, progress), repeats=False)
    return kept


def view_skips(view: ViewState, settings: RenderSettings, empty: int) -> dict[str, int]:
    """What primary rays and direct light did not have to do; empty: pixels that see nothing."""
    needs, direct = view.needs, settings.component is not Component.INDIRECT
    return {
        "empty_pixels": empty,
        "absent_alpha": int(not needs.alpha),
        "absent_textures": int(not needs.textures),
        "absent_gloss": int(direct and not needs.gloss),
        "absent_lights": needs.absent_lights if direct else 0,
    }


def is_sharper(sample: int) -> bool:
    """Whether frame `sample` of a still view is of those that make its mean sharp: nothing smooths them."""
    return sample >= SMOOTHED_FRAMES


def is_smoothed(settings: RenderSettings, sample: int) -> bool:
    """Whether frame `sample` of a still view shares light between neighbouring pixels."""
    return settings.smooth and not is_sharper(sample)


def keeps_light(settings: RenderSettings, sample: int) -> bool:
    """Whether frame `sample` of a still view leaves its light to the next of a walk; those of `fuzzy-vpl` do."""
    fuzzy = settings.method is Method.FUZZY_VPL
    return fuzzy and settings.skip.temporal_reuse and settings.smooth and sample == 0


def remembers_light(view: ViewState, sample: int) -> bool:
    """Whether frame `sample` of a still view builds on the light that frames of a walk before it left."""
    return view.step > 0 and sample == 0


def frame_number(view: ViewState, sample: int) -> int:
    """The number of frame `sample` among those of a still view or a walk that have samples of their own each."""
    return sample or view.step


def fork_direct(
    view: ViewState,
    settings: RenderSettings,
    sample_counts: SampleCounts,
    table: LightTable,
    stages: Stages,
    sample: int,
) -> None:
    """Trace the primary rays and begin with direct light, or with a black picture when only indirect is wanted.

    `join_direct` ends what is begun: no stage between needs the picture.
    """
    stages.run("gbuffer", view.find_shading_points)
    if settings.component is Component.INDIRECT:
        view.radiance.zero_()
        return
    gbuffer, seed = view.gbuffer, settings.seed
    samples = max(sample_counts.samples, SHARPER_SAMPLES) if is_sharper(sample) else sample_counts.samples
    keeps, remembers = keeps_light(settings, sample), remembers_light(view, sample)
    view.moment.fill_(frame_number(view, sample))

    def rays() -> None:
        numbers, out = (samples, view.moment, seed), (view.radiance, view.soft)
        trace_direct_light(view.device_scene, view.scene, table, gbuffer, view.size, *numbers, *out, view.needs)
        if view.needs.soft and keeps:
            view.direct_history.take(gbuffer, view.last, view.soft, remembers=remembers)
        if view.needs.soft and is_smoothed(settings, sample):
            view.side_smoothing.run(gbuffer, view.soft)

    stages.fork("direct", "rays", rays, repeats=sample == 0, way=remembers)


def join_direct(view: ViewState, settings: RenderSettings, stages: Stages, sample: int) -> None:
    """Have the direct light that `fork_direct` began in the picture, if it is wanted."""
    if settings.component is Component.INDIRECT:
        return

    def soft() -> None:
        if view.needs.soft:
            add_soft_light(view.gbuffer, view.soft, view.radiance)

    stages.run("direct", soft, repeats=sample == 0, waits_for_fork=True)


def fork_near(view: ViewState, near_field: NearField, vpls: VplClusters, lit: "RadiosityCache | None",
              settings: RenderSettings, stages: Stages, sample: int) -> NearField | None:  # fmt: skip
    """Begin to find by the map `lit` what `vpls` lack near field; these rays need no stage but the first.

    Where light is shared, what earlier frames of a walk found joins in. Returns what `add_indirect` is to add, None
    where there is no map.
    """
    if lit is None:
        return None
    smooth = is_smoothed(settings, sample)

    def rays() -> None:
        sps, frames = view.shading_points, view.history.frames
        near_field.trace(view.scene, view.gbuffer, sps, vpls, lit, view.seed, frames)
        if smooth:
            view.history.take_near(sps, near_field.light)

    stages.fork("near", "rays", rays, repeats=sample == 0)
    return near_field


def fork_near_sharing(view: ViewState, near_field: NearField | None, guide: wp.array, settings: RenderSettings,
                      stages: Stages, sample: int) -> None:  # fmt: skip
    """Begin to smooth what `near_field` of `fork_near` has found; guide (pixel,): irradiance that stays as it is."""
    if near_field and is_smoothed(settings, sample):
        args = view.gbuffer, view.shading_points, guide, view.history.frames
        stages.fork("near", "sharing", lambda: near_field.share(*args), repeats=sample == 0)


def add_indirect(view: ViewState, near_field: NearField | None, settings: RenderSettings, stages: Stages,
                 sample: int) -> None:  # fmt: skip
    """Add the indirect light to the picture; before, what `near_field` of `fork_near` has found."""
    if near_field:
        light, smooth = near_field.light, is_smoothed(settings, sample)

        def near() -> None:
            view.shading_points.add(light, view.indirect.irradiance, bounded=smooth)

        stages.run("near", near, repeats=sample == 0, waits_for_fork=True)
    stages.run("interpolate", view.add_indirect, repeats=sample == 0)
