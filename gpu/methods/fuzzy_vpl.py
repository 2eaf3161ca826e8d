"""`fuzzy-vpl`: clustered VPLs and SPs with fuzzy visibility, the 2022 paper's method."""

from copy import copy
from functools import partial

import warp as wp

from gpu.adaptive.error_probes import Probes
from gpu.adaptive.levels import MOST_PASSES
from gpu.core.reduce import Counter
from gpu.core.stages import Stages
from gpu.correction.adaptive_rays import BrightPoints
from gpu.correction.outlier_shading import Refinement
from gpu.correction.outliers import OutlierPoints
from gpu.correction.visibility_correction import Correction
from gpu.denoise.atrous import MAX_STEP_ON_DETAIL
from gpu.device_scene.data import NO_HIT
from gpu.indirect.far_field import FarSums
from gpu.indirect.fuzzy_shading import shade
from gpu.indirect.near_field import NearField
from gpu.indirect.visibility import Visibility
from gpu.methods.passes import (
    FrameStatistics,
    add_indirect,
    fork_direct,
    fork_near,
    fork_near_sharing,
    frame_number,
    frame_seed,
    is_sharper,
    is_smoothed,
    join_direct,
    keeps_light,
    keeps_lights,
    light_set_choice,
    remembers_light,
    view_skips,
)
from gpu.methods.view_state import ViewState
from gpu.sample_counts import SampleCounts
from gpu.settings import Clustering, Component, RenderSettings, Weighting
from gpu.sp.sp_clusters import UNASSIGNED_DEFICIT, SpClustering
from gpu.vpl.build import unclustered
from gpu.vpl.light_sets import LightSets, Progress

# SPs that may be far too bright, and those of them with many rays of their own, per SP cluster; what may be too bright
# by less than this, relatively, is well served.
SUSPECTED_SHARE = 2.0
REFINED_SHARE = 0.75
LEAST_DISPUTE = 0.25
# SPs that may be brightest and so have more rays, per SP cluster.
BRIGHT_SHARE = 4.0
# Frames of a still view that a light set of many VPLs serves: making it takes as long as such a frame, and sets differ
# by little beside the noise of the SPs' own rays. Those of few VPLs differ much and are soon made.
FRAMES_A_SET, MANY_VPLS = 4, 1 << 16
# Later frames of a still view correct so many times: what these rays find is most of their mean's noise.
SHARPER_PASSES = 3


