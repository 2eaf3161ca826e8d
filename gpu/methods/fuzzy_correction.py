"""The order in which rays of single SPs correct what their clusters tell, in frames of `fuzzy-vpl`."""

from dataclasses import dataclass
from functools import cache, partial

import warp as wp

from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import Stages
from gpu.correction.adaptive_rays import BrightPoints
from gpu.correction.bias_compensation import CompensationPaths, compensate_bias
from gpu.correction.fireflies import take_fireflies
from gpu.correction.outlier_shading import Refinement
from gpu.correction.outliers import OutlierPoints
from gpu.correction.visibility_correction import Correction, RayPasses
from gpu.correction.vpl_connections import Connections, connect
from gpu.indirect.clustered_light import ClusteredLight, clustered_light
from gpu.indirect.irradiance import Indirect
from gpu.lights.light_table import LightTable
from gpu.methods.frame_arrays import FrameArrays
from gpu.methods.frame_kind import FrameKind
from gpu.methods.fuzzy_view_state import FuzzyViewState, KeptLight
from gpu.vpl.bound_area import BoundAreas
from gpu.vpl.vpl_clusters import VplClusters
from gpu.vpl.vpl_lobes import VplLobes


@dataclass(frozen=True)
class Convergence:
    """What a still view's later frames are lit by: emitters and a light set.

    lobes: of that set's VPLs; bounds, areas (vpl,): what these are bounded by, read from another set; bounces: the most
    surfaces that light meets before an SP; seed: of all frames' paths.
    """

    table: LightTable
    vpls: VplClusters
    lobes: VplLobes
    bounds: BoundAreas
    areas: wp.array
    bounces: int
    seed: int


@dataclass(frozen=True)
class FuzzyCorrectionParameters:
    """How many SPs have more rays.

    suspected, refined: SPs that may be far too bright, and those of them with many rays of their own, per SP cluster;
    bright: SPs that may be brightest and so have more rays, per SP cluster.
    refining_passes: later frames of a still view have so many times CHECKS rays of each SP: what these find is most of
    their mean's noise.
    """

    suspected: float = 2.0
    refined: float = 0.75
    bright: float = 4.0
    refining_passes: int = 3


FUZZY_CORRECTION_PARAMETERS = FuzzyCorrectionParameters()
# Beyond all passes that a frame may have of all SPs, so that suspects' rays are the same however many that are.
SUSPECTS_PASS = range(64, 65)


