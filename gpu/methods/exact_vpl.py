"""`exact-vpl`: every VPL with a shadow ray of its own from every pixel. The reference for errors of clustering.

With VPLs clustered and SPs not (the ablation of the 2022 paper, section 4.3) it gathers VPL clusters instead.
"""

from typing import Any

from gpu.core.reduce import Counter
from gpu.core.stages import Stages, new_number
from gpu.device_scene.data import NO_HIT
from gpu.indirect.exact_gather import gather
from gpu.methods.caustics import caustics_of
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import frame_kind
from gpu.methods.light_making import keeps_lights, light_set_choice, make_lights
from gpu.methods.method import FrameStatistics, RenderMethod, RenderSetup
from gpu.methods.passes import Passes, traces_lobes
from gpu.methods.view_state import ViewState
from gpu.settings import Clustering, Component
from gpu.vpl.build import no_clusters, unclustered
from gpu.vpl.light_set import LightSet
from gpu.vpl.vpl_clusters import VplClusters
from gpu.vpl.vpl_lobes import lobes_of

# Rays a launch: few hundredths of a second on a GPU, and often enough for progress on a CPU.
RAYS_PER_LAUNCH = 1 << 25
RAYS_PER_CPU_LAUNCH = 1 << 22


class ExactVpl(RenderMethod[ViewState]):
    """Steps 1 and 3 of the 2022 paper, then Eq. 5 (or Eq. 6 with exact visibility, for VPL clusters)."""

    stage_names = ("pilot", "portals", "light", "vpl-clusters", "radiosity", "relight", "gbuffer", "caustic-photons",
                   "gather", "direct", "caustics", "near", "interpolate", "gloss", "branches")  # fmt: skip
    pixel_bytes, view_pixel_bytes, gloss_pixel_bytes, branches_pixel_bytes = 369, 12, 44, 12

    def __init__(self, setup: RenderSetup) -> None:
        self._setup, self._gathers_clusters = setup, setup.settings.clustering is Clustering.VPLS
        # Captured graphs read its arrays, so it must live as long as they do.
        self._first_version, self._first_vpls = -1, no_clusters()
        self._first = setup.light_sets.made(light_set_choice(setup), setup.progress)
        self._use(self._first)
        settings = setup.settings
        self._frame = FrameArrays(
            setup.device_scene,
            setup.size,
            lambertian=settings.lambertian,
            skip=settings.skip,
            traces_lobes=traces_lobes(settings),
        )
        self._passes = Passes(setup, self._frame)
        self._caustics = caustics_of(setup, self._frame)
        self._counter = Counter(2, setup.device)

    def new_view(self) -> ViewState:
        """One whose frames leave nothing to the next."""
        return ViewState(self._setup.device_scene, self._setup.size)

    def _use(self, light_set: LightSet) -> None:
        """Have in `_vpls` and `_cache` those of a light set."""
        settings = self._setup.settings
        if light_set is not self._first:
            self._vpls = self._vpls_of(light_set)
        elif self._first_version == light_set.version:
            self._vpls = self._first_vpls
        else:
            self._vpls = self._first_vpls = self._vpls_of(light_set)
            self._first_version, self._number = light_set.version, new_number()
        self._has_indirect = settings.component is not Component.DIRECT and light_set.count > 0
        self._has_near = self._has_indirect and settings.near_field
        self._cache: Any = self._setup.light_sets.radiosity(light_set) if self._has_near else None

    def _vpls_of(self, light_set: LightSet) -> VplClusters:
        clusters = light_set.clusters
        return clusters if self._gathers_clusters else unclustered(self._setup.device_scene, clusters)

    def render(self, view: ViewState, stages: Stages, sample: int) -> None:
        """Direct light, then all VPLs in runs."""
        frame, passes, points = self._frame, self._passes, self._frame.shading_points
        kind = frame_kind(self._setup.settings, view, sample)
        light_set = self._first
        if sample > 0:
            light_set = self._setup.light_sets.at(light_set_choice(self._setup, sample))
        self._kept = keeps_lights(self._setup, light_set)
        if not self._kept:
            make_lights(self._setup, light_set, stages, captured=kind.captured)
        self._use(light_set)
        stages.graph_key = view.number, self._number, *self._first.numbers
        passes.begin(view, points, kind, stages)
        if self._caustics:
            self._caustics.begin(points, kind, stages)
            self._caustics.fill(points, kind, stages)
        passes.begin_direct(view, kind, stages)
        passes.begin_gloss(view, self._cache, kind, stages)
        if self._has_indirect:
            if self._has_near:
                passes.begin_near(points, self._vpls, self._cache, kind, stages)
            stages.run("gather", self._gather, repeats=False)
            if self._has_near:
                passes.share_near(points, frame.indirect.irradiance, kind, stages)
        passes.end_direct(view, kind, stages)
        if self._caustics:
            self._caustics.end(view, kind, stages)
        if self._has_indirect:
            passes.end_indirect(view, points, kind, stages, near=self._has_near)
        passes.end_gloss(view, self._cache, kind, stages)

    def _gather(self) -> None:
        frame, count = self._frame, self._vpls.count
        rays = RAYS_PER_LAUNCH if frame.device.is_cuda else RAYS_PER_CPU_LAUNCH
        run = max(1, rays // frame.pixels)
        frame.indirect.irradiance.zero_()
        lobes = None if self._gathers_clusters else lobes_of(frame.scene, frame.features, self._vpls.members)
        for begin in range(0, count, run):
            end = min(begin + run, count)
            gather(frame.scene, frame.gbuffer, frame.shading_points, self._vpls, begin, end, frame.indirect, lobes)
            self._setup.progress("gathering virtual point lights", end / count)

    def count(self, view: ViewState) -> None:
        """Count near-field finds and pixels that see nothing."""
        self._counter.run([(self._passes.near_field.found, 0)], [(self._frame.gbuffer.face, int(NO_HIT))])
        if self._caustics:
            self._caustics.count()

    def statistics(self, view: ViewState) -> FrameStatistics:
        """VPLs and VPL clusters that were gathered, each of them, and rays that found near-field light."""
        vpls = self._vpls.members.count if self._vpls.count else 0
        near, empty = self._counter.totals()
        counts = {"vpls": vpls, "vpl_clusters": self._vpls.count, "sp_clusters": self._setup.pixels}
        skips = {**self._passes.skips(), "unchanged_lights": vpls if self._kept else 0}
        if self._caustics:
            counts |= self._caustics.counts()
        return counts | {"near": near, "unassigned": 0, "empty": empty}, skips
