"""`fuzzy-vpl` for a wanted frame time or error: its counts of clusters are chosen from frame to frame.

gpu.adaptive tells which; here light sets, arrays and graphs follow, and frames are rendered again where that is needed.
"""

from dataclasses import replace
from time import perf_counter
from typing import Any

from gpu.adaptive.error_probes import Probes
from gpu.adaptive.governor import FOR_WALK, ErrorGovernor, Governor
from gpu.adaptive.levels import FOR_ERROR, FOR_TIME, Level, Levels, levels_of
from gpu.adaptive.probe_white_point import picture_of
from gpu.adaptive.time_model import TimeModel
from gpu.core.stages import Stages
from gpu.film.accumulation import Accumulation
from gpu.film.frame import Frame
from gpu.methods.clustered_lights import ClusteredLights
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.fuzzy_view_state import FuzzyViewState
from gpu.methods.fuzzy_vpl import FuzzyOptions, FuzzyVpl
from gpu.methods.method import FrameStatistics, RenderMethod, RenderOnce, RenderSetup
from gpu.methods.steering import STEERING_PARAMETERS, Steering, swayed
from gpu.sample_counts import SampleCounts
from gpu.scene.types import Camera
from gpu.vpl.vpl_clusters import VplClusters

# Numbers of VPL clusters that are kept, each with graphs and arrays for all numbers of SP clusters (about 0.6 GB for a
# GPU's default number, 1 to 2.5 GB for eight times that): a walk goes to and fro between some.
KEPT_LIGHTS = 4
# As many times the device's own number of VPL clusters, and of VPLs: their light set takes that squared to make.
MOST_TIMES = 8
# Device memory of a view's probes.
PROBE_BYTES = 100 << 20


class TargetedViewState(FuzzyViewState):
    """A walk whose counts are chosen."""

    steering: Steering


