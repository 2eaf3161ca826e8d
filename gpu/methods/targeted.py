"""`fuzzy-vpl` for a wanted frame time or error: its counts of clusters are chosen from frame to frame (gpu.target)."""

from dataclasses import replace

from gpu.lighting import Lighting, Progress
from gpu.methods.common import FrameStatistics
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.quality import Quality
from gpu.settings import RenderSettings
from gpu.stages import Stages
from gpu.target import ErrorModel, Governor, Level, Model, TimeModel, ladder
from gpu.view import View

# Levels that are kept, each with arrays of its clusters and captured graphs: a walk goes to and fro between a few.
KEPT_LEVELS = 4


class TargetedVpl:
    """`fuzzy-vpl` with the counts of clusters that meet `settings.target_ms` or `settings.target_error`.

    A new number of VPL clusters needs a light set; those are kept by `lighting`, and there are few such numbers. Later
    frames of a still view have the counts of its first, since their times and errors are others.
    """

    def __init__(
        self, view: View, settings: RenderSettings, quality: Quality, lighting: Lighting, progress: Progress
    ) -> None:
        self._settings, self._usual = settings, quality
        model: Model = ErrorModel() if settings.target_error else TimeModel()
        self._target = settings.target_error or settings.target_ms or 0.0
        work = float(quality.sp_clusters * quality.vpl_clusters)
        self._governor = Governor(ladder(view.pixels, settings.vpls), model, self._target, work)
        self._level = self._governor.level
        self._method = FuzzyVpl(view, settings, self._quality(self._level), lighting, progress)
        self._kept = {self._level: self._method}  # in the order of their last use

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """One frame at the level that was chosen for it."""
        if sample == 0 and self._level != self._governor.level:
            self._level = self._governor.level
            known = self._kept.pop(self._level, None)
            self._method = known or self._method.resized(self._quality(self._level), progress)
            self._kept[self._level] = self._method
            if len(self._kept) > KEPT_LEVELS:
                oldest = next(iter(self._kept))
                del self._kept[oldest]
                stages.forget(oldest)
        stages.variant = self._level
        self._method.render(stages, sample, progress)

    def learn(self, stages: Stages) -> bool:
        """Choose the next frame's level by the last frame, which is ready and was the first of its view.

        True when the level can stay: it meets the target, or comes as near to it as any does.
        """
        if self._method.probes is not None:
            return self._governor.learn(self._method.probes.error())
        return stages.steady and self._governor.learn(sum(stages.milliseconds().values()))

    def statistics(self) -> FrameStatistics:
        """Those of `fuzzy-vpl`."""
        return self._method.statistics()

    def estimates(self) -> dict[str, float]:
        """The target, and what a frame of the chosen level is expected to give."""
        kind = "error" if self._settings.target_error else "ms"
        expected = self._governor.expected
        return {f"target_{kind}": self._target} | ({} if expected is None else {f"expected_{kind}": expected})

    def _quality(self, level: Level) -> Quality:
        # Clusters of more members than usual would be shaded member by member from afar: fewer would take longer.
        usual = self._usual.vpls * level.vpl_clusters // self._usual.vpl_clusters
        vpls = self._settings.vpls or max(usual, level.vpls)
        return replace(self._usual, sp_clusters=level.sp_clusters, vpl_clusters=level.vpl_clusters, vpls=vpls)
