"""`exact-vpl`: every VPL with a shadow ray of its own from every pixel. The reference for errors of clustering.

With VPLs clustered and SPs not (the ablation of the 2022 paper, section 4.3) it gathers VPL clusters instead.
"""

from gpu.core.reduce import Counter
from gpu.core.stages import Stages
from gpu.device_scene.data import NO_HIT
from gpu.indirect.exact_gather import gather
from gpu.indirect.near_field import NearField
from gpu.methods.passes import (
    FrameStatistics,
    add_indirect,
    fork_direct,
    fork_near,
    fork_near_sharing,
    frame_seed,
    join_direct,
    keeps_lights,
    light_set_choice,
    view_skips,
)
from gpu.methods.view_state import ViewState
from gpu.sample_counts import SampleCounts
from gpu.settings import Component, Method, RenderSettings
from gpu.vpl.build import unclustered
from gpu.vpl.light_sets import LightSets, Progress
from gpu.vpl.radiosity_cache import RadiosityCache
from gpu.vpl.vpl_clusters import VplClusters

# Rays a launch: a fraction of a second on a GPU, and often enough for progress on a CPU.
RAYS_PER_LAUNCH = 1 << 28
RAYS_PER_CPU_LAUNCH = 1 << 22


class ExactVpl:
    """Steps 1 and 3 of the 2022 paper, then Eq. 5 (or Eq. 6 with exact visibility, for VPL clusters)."""

    def __init__(
        self,
        view: ViewState,
        settings: RenderSettings,
        sample_counts: SampleCounts,
        light_sets: LightSets,
        progress: Progress,
    ) -> None:
        self._view, self._settings, self._sample_counts, self._light_sets = view, settings, sample_counts, light_sets
        self._first = self._vpls = self._light(0, progress)
        self._has_indirect = settings.component is not Component.DIRECT and self._vpls.count > 0
        # Captured graphs read it, so it must live as long as they do.
        self._first_lit = self._lit(0, progress) if self._has_indirect else None
        self._near_field = NearField(view.pixels, view.side_smoothing, view.device)
        self._counter = Counter(2, view.device)

    def _light(self, sample: int, progress: Progress) -> VplClusters:
        vpls = self._light_sets.clusters(light_set_choice(self._settings, self._sample_counts, sample), progress)
        return unclustered(self._view.device_scene, vpls) if self._settings.method is Method.EXACT_VPL else vpls

    def _lit(self, sample: int, progress: Progress) -> "RadiosityCache | None":
        if not self._settings.near_field:
            return None
        return self._light_sets.radiosity(light_set_choice(self._settings, self._sample_counts, sample), progress)

    def render(self, stages: Stages, sample: int, progress: Progress) -> None:
        """Direct light, then all VPLs in runs."""
        choice = light_set_choice(self._settings, self._sample_counts, sample)
        self._kept = keeps_lights(self._light_sets, choice, self._settings, stages, progress, held=sample == 0)
        self._vpls = self._light(sample, progress) if sample else self._first
        self._view.seed.fill_(frame_seed(self._settings.seed, sample))
        fork_direct(self._view, self._settings, self._sample_counts, self._light_sets.table, stages, sample)
        if self._has_indirect:
            lit = self._lit(sample, progress) if sample else self._first_lit
            near = fork_near(self._view, self._near_field, self._vpls, lit, self._settings, stages, sample)
            stages.run("gather", lambda: self._gather(progress), repeats=False)
            guide = self._view.indirect.irradiance
            fork_near_sharing(self._view, near, guide, self._settings, stages, sample)
        join_direct(self._view, self._settings, stages, sample)
        if self._has_indirect:
            add_indirect(self._view, near, self._settings, stages, sample)

    def _gather(self, progress: Progress) -> None:
        view = self._view
        rays = RAYS_PER_LAUNCH if view.device.is_cuda else RAYS_PER_CPU_LAUNCH
        run = max(1, rays // view.pixels)
        view.indirect.irradiance.zero_()
        for begin in range(0, self._vpls.count, run):
            end = min(begin + run, self._vpls.count)
            gather(view.scene, view.gbuffer, view.shading_points, self._vpls, begin, end, view.indirect)
            progress("gathering virtual point lights", end / self._vpls.count)

    def count(self) -> None:
        """Count near-field finds and pixels that see nothing."""
        self._counter.run([(self._near_field.found, 0)], [(self._view.gbuffer.face, int(NO_HIT))])

    def statistics(self) -> FrameStatistics:
        """VPLs and VPL clusters that were gathered, each of them, and rays that found near-field light."""
        vpls = self._vpls.members.count if self._vpls.count else 0
        near, empty = self._counter.totals()
        counts = {"vpls": vpls, "vpl_clusters": self._vpls.count, "sp_clusters": self._view.pixels}
        skips = view_skips(self._view, self._settings, empty)
        return counts | {"near": near, "unassigned": 0}, skips | {"unchanged_lights": vpls if self._kept else 0}
