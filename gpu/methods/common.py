"""What the methods share: their interface, and the first stages of a frame."""

from typing import Protocol

from gpu.direct import add_soft_light, trace_direct_light
from gpu.lighting import LightingChoice, Progress
from gpu.lights import LightTable
from gpu.quality import Quality
from gpu.settings import Component, RenderSettings
from gpu.stages import Stages
from gpu.view import View

# What a frame worked on and what it did not have to do: counts by name.
FrameStatistics = tuple[dict[str, int], dict[str, int]]


class RenderMethod(Protocol):
    """What a renderer runs once a frame."""

    def render(self, stages: Stages, progress: Progress) -> None:
        """Fill the view's radiance for its camera."""

    def statistics(self) -> FrameStatistics:
        """Of the last frame, once it is ready."""


def lighting_choice(settings: RenderSettings, quality: Quality) -> LightingChoice:
    """The light set that `settings` ask for."""
    return LightingChoice(quality.vpls, quality.vpl_clusters, settings.bounces, settings.seed, settings.lambertian)


def render_direct(view: View, settings: RenderSettings, quality: Quality, table: LightTable, stages: Stages) -> None:
    """Trace the primary rays and start the picture with direct light, or with black when only indirect is wanted."""
    stages.run("gbuffer", view.find_shading_points)
    if settings.component is Component.INDIRECT:
        view.radiance.zero_()
        return
    gbuffer, samples, seed = view.gbuffer, quality.samples, settings.seed

    def direct() -> None:
        trace_direct_light(
            view.resident, view.scene, table, gbuffer, view.size, samples, seed, view.radiance, view.soft
        )
        if settings.smooth:
            view.smoothing.run(gbuffer, view.soft)
        add_soft_light(gbuffer, view.soft, view.radiance)

    stages.run("direct", direct)
