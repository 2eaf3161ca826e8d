"""`path`: path tracing, the reference for the whole error of the other methods."""

from gpu.core.parameters import parameters
from gpu.core.stages import Stages
from gpu.direct.path_tracing import PathSamples, trace_paths
from gpu.methods.frame_kind import frame_seed
from gpu.methods.method import FrameStatistics, RenderMethod, RenderSetup
from gpu.methods.view_state import ViewState
from gpu.settings import Component

# Paths a launch: few hundredths of a second on a GPU, and often enough for progress on a CPU.
PATHS_PER_LAUNCH = 1 << 21
PATHS_PER_CPU_LAUNCH = 1 << 19


class PathTracing(RenderMethod[ViewState]):
    """Camera paths with direct light sampled at every bounce (Kajiya 1986), `samples` of them a pixel."""

    stage_names = ("paths",)
    pixel_bytes, view_pixel_bytes, specular_pixel_bytes, caustic_photon_bytes = 3, 12, 0, 0
    lamps_pixel_bytes = 0

    def __init__(self, setup: RenderSetup) -> None:
        self._setup, self._table = setup, setup.light_sets.table
        lambertian = setup.settings.lambertian
        self._scene = setup.device_scene.view(lambertian=lambertian)
        self._features = setup.device_scene.features(lambertian=lambertian)
        setup.progress("path tracing needs no virtual point lights", 1.0)

    def new_view(self) -> ViewState:
        """One with a picture and nothing else."""
        return ViewState(self._setup.device_scene, self._setup.size)

    def render(self, view: ViewState, stages: Stages, sample: int) -> None:
        """Average all samples, some a launch."""
        seed = frame_seed(self._setup.settings.seed, sample)
        stages.run("paths", lambda: self._trace(view, seed), repeats=False)

    def _trace(self, view: ViewState, seed: int) -> None:
        setup, settings, all_samples = self._setup, self._setup.settings, self._setup.sample_counts.samples
        most = PATHS_PER_LAUNCH if setup.device.is_cuda else PATHS_PER_CPU_LAUNCH
        run = max(1, most // setup.pixels)
        for first in range(0, all_samples, run):
            samples = min(run, all_samples - first)
            paths = parameters(
                PathSamples,
                count=samples,
                before=first,
                bounces=setup.bounces,
                direct=settings.component is not Component.INDIRECT,
                indirect=settings.component is not Component.DIRECT,
                seed=seed,
            )
            trace_paths(self._scene, self._table, view.camera, setup.size, paths, view.radiance, self._features)
            setup.progress("tracing paths", (first + samples) / all_samples)

    def statistics(self, view: ViewState) -> FrameStatistics:
        """Camera paths a pixel; nothing is skipped in a reference."""
        return {"samples": self._setup.sample_counts.samples}, {}
