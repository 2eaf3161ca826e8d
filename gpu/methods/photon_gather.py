"""`photon-gather`: photon mapping with a final gather at the centres of shading clusters, by the 2009 paper.

All light is made anew in each frame, so light, camera and scene may change between two. Only the places where it is
gathered are kept in a walk.
"""

from functools import partial

import warp as wp

from gpu.core.device import duplicate
from gpu.core.reduce import Counter
from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages, new_number
from gpu.device_scene.data import NO_HIT
from gpu.indirect.cut_lookup import CutLight
from gpu.indirect.final_gather import FinalGather
from gpu.indirect.gathered_directions import GlossyReceivers, glossy_receivers, project_radiance
from gpu.indirect.irradiance_interpolation import allocate_weights, interpolate_irradiance, weigh_centres
from gpu.indirect.light_behind import join_sides, trace_behind_by_photons
from gpu.indirect.photon_lookup import FullMapLight
from gpu.lights.light_table import LightTable, PowerCdf
from gpu.lights.path_ends import paths_for, pilot_of
from gpu.lights.photon_map import PhotonMap
from gpu.lights.photon_tree import allocate_tree, build_tree
from gpu.methods.caustics import caustics_of
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import FrameKind, frame_kind
from gpu.methods.gather_view_state import GatherViewState
from gpu.methods.method import FrameStatistics, RenderMethod, RenderSetup
from gpu.methods.passes import Passes
from gpu.sample_counts import SampleCounts
from gpu.settings import Component
from gpu.sp.shading_clusters import ShadingClustering
from gpu.vpl.emitter_importance import important_emitters