class FuzzyVpl:
    """The six steps of the 2022 paper, section 3.1; steps 1 and 2 happened when the light set was made."""

    def __init__(
        self,
        view: ViewState,
        settings: RenderSettings,
        sample_counts: SampleCounts,
        light_sets: LightSets,
        progress: Progress,
        most: int | None = None,
    ) -> None:
        """With as many SP clusters as `sample_counts` tells, or fewer (`use`); most: of those in any lights
        (`relit`).
        """
        self._view, self._settings, self._light_sets = view, settings, light_sets
        # The ablation without VPL clusters keeps its VPLs: another set of them may not fit its arrays.
        self._fixed = settings.clustering is Clustering.SPS
        # A wanted error is to follow from a frame's own counts: light of frames before knows little of them.
        self._shares_light = settings.target_error is None
        sps, by_distance = view.shading_points, settings.weighting is Weighting.DISTANCE
        most = most or sample_counts.sp_clusters
        self._clustering = SpClustering(sps, most, settings.fuzziness, by_distance=by_distance)
        self._passes = MOST_PASSES if settings.target_ms else 1
        self._correction = Correction(view.pixels, view.device, self._passes)
        # Irradiance as clusters tell it, while other stages correct it.
        self._told = wp.zeros(view.pixels, dtype=wp.vec3, device=view.device)
        self._near_field = NearField(view.pixels, view.side_smoothing, view.device)
        self._counter = Counter(13, view.device)
        self.probes = Probes(view) if settings.target_error else None
        self._take_light(sample_counts, progress)

    def relit(self, sample_counts: SampleCounts, progress: Progress) -> "FuzzyVpl":
        """The method with other lights, and as many SP clusters as `sample_counts` tells, or fewer.

        Both share these, and the arrays of the image's size: render with one after the other.
        """
        other = copy(self)
        other._take_light(sample_counts, progress)
        return other

    def _take_light(self, sample_counts: SampleCounts, progress: Progress) -> None:
        settings, view = self._settings, self._view
        self._sample_counts = sample_counts
        vpls = self._light_sets.clusters(light_set_choice(settings, sample_counts), progress)
        # Captured graphs read the arrays of this set, so it must live as long as they do.
        self._first = unclustered(view.device_scene, vpls) if self._fixed else vpls
        self._vpls = self._first
        self._kept, self._refines = True, False
        # The number in a still view of the frame that left clusters and bits of these lights.
        self._begun: int | None = None
        # Whether the last frame built on the light of those before.
        self._remembers = False
        # Whether the next frame is another try at the last one.
        self._again = False
        self._has_indirect = settings.component is not Component.DIRECT and self._vpls.count > 0
        self._first_lit = None
        if self._has_indirect and settings.near_field:
            self._first_lit = self._light_sets.radiosity(light_set_choice(settings, sample_counts), progress)
        most = self._vpls.count if self._fixed else sample_counts.vpl_clusters
        sp_clusters = min(sample_counts.sp_clusters, self._clustering.most)
        self._visibility = Visibility(sp_clusters, most, view.device, settings.skip)
        self._far = FarSums(sp_clusters, most, view.device, enabled=settings.skip.far_field_sums)
        suspects, worst = (int(sample_counts.sp_clusters * share) for share in (SUSPECTED_SHARE, REFINED_SHARE))
        self._suspects = OutlierPoints(view.pixels, suspects, LEAST_DISPUTE, view.device)
        self._worst = OutlierPoints(self._suspects.capacity, worst, LEAST_DISPUTE, view.device)
        self._bright = BrightPoints(view.size, int(BRIGHT_SHARE * sample_counts.sp_clusters), view.device)
        self._refinement = Refinement(self._worst.capacity, most, view.device)

    def use(self, sp_clusters: int, passes: float = 1.0, *, begins: bool, again: bool = False) -> None:
        """Have so many SP clusters from the next frame on; begins: that builds on no clusters of frames before.

        passes: in which an SP's rays correct its light, in the mean, where the settings want a time; again: the next
        frame is another try at the last one. Raises ValueError where clusters are more than `sample_counts` told:
        arrays have no room for them.
        """
        if sp_clusters > self._sample_counts.sp_clusters:
            raise ValueError(f"{sp_clusters} SP clusters where there is room for {self._sample_counts.sp_clusters}")
        self._clustering.use(sp_clusters, at_once=self._settings.target_error is not None)
        self._correction.use(passes)
        self._suspects.limit(int(sp_clusters * SUSPECTED_SHARE))
        self._worst.limit(int(sp_clusters * REFINED_SHARE))
        self._bright.limit(int(sp_clusters * BRIGHT_SHARE))
        if begins:
            self._begun = None
        self._again = again and not begins

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """Direct light, then what VPLs send, which the next frame of a walk builds on."""
        view, settings = self._view, self._settings
        fork_direct(view, settings, self._sample_counts, self._light_sets.table, stages, sample)
        near = self._find_indirect(stages, sample, progress) if self._has_indirect else None
        join_direct(view, settings, stages, sample)
        if self._has_indirect:
            add_indirect(view, near, settings, stages, sample)
        if keeps_light(settings, sample):
            stages.run("keep", self._keep)
            view.kept = True

    def _keep(self) -> None:
        view = self._view
        if self._has_indirect and self._shares_light:
            view.history.keep(view.shading_points)
        view.last.keep(view.gbuffer, view.camera)

    def _set_number(self, sample: int) -> int:
        """The number of the light set of frame `sample` of a still view."""
        return 0 if self._fixed else sample // (FRAMES_A_SET if self._sample_counts.vpls >= MANY_VPLS else 1)

    def _goes_on(self, sample: int) -> bool:
        """Whether the last frame's clusters are of this one's lights, and it sees much the same.

        Of a still view's frames the smoothed ones and every FRAMES_A_SET-th begin from nothing.
        """
        if sample == 0:
            return self._begun == 0 and self._view.walks
        follows = self._view.rests and self._begun == sample - 1 and is_sharper(sample) and sample % FRAMES_A_SET != 0
        return follows and self._set_number(sample - 1) == self._set_number(sample)

    def _find_indirect(self, stages: Stages, sample: int, progress: Progress) -> NearField | None:
        """SP clusters, their visibility and indirect light, corrected by rays of the SPs; what is begun near field."""
        view, settings, clustering, repeats = self._view, self._settings, self._clustering, sample == 0
        number = self._set_number(sample)
        choice, first = light_set_choice(settings, self._sample_counts, number), number == 0
        self._kept = keeps_lights(self._light_sets, choice, settings, stages, progress, held=first)
        self._vpls, lit = self._first, self._first_lit
        if not first:
            self._vpls = self._light_sets.clusters(choice, progress)
            lit = self._light_sets.radiosity(choice, progress) if settings.near_field else None
        goes_on = self._kept and settings.skip.kept_clusters and self._goes_on(sample)
        again = self._again
        self._begun, self._again = None, False  # should this frame fail, it leaves nothing
        vpls, visibility = self._vpls, self._visibility
        fuzziness, seed, history = settings.fuzziness, view.seed, view.history
        sps, gbuffer, clusters, indirect = view.shading_points, view.gbuffer, clustering.clusters, view.indirect

        correction, far, probes, smooth = self._correction, self._far, self.probes, is_smoothed(settings, sample)
        self._refines = settings.correct and smooth
        sharper = is_sharper(sample)
        passes = SHARPER_PASSES if sharper else self._passes

        def cluster() -> None:
            if goes_on:
                clustering.go_on(gbuffer, view.camera, view.size)
            else:
                clustering.run(gbuffer, frame_seed(settings.seed, sample))

        def correct() -> None:
            check = partial(correction.trace, view.scene, gbuffer)
            by = clusters, visibility.words, vpls, far.data, indirect, history.settled, seed
            check(sps, *by, range(passes), as_wanted=not sharper)
            shared = correction.own
            if smooth:
                lacking = history.take_light(sps, indirect.irradiance, correction.own)
                light = indirect.irradiance, lacking, history.frames
                shared = view.smoothing.share(gbuffer, sps, *light, MAX_STEP_ON_DETAIL)
                dispute = gbuffer, clustering.deficit, indirect.irradiance, correction.own, shared, view.brightness
                self._suspects.find(sps, *dispute)
                check(self._suspects, *by, range(passes, passes + 1))
                self._worst.find(self._suspects, *dispute)
            sps.add(shared, indirect.irradiance, bounded=smooth)

        def refine() -> None:
            self._refinement.run(view.scene, gbuffer, self._worst, vpls, seed, indirect.irradiance)

        def bright_rays() -> None:
            inputs = clusters, visibility.words, vpls, far.data, indirect, seed
            self._bright.trace(view.scene, gbuffer, sps, *inputs, view.brightness)

        def bright() -> None:
            self._bright.take(gbuffer, vpls, self._told, history.frames, history.light, indirect.irradiance)

        remembers = self._remembers = self._shares_light and remembers_light(view, sample)
        seed.fill_(frame_seed(settings.seed, frame_number(view, sample)))
        if smooth:
            look_back = partial(history.find, gbuffer, sps, view.last, seed) if remembers else history.forget
            stages.run("history", look_back, repeats=repeats, way=remembers)
        near = fork_near(view, self._near_field, vpls, lit, settings, stages, sample)
        stages.run("cluster", cluster, repeats=repeats, way=goes_on)
        stages.run("visibility", lambda: visibility.trace(view.scene, clusters, vpls), repeats=repeats)
        self._begun = sample

        def light() -> None:
            far.run(clusters, visibility.words, vpls, few=goes_on)
            shade(fuzziness, gbuffer, sps, clusters, visibility, vpls, far.data, seed, indirect)
            if smooth:
                wp.copy(self._told, indirect.irradiance)
                view.brightness.find(gbuffer, sps, indirect.irradiance)

        stages.run("shade", light, repeats=repeats, way=goes_on)
        fork_near_sharing(view, near, self._told, settings, stages, sample)
        if self._refines:
            stages.fork("bright", "rays", bright_rays, repeats=repeats)
        if settings.correct:
            stages.run("correct", correct, repeats=repeats)
            if self._refines:
                stages.run("refine", refine, repeats=repeats)
                stages.run("bright", bright, repeats=repeats, waits_for_fork=True)
        if probes and repeats:
            stages.run("probe", lambda: probes.run(vpls, again=again), way=again)
        return near

    def count(self) -> None:
        """Sum up what the stages left, and count the pixels that see nothing."""
        view, visibility = self._view, self._visibility
        arrays = [
            (view.shading_points.count, 0),
            (self._suspects.count, 0),
            (self._worst.count, 0),
            (self._bright.count, 0),
            (visibility.rays, 0),
            (visibility.shared, 0),
            (self._clustering.clusters.used, 0),
            (self._clustering.clusters.fresh, 0),
            (view.indirect.pairs, 0),
            (view.history.known, 0),
            (self._near_field.found, 0),
            (self._clustering.deficit, UNASSIGNED_DEFICIT),
        ]
        self._counter.run(arrays if self._has_indirect else [], [(view.gbuffer.face, int(NO_HIT))])

    def statistics(self) -> FrameStatistics:
        """VPLs, clusters, SPs, those with more rays, rays of clusters, finds near field, and unserved SPs."""
        view, vpls = self._view, self._vpls.members.count if self._vpls.count else 0
        counts = {"vpls": vpls, "vpl_clusters": self._vpls.count, "sp_clusters": self._clustering.count}
        totals = self._counter.totals()
        if not self._has_indirect:
            counts |= dict.fromkeys(("shaded", "suspected", "refined", "bright", "rays", "near", "unassigned"), 0)
            return counts, view_skips(view, self._settings, totals[0])
        shaded, suspected, refined, bright, rays, shared, used, fresh, close, known, near, needs, empty = totals
        pairs = counts["vpl_clusters"] * fresh
        unassigned = needs // UNASSIGNED_DEFICIT
        skips = {
            **view_skips(view, self._settings, empty),
            "interpolated": view.pixels - shaded - empty,
            "unchanged_lights": vpls if self._kept else 0,
            "kept_clusters": counts["vpl_clusters"] * (used - fresh),
            "temporal_reuse": known if self._remembers else 0,
            "facing_away": pairs - rays - shared,
            "shared_weak_rays": shared,
            "far_field_sums": shaded * counts["vpl_clusters"] - close,
        }
        looked = {"suspected": suspected, "refined": refined, "bright": bright}
        counts |= {"shaded": shaded} | (looked if self._refines else dict.fromkeys(looked, 0))
        return counts | {"rays": rays, "near": near, "unassigned": unassigned}, skips