class TargetedVpl(RenderMethod[TargetedViewState]):
    """`fuzzy-vpl` with the counts of clusters that meet `settings.target_ms` or `settings.target_error`.

    For a time, VPLs are in proportion to clusters of them; errors are of pictures whose VPLs stay. A new number of VPL
    clusters needs a light set; those are kept with their scene, and there are few such numbers. Later frames of a still
    view have the counts of its first, since their times and errors are others. For a time, frames of a walk, which
    keep clusters, are governed apart from those that begin from nothing.
    """

    stage_names = FuzzyVpl.stage_names
    pixel_bytes, view_pixel_bytes = FuzzyVpl.pixel_bytes, FuzzyVpl.view_pixel_bytes
    soft_view_pixel_bytes = FuzzyVpl.soft_view_pixel_bytes
    gloss_pixel_bytes, gloss_view_pixel_bytes = FuzzyVpl.gloss_pixel_bytes, FuzzyVpl.gloss_view_pixel_bytes
    branches_pixel_bytes, tint_pixel_bytes = FuzzyVpl.branches_pixel_bytes, FuzzyVpl.tint_pixel_bytes

    @staticmethod
    def cluster_bytes(sample_counts: SampleCounts) -> tuple[int, int]:
        """Those of the most SP clusters that these VPL clusters have, with the probes of a wanted error."""
        most = round(FOR_TIME.above * FOR_TIME.sps_per_vpl * sample_counts.vpl_clusters)
        shared, view = FuzzyVpl.cluster_bytes(replace(sample_counts, sp_clusters=most))
        return shared, view + PROBE_BYTES

    def __init__(self, setup: RenderSetup) -> None:
        settings, usual = setup.settings, setup.sample_counts
        self._setup, self._usual = setup, usual
        self._target = settings.target_error or settings.target_ms or 0.0
        self._is_error = settings.target_error is not None
        # None: as many as clusters need.
        self._vpls = usual.vpls if self._is_error else settings.vpls
        parameters = FOR_ERROR if self._is_error else FOR_TIME
        if self._vpls is None:
            levels = Levels(setup.pixels, most=MOST_TIMES * usual.vpl_clusters, parameters=parameters)
        else:
            levels = levels_of(setup.pixels, self._vpls, parameters)
        self._levels = levels
        self._first_level = levels.nearest(float(usual.sp_clusters * usual.vpl_clusters))
        # A wanted error is to follow from a frame's own counts: light of frames before knows little of them.
        options = FuzzyOptions(
            most_sp_clusters=max(map(levels.most, levels.vpl_clusters)),
            passes=parameters.passes,
            keeps_light=not self._is_error,
            inspect=self._inspect if self._is_error else None,
        )
        self._method = FuzzyVpl(replace(setup, sample_counts=self._counts(self._first_level)), options)
        self._kept = {self._first_level.vpl_clusters: self._method.lights}  # in the order of their last use

    def new_view(self) -> TargetedViewState:
        """One of which nothing is known yet."""
        view = self._method.new_view(TargetedViewState)
        tinted = self._setup.device_scene.features(lambertian=self._setup.settings.lambertian).part_glass
        probes = Probes(view.size, view.device, tinted=tinted) if self._is_error else None
        view.steering = Steering(self._first_level, probes)
        return view

    def _governs_apart(self, *, walks: bool) -> bool:
        """Whether frames are governed as those of a walk, apart from others: for an error all are alike."""
        return walks and not self._is_error

    def _governor(self, view: TargetedViewState) -> Governor[Any]:
        """That of a walk, or of frames that begin from nothing, whatever the last one was."""
        governors, apart = view.steering.governors, self._governs_apart(walks=view.reuses_history)
        if apart not in governors:
            level = view.steering.level
            if self._is_error:
                governors[apart] = ErrorGovernor(self._levels, self._target, level)
            else:
                aim, parameters = (STEERING_PARAMETERS.walk_aim, FOR_WALK) if apart else (1.0, None)
                governors[apart] = Governor(self._levels, TimeModel(), aim * self._target, level, parameters)
        return governors[apart]

    def show(
        self,
        once: RenderOnce,
        view: TargetedViewState,
        camera: Camera,
        accumulation: Accumulation | None,
        *,
        walks: bool,
    ) -> Frame:
        """The frame at the level chosen for it, after frames that nobody sees until the first counts meet the target.

        A frame with a wanted error that is seen to have too large a one is tried again, and the last try is shown.
        """
        steering, moves = view.steering, self._governs_apart(walks=walks)
        settles = moves not in steering.settled
        most = STEERING_PARAMETERS.settling_frames
        for number in range(most if settles else 0):
            view.shown = None  # one more of the same
            frame = once(swayed(camera, number) if moves else camera, None)
            self._setup.progress("choosing counts of clusters", number / most)
            if self._learn(view, frame, shown=False):
                break
        steering.settled.add(moves)
        frame = once(camera, accumulation)
        # A camera that comes back from swaying sees more that is new than one that walks.
        jumps = settles and moves
        if frame.stats.counts["frames"] > 1 or frame.stats.skips["unchanged_camera"] or jumps:
            return frame
        self._learn(view, frame)
        for _ in range(1, STEERING_PARAMETERS.most_tries):
            if not self._tries_again(view):
                break
            if accumulation:
                accumulation.restart()
            view.shown = None
            better = once(camera, accumulation)
            self._learn(view, better)
            frame = replace(better, stats=better.stats.after(frame.stats))
        return frame

    def render(self, view: TargetedViewState, stages: Stages, sample: int) -> None:
        """One frame at the level that was chosen for it."""
        steering = view.steering
        walks, level = view.reuses_history, self._governor(view).level
        retries, steering.wants_retry = steering.wants_retry, False
        steering.begin_frame(walks=walks)
        if sample == 0 and level != steering.level:
            if level.vpl_clusters != steering.level.vpl_clusters:
                self._lights(level, stages).known_to(view).last_sample = None
            steering.change(level, walks=walks, retries=retries)
        self._method.lights = lights = self._lights(steering.level, stages)
        lights.correction.use(steering.level.sp_clusters, steering.level.passes)
        if not steering.applied:
            view.clustering.use(steering.level.sp_clusters, at_once=self._is_error)
            steering.applied = True
        self._method.render(view, stages, sample)

    def _lights(self, level: Level, stages: Stages) -> ClusteredLights:
        """The lights of `level`, made when they are not kept; graphs of those that go are freed."""
        number = level.vpl_clusters
        lights = self._kept.pop(number, None)
        if lights is None:
            if len(self._kept) == KEPT_LIGHTS:  # before the new ones take memory
                stages.forget(self._kept.pop(next(iter(self._kept))).number)
            lights = self._method.make_lights(self._counts(level))
        self._kept[number] = lights
        return lights

    def _inspect(self, view: FuzzyViewState, frame: FrameArrays, vpls: VplClusters, stages: Stages) -> None:
        """Estimate the error of a frame's indirect light."""
        if isinstance(view, TargetedViewState) and (probes := view.steering.probes):
            again = view.steering.is_retry
            picture = picture_of(frame.gbuffer, frame.size, view.points, frame.indirect.irradiance)
            stages.run("probe", lambda: probes.run(frame.scene, picture, vpls, again=again), branch=again)

    def _learn(self, view: TargetedViewState, frame: Frame, *, shown: bool = True) -> bool:
        """Choose the next frame's level by the last frame, which is ready and was the first of its view.

        An error is told by the frame's probes, a time by all that the host waits for, and learning of the last one.
        shown: whether anybody sees it: else light sets are chosen anew.

        True when the level can stay: it meets the target, or comes as near to it as any does. The first frames of a
        level in a walk have more new clusters than those that follow, and take up to a fifth longer, with other lights
        three times as long: that tells nothing of them.
        """
        begun, steering = perf_counter(), view.steering
        governor, host_ms = self._governor(view), steering.host_time(frame.stats.host_ms, walks=view.walked)
        if steering.probes:
            stays = governor.learn(steering.probes.estimate())
        else:
            times = {**frame.stats.stage_ms, "host": host_ms}
            stays = steering.unlike == 0 and frame.stats.steady and governor.learn(times, anew=not shown)
        steering.learning_ms = 1e3 * (perf_counter() - begun)
        return stays

    def _tries_again(self, view: TargetedViewState) -> bool:
        """Whether the last frame that was learnt of is seen to have too large an error, and other counts promise less.

        The next frame has these counts then.
        """
        governor, steering = self._governor(view), view.steering
        steering.wants_retry = isinstance(governor, ErrorGovernor) and governor.try_again(steering.level)
        return steering.wants_retry

    def count(self, view: TargetedViewState) -> None:
        """As `fuzzy-vpl` does."""
        self._method.count(view)

    def statistics(self, view: TargetedViewState) -> FrameStatistics:
        """Those of `fuzzy-vpl`."""
        return self._method.statistics(view)

    def estimates(self, view: TargetedViewState) -> dict[str, float]:
        """The target, and what a frame of the chosen level is expected to give."""
        kind, governor = "error" if self._is_error else "ms", self._governor(view)
        told = {"tries": 1.0} if self._is_error else {"passes": view.steering.level.passes}
        expected = {} if governor.expected is None else {f"expected_{kind}": governor.expected}
        return {f"target_{kind}": self._target} | expected | told

    def _counts(self, level: Level) -> SampleCounts:
        """Those of `level` with the most SP clusters of its lights."""
        vpls = self._vpls or self._usual.vpls * level.vpl_clusters // self._usual.vpl_clusters
        most = self._levels.most(level.vpl_clusters)
        return replace(self._usual, sp_clusters=most, vpl_clusters=level.vpl_clusters, vpls=vpls)
