"""What the methods share: their interface, and the first stages of a frame."""

from typing import Protocol

from gpu.direct import add_direct_light
from gpu.lighting import LightingChoice, Progress
from gpu.lights import LightTable
from gpu.quality import Quality
from gpu.settings import Component, RenderSettings
from gpu.stages import Stages
from gpu.view import View


class RenderMethod(Protocol):
    """What a renderer runs once a frame."""

    def render(self, stages: Stages, progress: Progress) -> None:
        """Fill the view's radiance for its camera."""

    def counts(self) -> dict[str, int]:
        """What the last frame worked on, by name."""

    def skips(self) -> dict[str, int]:
        """What the last frame did not have to do, by name."""


def lighting_choice(settings: RenderSettings, quality: Quality) -> LightingChoice:
    """The light set that `settings` ask for."""
    return LightingChoice(quality.vpls, quality.vpl_clusters, settings.bounces, settings.seed, settings.lambertian)


def render_direct(view: View, settings: RenderSettings, quality: Quality, table: LightTable, stages: Stages) -> None:
    """Trace the primary rays and start the picture with direct light, or with black when only indirect is wanted."""
    stages.run("gbuffer", view.find_shading_points)
    if settings.component is Component.INDIRECT:
        view.radiance.zero_()
        return
    stages.run(
        "direct",
        lambda: add_direct_light(
            view.resident, view.scene, table, view.gbuffer, view.size, quality.samples, settings.seed, view.radiance
        ),
    )