class PhotonGather(RenderMethod[GatherViewState]):
    """The stages of the 2009 paper's Fig. 2."""

    stage_names = (
        "gbuffer",
        "caustic-photons",
        "photons",
        "illumination",
        "gather",
        "irradiance",
        "direct",
        "caustics",
        "interpolate",
        "gloss",
        "branches",
    )
    pixel_bytes, view_pixel_bytes = 508, 12
    gloss_pixel_bytes = branches_pixel_bytes = 12

    def __init__(self, setup: RenderSetup) -> None:
        settings, counts = setup.settings, setup.sample_counts
        self._setup = setup
        # As of the scene's, but that paths begin where they matter: at other emitters, in arrays of its own.
        self._table = duplicate(LightTable, setup.light_sets.table)
        self._table.all_emitters = duplicate(PowerCdf, self._table.all_emitters)
        self._table.all_emitters.cumulative = wp.zeros_like(self._table.all_emitters.cumulative)
        self._frame = FrameArrays(setup.device_scene, setup.size, lambertian=settings.lambertian, skip=settings.skip)
        self._passes = Passes(setup, self._frame)
        self._caustics = caustics_of(setup, self._frame)
        self._counter = Counter(1, setup.device)
        DEVICE_SHARING.pause()
        self._clustering = ShadingClustering(self._frame.shading_points, counts.sp_clusters)
        self._weights = allocate_weights(setup.pixels, setup.device)
        self._receivers = None
        if self._frame.features.gloss:
            # What their narrow lobes and clear coats reflect is left out of what they reflect of even light.
            self._frame.gbuffer.traces_gloss = self._frame.shows_coats = True
            self._receivers = glossy_receivers(self._frame.gbuffer, self._clustering.most)
        self._version = self._paths = -1
        self._follow_lights()
        setup.progress("photons are traced in each frame", 1.0)

    def _follow_lights(self) -> None:
        """Have as many light paths as leave the photons that are wanted of the scene's lights as they are."""
        setup, frame, settings, sets = self._setup, self._frame, self._setup.settings, self._setup.light_sets
        if self._version == sets.version:
            return
        paths = 0
        if settings.component is not Component.DIRECT:
            important = important_emitters(setup.device_scene, frame.scene, sets.table)
            wp.copy(self._table.all_emitters.cumulative, important.cumulative)
            inputs = setup.device_scene, frame.scene, self._table, setup.sample_counts.photons, setup.bounces
            pilot = pilot_of(setup.bounces, setup.device, arriving=True)
            paths = paths_for(*inputs, frame.features, pilot=pilot)
        self._has_indirect, self._version = paths > 0, sets.version
        if paths == self._paths:
            return
        self._paths, self._number = paths, new_number()
        if paths > 0:
            self._map = PhotonMap(paths, setup.bounces, setup.device)
            cut, photons = settings.cut_nodes, setup.sample_counts.photons
            self._tree = allocate_tree(self._map.photons, photons)
            self._light = CutLight(self._tree, cut) if cut else FullMapLight(self._tree, photons)
            clusters, rays = self._clustering.clusters, setup.sample_counts.gather_rays
            self._gather = FinalGather(clusters, rays, self._light, self._table, setup.bounces)

    @staticmethod
    def cluster_bytes(sample_counts: SampleCounts) -> tuple[int, int]:
        """Of photons, about half as many places again as there are, and of clusters with their rays, as if there were
        gloss; of a cut next to nothing.
        """
        rays = sample_counts.sp_clusters * sample_counts.gather_rays
        return 241 * sample_counts.photons + 475 * sample_counts.sp_clusters + 43 * rays, 52 * sample_counts.sp_clusters

    def new_view(self) -> GatherViewState:
        """One whose walk keeps the places where light is gathered."""
        return GatherViewState(self._setup.device_scene, self._setup.size, self._clustering.most)

    def render(self, view: GatherViewState, stages: Stages, sample: int) -> None:
        """Direct light, beside photons, their illumination and what is gathered of it.

        So are clusters, where their rays end and what they count for: these need no light, and as photons stop a GPU
        gets idle.
        """
        frame, passes, points = self._frame, self._passes, self._frame.shading_points
        kind = frame_kind(self._setup.settings, view, sample)
        self._follow_lights()
        stages.graph_key = view.number, self._number
        passes.begin(view, points, kind, stages)
        if self._caustics:
            self._caustics.begin(points, kind, stages)
            self._caustics.fill(points, kind, stages)
        if self._has_indirect:
            self._begin_gather(view, kind, stages)
        passes.begin_direct(view, kind, stages)
        if self._has_indirect:
            stages.run("photons", self._trace)
            stages.run("illumination", lambda: self._light.estimate(frame.scene))
            stages.run("gather", self._gather_light, waits_for_fork=True)
            stages.run("irradiance", self._interpolate, waits_for_fork=True)
        passes.end_direct(view, kind, stages)
        if self._caustics:
            self._caustics.end(view, kind, stages)
        if self._has_indirect:
            passes.end_indirect(view, points, kind, stages, near=False)
        if self._receivers is not None:
            stages.run("gloss", partial(self._add_gloss, view, kind, self._receivers), branch=kind.refines)
        passes.add_branches(view, kind, self._light if self._has_indirect else None, stages)

    def _add_gloss(self, view: GatherViewState, kind: FrameKind, receivers: GlossyReceivers) -> None:
        if self._has_indirect and not self._frame.chain_samples.lobes:
            self._frame.shading_points.add(receivers.light, view.radiance)
        self._passes.add_coats(view, kind, None, self._light if self._has_indirect else None)

    def _trace(self) -> None:
        self._map.trace(self._frame.scene, self._table, self._frame.seed, self._frame.features)
        build_tree(self._tree)

    def _begin_gather(self, view: GatherViewState, kind: FrameKind, stages: Stages) -> None:
        """Clusters about the centres of the walk's last frame and new ones, or all anew; and where their rays end."""
        clustering, frame, walks, skip = self._clustering, self._frame, kind.sample == 0, self._setup.settings.skip
        goes_on = walks and view.reuses_history and view.keeps_centres and skip.kept_clusters
        seen = frame.gbuffer, frame.seed

        def rays() -> None:
            if goes_on:
                clustering.go_on(*seen, view.centres, view.camera, frame.size)
            else:
                clustering.run(*seen, view.centres if walks else None)
            self._gather.trace(frame.scene, frame.seed, frame.features)

        def weights() -> None:
            centres, least = clustering.grid.data, self._gather.gathered.least_distance
            weigh_centres(frame.scene, clustering.points, centres, least, self._weights)

        stages.fork("gather", "rays", rays, branch=(goes_on, walks))
        stages.fork("irradiance", "weights", weights)
        view.keeps_centres |= walks

    def _gather_light(self) -> None:
        frame, gather, receivers = self._frame, self._gather, self._receivers
        gather.read(frame.scene, frame.seed, frame.features)
        if receivers is not None:
            inputs = self._clustering.clusters, gather.order, frame.seed, gather.gathered
            project_radiance(*inputs, receivers.coefficients)

    def _interpolate(self) -> None:
        listed, irradiance = self._frame.shading_points.points, self._frame.indirect.irradiance
        interpolate_irradiance(listed, self._weights, self._gather.gathered, irradiance, self._receivers)
        if self._frame.features.translucent:
            self._join_sides(irradiance)

    def _join_sides(self, irradiance: wp.array) -> None:
        """Add what comes from behind, shared between neighbours."""
        frame, points, light = self._frame, self._frame.shading_points, self._passes.near_field.light
        seen = frame.scene, frame.gbuffer, points
        trace_behind_by_photons(*seen, self._light, frame.seed, light, frame.features)
        if self._setup.settings.smooth:
            light = frame.smoothing.share(*seen[1:], irradiance, light, frame.nothing, nearer_on_detail=False)
        join_sides(frame.gbuffer, points, light, irradiance)

    def count(self, view: GatherViewState) -> None:
        """Count pixels that see nothing."""
        self._counter.run([], [(self._frame.gbuffer.face, int(NO_HIT))])
        if self._caustics:
            self._caustics.count()

    def statistics(self, view: GatherViewState) -> FrameStatistics:
        """Photons at most, clusters, and rays of each."""
        (empty,) = self._counter.totals()
        counts = {"photons": 0, "sp_clusters": 0, "gather_rays": 0, "empty": empty}
        if self._has_indirect:
            rays = self._clustering.most * self._setup.sample_counts.gather_rays
            counts |= {"photons": self._map.capacity, "sp_clusters": self._clustering.most, "gather_rays": rays}
        if self._caustics:
            counts |= self._caustics.counts()
        return counts, self._passes.skips()