class FuzzyCorrection:
    """Corrects the irradiance in `frame` after shading.

    passes: the most there may be of SPs' rays, in frames that are captured. clustered_irradiance (pixel,): as clusters
    tell it, which stays while stages correct it. suspected, refined, bright: the SPs that have more rays.
    """

    def __init__(
        self,
        frame: FrameArrays,
        passes: int,
        sp_clusters: int,
        vpl_clusters: int,
        shared: "FuzzyCorrection | None" = None,
        quality: FuzzyCorrectionParameters = FUZZY_CORRECTION_PARAMETERS,
    ) -> None:
        """With lists for so many clusters; shared: another, whose arrays of the image's size serve this one, too."""
        self._frame, self._passes, device = frame, passes, frame.device
        self._most, self._in_use, self._quality = sp_clusters, (0, 0.0), quality
        self._rays: Correction
        self.clustered_irradiance: wp.array
        if shared:
            self._rays, self.clustered_irradiance = shared._rays, shared.clustered_irradiance
        else:
            DEVICE_SHARING.pause()
            self._rays = Correction(frame.pixels, device, passes, tinted=frame.features.part_glass)
            DEVICE_SHARING.pause()
            self.clustered_irradiance = wp.zeros(frame.pixels, dtype=wp.vec3, device=device)
        suspects, worst = (int(sp_clusters * share) for share in (quality.suspected, quality.refined))
        self.suspected = OutlierPoints(frame.pixels, suspects, device)
        self.refined = OutlierPoints(self.suspected.capacity, worst, device)
        tinted = frame.features.part_glass
        self.bright = BrightPoints(frame.size, int(quality.bright * sp_clusters), device, tinted=tinted)
        self._refinement = Refinement(self.refined.capacity, vpl_clusters, device, tinted=tinted)

    def use(self, sp_clusters: int, passes: float) -> None:
        """Have as many SPs with more rays as suit so many SP clusters, and `passes` of rays of all, in the mean."""
        if self._in_use == (sp_clusters, passes):
            return
        self._in_use = sp_clusters, passes
        self._rays.use(passes)
        self.suspected.limit(int(sp_clusters * self._quality.suspected))
        self.refined.limit(int(sp_clusters * self._quality.refined))
        self.bright.limit(int(sp_clusters * self._quality.bright))

    def remember(self, view: FuzzyViewState) -> None:
        """Keep what clusters tell, and how bright that makes the picture."""
        frame, irradiance = self._frame, self._frame.indirect.irradiance
        wp.copy(self.clustered_irradiance, irradiance)
        frame.brightness.find(frame.gbuffer, view.points, irradiance)

    def run(self, view: FuzzyViewState, kept: KeptLight, vpls: VplClusters, kind: FrameKind, stages: Stages) -> None:
        """Correct all SPs by a few rays each, which neighbours share; then those for whom that is wrong or too
        little.
        """
        frame, history, points = self._frame, view.histories.indirect, view.points
        scene, gbuffer, indirect, seed = frame.scene, frame.gbuffer, frame.indirect, frame.seed
        passes, as_wanted = (self._quality.refining_passes, False) if kind.refines else (self._passes, True)
        settled = history.settled if kind.denoise else frame.nothing

        @cache
        def light() -> tuple[ClusteredLight, Indirect]:  # which graphs do not ask for
            return clustered_light(view.clustering.clusters, kept.visibility.words, vpls, kept.far.data), indirect

        def correct() -> None:
            rays = self._rays
            trace = partial(rays.trace, scene, gbuffer)
            if as_wanted and passes > 1:
                stages.join()
            trace(points, *light(), RayPasses(seed, settled, range(passes), as_wanted=as_wanted))
            filtered = rays.own
            if kind.denoise:
                residual = history.take_light(points, indirect.irradiance, rays.own)
                guide = indirect.irradiance, residual, history.frames
                filtered = frame.smoothing.share(gbuffer, points, *guide, nearer_on_detail=True)
                rays.bound(points, indirect.irradiance, history.frames, filtered)
                dispute = view.clustering.deficit, indirect.irradiance, rays.own, filtered, frame.brightness
                self.suspected.find(points, gbuffer, *dispute)
                trace(self.suspected, *light(), RayPasses(seed, settled, SUSPECTS_PASS))
                self.refined.find(self.suspected, gbuffer, *dispute)
            points.add(filtered, indirect.irradiance)

        def bright_rays() -> None:
            self.bright.trace(scene, gbuffer, points, *light(), seed, frame.brightness)

        def refine() -> None:
            self._refinement.run(scene, gbuffer, self.refined, vpls, seed, indirect.irradiance)

        def bright() -> None:
            before = history.frames, history.light
            self.bright.take(gbuffer, vpls, self.clustered_irradiance, *before, indirect.irradiance)

        if kind.denoise:
            stages.fork("bright", "rays", bright_rays, repeats=kind.captured)
        stages.run("correct", correct, repeats=kind.captured)
        if kind.denoise:
            stages.run("refine", refine, repeats=kind.captured)
            stages.run("bright", bright, repeats=kind.captured, waits_for_fork=True)

    def converge(self, view: FuzzyViewState, kept: KeptLight, lights: Convergence, kind: FrameKind,
                 stages: Stages) -> None:  # fmt: skip
        """In place of all that `run` corrects and of near-field light: what is right in the mean over light sets."""
        frame, points = self._frame, view.points
        known = clustered_light(view.clustering.clusters, kept.visibility.words, lights.vpls, kept.far.data)
        rays, paths = Connections(), CompensationPaths()
        rays.passes, rays.areas, rays.seed = self._quality.refining_passes, lights.areas, kind.seed
        paths.bounds, paths.areas, paths.bounces = lights.bounds, lights.areas, lights.bounces
        paths.sample, paths.seed = kind.sample, lights.seed
        rays.lobes = paths.lobes = lights.lobes

        def connected() -> None:
            connect(frame.scene, frame.gbuffer, points, known, frame.indirect, self._rays.rays, rays)

        def near() -> None:
            irradiance, excess = frame.indirect.irradiance, self._rays.own
            inputs = frame.gbuffer, points, lights.vpls, paths, irradiance
            compensate_bias(frame.scene, lights.table, *inputs, frame.features)
            take_fireflies(points, kind.sample, frame.indirect, excess)
            points.add(frame.smoothing.spread(frame.gbuffer, points, excess), irradiance)

        stages.run("connect", connected, repeats=False)
        stages.run("paths", near, repeats=False)
