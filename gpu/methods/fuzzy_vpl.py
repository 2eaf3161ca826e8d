"""`fuzzy-vpl`: clustered VPLs and SPs with fuzzy visibility, the 2022 paper's method."""

from gpu.check import ClusterCheck
from gpu.counting import Counter
from gpu.dispute import WorstPoints
from gpu.lighting import Lighting, Progress
from gpu.methods.common import FrameStatistics, frame_seed, keeps_lights, lighting_choice, render_direct, view_skips
from gpu.quality import Quality
from gpu.refine import Refinement
from gpu.resident import NO_HIT
from gpu.settings import Clustering, Component, RenderSettings
from gpu.shade import shade
from gpu.sp_clusters import UNASSIGNED_NEED, SpClustering
from gpu.stages import Stages
from gpu.view import View
from gpu.visibility import Visibility
from gpu.vpl_clusters import unclustered

# SPs with rays of their own, per SP cluster; what may be too bright by less than this, relatively, is well served.
REFINED_SHARE = 1.5
LEAST_DISPUTE = 0.25


class FuzzyVpl:
    """The six steps of the 2022 paper, section 3.1; steps 1 and 2 happened when the light set was made."""

    def __init__(
        self, view: View, settings: RenderSettings, quality: Quality, lighting: Lighting, progress: Progress
    ) -> None:
        self._view, self._settings, self._quality, self._lighting = view, settings, quality, lighting
        vpls = lighting.clusters(lighting_choice(settings, quality), progress)
        # The ablation without VPL clusters keeps its VPLs: another set of them may not fit its arrays.
        self._fixed = settings.clustering is Clustering.SPS
        # Captured graphs read the arrays of this set, so it must live as long as they do.
        self._first = unclustered(view.resident, vpls) if self._fixed else vpls
        self._vpls = self._first
        self._kept = True
        self._has_indirect = settings.component is not Component.DIRECT and self._vpls.count > 0
        self._clustering = SpClustering(
            view.pixels, quality.sp_clusters, settings.fuzziness, settings.weighting, view.device
        )
        most = self._vpls.count if self._fixed else quality.vpl_clusters
        self._visibility = Visibility(self._clustering.count, most, view.device, settings.skip)
        refined = int(quality.sp_clusters * REFINED_SHARE)
        self._check = ClusterCheck(view.pixels, view.device)
        self._worst = WorstPoints(view.pixels, refined, LEAST_DISPUTE, view.device)
        self._refinement = Refinement(len(self._worst.pixels), view.device)
        self._counter = Counter(6, view.device)

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """Direct light, then SP clusters, their visibility and indirect light, exact where clusters disagree."""
        view, settings, clustering, repeats = self._view, self._settings, self._clustering, sample == 0
        render_direct(view, settings, self._quality, self._lighting.table, stages, sample)
        if not self._has_indirect:
            return
        choice = lighting_choice(settings, self._quality, 0 if self._fixed else sample)
        first = self._fixed or repeats
        self._kept = keeps_lights(self._lighting, choice, settings, stages, progress, held=first)
        self._vpls = self._first
        if not first:
            self._vpls = self._lighting.clusters(choice, progress)
        vpls = self._vpls
        seed, fuzziness = frame_seed(settings.seed, sample), settings.fuzziness
        sps, gbuffer, clusters = view.shading_points, view.gbuffer, clustering.clusters

        def shade_all() -> None:
            view.indirect.radiance.zero_()
            shade(fuzziness, gbuffer, sps.pixels, sps.count, clusters, self._visibility, vpls, view.indirect)

        def check() -> None:
            self._check.run(view.scene, gbuffer, sps, clusters, self._visibility, vpls, view.indirect)
            self._worst.find(sps, clustering.need, view.indirect, self._check.stopped)

        def refine() -> None:
            self._refinement.run(view.scene, gbuffer, self._worst, vpls, view.indirect)
            view.add_indirect()

        stages.run("cluster", lambda: clustering.run(sps, gbuffer, seed), repeats=repeats)
        stages.run("visibility", lambda: self._visibility.trace(view.scene, clusters, vpls), repeats=repeats)
        stages.run("shade", shade_all, repeats=repeats)
        stages.run("check", check, repeats=repeats)
        stages.run("refine", refine, repeats=repeats)

    def statistics(self) -> FrameStatistics:
        """VPLs, clusters, rays between representatives, SPs with rays of their own, and SPs that nothing serves."""
        view, vpls = self._view, self._vpls.members.count if self._vpls.count else 0
        seen = [(view.gbuffer.face, int(NO_HIT))]
        counts = {"vpls": vpls, "vpl_clusters": self._vpls.count, "sp_clusters": self._clustering.count}
        if not self._has_indirect:
            (empty,) = self._counter.sums([], seen)
            return counts | {"rays": 0, "refined": 0, "unassigned": 0}, view_skips(view, self._settings, empty)
        visibility = self._visibility
        rays, shared, used, refined, needs, empty = self._counter.sums(
            [
                (visibility.rays, 0),
                (visibility.shared, 0),
                (self._clustering.clusters.used, 0),
                (self._worst.count, 0),
                (self._clustering.need, UNASSIGNED_NEED),
            ],
            seen,
        )
        pairs = counts["vpl_clusters"] * used
        unassigned = max(0, needs // UNASSIGNED_NEED - refined)
        skips = {
            **view_skips(view, self._settings, empty),
            "unchanged_lights": vpls if self._kept else 0,
            "facing_away": pairs - rays - shared,
            "weak_pairs": shared,
        }
        return counts | {"rays": rays, "refined": refined, "unassigned": unassigned}, skips
