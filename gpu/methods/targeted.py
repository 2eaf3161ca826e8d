"""`fuzzy-vpl` for a wanted frame time or error: its counts of clusters are chosen from frame to frame
(gpu.adaptive.governor).
"""

from dataclasses import replace
from typing import Any

from gpu.adaptive.governor import FARTHEST, WALKED, ErrorGovernor, Governor
from gpu.adaptive.levels import ERROR_RANGE, MOST_PASSES, TIME_RANGE, Level, Levels, levels_of
from gpu.adaptive.time_model import TimeModel
from gpu.core.stages import Stages
from gpu.methods.fuzzy_vpl import FuzzyVpl
from gpu.methods.passes import FrameStatistics
from gpu.methods.view_state import ViewState
from gpu.sample_counts import SampleCounts
from gpu.settings import RenderSettings
from gpu.vpl.light_sets import LightSets, Progress

# Numbers of VPL clusters that are kept, each with graphs and arrays for all numbers of SP clusters (about 0.6 GB for a
# GPU's default number, 1 to 2.5 GB for eight times that): a walk goes to and fro between some.
KEPT_LIGHTS = 4
# Frames of a walk with other lights than before until they take what those that follow do.
FIRST_OF_LIGHTS = 4
# Times of a walk grow unforeseen more often than they fall: by what is new in a view, and by what else the host does.
WALK_AIM = 0.98
# As many times the device's own number of VPL clusters, and of VPLs: their light set takes that squared to make.
MOST_TIMES = 8


class TargetedVpl:
    """`fuzzy-vpl` with the counts of clusters that meet `settings.target_ms` or `settings.target_error`.

    For a time, VPLs are in proportion to clusters of them; errors are of pictures whose VPLs stay. A new number of VPL
    clusters needs a light set; those are kept by `light_sets`, and there are few such numbers. Later frames of a still
    view have the counts of its first, since their times and errors are others. For a time, frames of a walk, which
    keep clusters, are governed apart from those that begin from nothing.
    """

    def __init__(
        self,
        view: ViewState,
        settings: RenderSettings,
        sample_counts: SampleCounts,
        light_sets: LightSets,
        progress: Progress,
    ) -> None:
        self._settings, self._usual = settings, sample_counts
        self._target = settings.target_error or settings.target_ms or 0.0
        # None: as many as clusters need.
        self._vpls = sample_counts.vpls if settings.target_error else settings.vpls
        below, passes = (ERROR_RANGE, 1) if settings.target_error else (TIME_RANGE, MOST_PASSES)
        if self._vpls is None:
            levels = Levels(view.pixels, most=MOST_TIMES * sample_counts.vpl_clusters, below=below, passes=passes)
        else:
            levels = levels_of(view.pixels, self._vpls, below=below, passes=passes)
        self._levels = levels
        self._level = levels.nearest(float(sample_counts.sp_clusters * sample_counts.vpl_clusters))
        self._governors: dict[bool, Governor[Any]] = {}
        # Whether the next frame is another try at the last one.
        self._again = False
        # How many frames from the last one on are unlike those that follow in a walk.
        self._unlike = 0
        self._view = view
        most = max(map(levels.most, levels.vpl_clusters))
        self._method = FuzzyVpl(view, settings, self._sample_counts(self._level), light_sets, progress, most)
        self._method.use(self._level.sp_clusters, self._level.passes, begins=True)
        self._kept = {self._level.vpl_clusters: self._method}  # in the order of their last use

    def governs_apart(self, *, walks: bool) -> bool:
        """Whether frames are governed as those of a walk, apart from others: for an error all are alike."""
        return walks and self._settings.target_error is None

    @property
    def _governor(self) -> Governor[Any]:
        """That of a walk, or of frames that begin from nothing, whatever the last one was."""
        apart = self.governs_apart(walks=self._view.walks)
        if apart not in self._governors:
            if self._settings.target_error:
                self._governors[apart] = ErrorGovernor(self._levels, self._target, self._level)
            else:
                aim, rise = (WALK_AIM, WALKED) if apart else (1.0, FARTHEST)
                target = aim * self._target
                self._governors[apart] = Governor(self._levels, TimeModel(), target, self._level, rise=rise)
        return self._governors[apart]

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """One frame at the level that was chosen for it."""
        again, self._again = self._again, False
        changes = sample == 0 and self._level != self._governor.level
        self._unlike = max(self._unlike - 1, 0) if self._view.walks else 0
        if changes:
            level = self._governor.level
            relights = level.vpl_clusters != self._level.vpl_clusters
            if relights:
                self._relight(level, stages, progress)
            self._method.use(level.sp_clusters, level.passes, begins=relights, again=again)
            if self._view.walks and relights:
                self._unlike = FIRST_OF_LIGHTS
            elif self._view.walks and level.sp_clusters != self._level.sp_clusters:
                self._unlike = max(self._unlike, 1)
            self._level = level
        stages.graph_key = self._level.vpl_clusters
        self._method.render(stages, sample, progress)

    def _relight(self, level: Level, stages: Stages, progress: Progress) -> None:
        number = level.vpl_clusters
        if number in self._kept:
            self._method = self._kept.pop(number)
        else:
            if len(self._kept) == KEPT_LIGHTS:  # before the new one takes memory
                oldest = next(iter(self._kept))
                del self._kept[oldest]
                stages.forget(oldest)
            self._method = self._method.relit(self._sample_counts(level), progress)
        self._kept[number] = self._method

    def learn(self, times: dict[str, float], *, steady: bool, shown: bool) -> bool:
        """Choose the next frame's level by the last frame, which is ready and was the first of its view.

        For a wanted time, times: what that took [ms], by parts; steady: without what only a first frame does; shown:
        whether anybody sees it: else light sets are chosen anew. An error is told by the frame's probes.

        True when the level can stay: it meets the target, or comes as near to it as any does. The first frames of a
        level in a walk have more new clusters than those that follow, and take up to a fifth longer, with other lights
        three times as long: that tells nothing of them.
        """
        if self._method.probes is not None:
            return self._governor.learn(self._method.probes.estimate())
        return self._unlike == 0 and steady and self._governor.learn(times, anew=not shown)

    def tries_again(self, tries: int) -> bool:
        """Whether the last frame that was learnt of is seen to have too large an error, and other counts promise less.

        tries: how many it had. The next frame has these counts then.
        """
        governor = self._governor
        self._again = isinstance(governor, ErrorGovernor) and governor.try_again(self._level, tries)
        return self._again

    def count(self) -> None:
        """As `fuzzy-vpl` does."""
        self._method.count()

    def statistics(self) -> FrameStatistics:
        """Those of `fuzzy-vpl`."""
        return self._method.statistics()

    def estimates(self) -> dict[str, float]:
        """The target, and what a frame of the chosen level is expected to give."""
        kind = "error" if self._settings.target_error else "ms"
        told = {"tries": 1.0} if self._settings.target_error else {"passes": self._level.passes}
        expected = self._governor.expected
        return {f"target_{kind}": self._target} | ({} if expected is None else {f"expected_{kind}": expected}) | told

    def _sample_counts(self, level: Level) -> SampleCounts:
        """That of `level` with the most SP clusters of its lights."""
        vpls = self._vpls or self._usual.vpls * level.vpl_clusters // self._usual.vpl_clusters
        most = self._levels.most(level.vpl_clusters)
        return replace(self._usual, sp_clusters=most, vpl_clusters=level.vpl_clusters, vpls=vpls)
